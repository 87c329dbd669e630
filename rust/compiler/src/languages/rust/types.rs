// SPDX-License-Identifier: Apache-2.0
//! Types in Rust's spelling, and their properties that are known without rustc.

use crate::diagnostics::{Code, Diagnostic};
use crate::languages::facts::LiteralKind;
use crate::syntax::ast::{Literal, TypeKind, TypeSyntax};

/// Rust's type for LF's `time`.
pub(crate) const DURATION: &str = "core::time::Duration";

/// C's types with their names in Rust.
const C_TYPES: &[(&str, &str)] = &[
    ("int", "i32"),
    ("short", "i16"),
    ("long", "i64"),
    ("unsigned", "u32"),
    ("float", "f32"),
    ("double", "f64"),
    ("void", "()"),
    ("string", "heapless::String<N>"),
    ("size_t", "usize"),
    ("int8_t", "i8"),
    ("int16_t", "i16"),
    ("int32_t", "i32"),
    ("int64_t", "i64"),
    ("uint8_t", "u8"),
    ("uint16_t", "u16"),
    ("uint32_t", "u32"),
    ("uint64_t", "u64"),
    ("instant_t", "time"),
    ("interval_t", "time"),
];

/// Returns a type in Rust's spelling.
pub(super) fn text(ty: &TypeSyntax) -> String {
    match &ty.kind {
        TypeKind::Time => DURATION.to_owned(),
        TypeKind::Code(text) => text.split_whitespace().collect::<Vec<_>>().join(" "),
        // This is the name of LF's Rust target for the type without a value.
        TypeKind::Path { segments, arguments, .. } if segments == &["unit"] && arguments.is_empty() => "()".to_owned(),
        TypeKind::Path { segments, arguments, .. } => {
            let mut text = segments.join("::");
            if !arguments.is_empty() {
                let arguments: Vec<_> = arguments.iter().map(self::text).collect();
                text = format!("{text}<{}>", arguments.join(", "));
            }
            text
        }
    }
}

/// Returns the problem of a C type.
pub(super) fn problem(ty: &TypeSyntax) -> Option<Diagnostic> {
    let TypeKind::Path { segments, c_suffix, .. } = &ty.kind else { return None };
    if let Some(suffix) = c_suffix {
        let diagnostic = Diagnostic::new(Code::Unsupported, suffix.span, "`*` and `[]` behind a type are C, not Rust");
        return Some(diagnostic.hint("write a Rust type as code: `{= [i32; 3] =}`"));
    }
    let [one] = &segments[..] else { return None };
    let (c, rust) = C_TYPES.iter().find(|(c, _)| c == one)?;
    let message = format!("`{c}` is a type of C; types here are those of Rust");
    Some(Diagnostic::new(Code::CType, ty.span, message).hint(format!("did you mean `{rust}`?")))
}

/// Returns the type of a literal without a declared type.
pub(super) fn of_literal(literal: &Literal) -> &'static str {
    match literal {
        Literal::Bool(_) => "bool",
        Literal::Int(_) => "i32",
        Literal::Float(_) => "f64",
        Literal::Character(_) => "char",
        Literal::Text(_) => "&'static str",
    }
}

/// Returns the kind of literals that a simple type accepts.
pub(crate) fn literals(ty: &str) -> Option<LiteralKind> {
    Some(match ty {
        "i8" | "i16" | "i32" | "i64" | "i128" | "isize" => LiteralKind::Signed,
        "u8" | "u16" | "u32" | "u64" | "u128" | "usize" => LiteralKind::Unsigned,
        "f32" | "f64" => LiteralKind::Float,
        "bool" => LiteralKind::Bool,
        "char" => LiteralKind::Char,
        "String" | "std::string::String" | "&'static str" => LiteralKind::Text,
        _ => return None,
    })
}

/// Returns whether a type is certainly `Copy`, and can be named anywhere.
pub(crate) fn is_copy(ty: &str) -> bool {
    const OTHERS: [&str; 3] = ["()", DURATION, "&'static str"];
    OTHERS.contains(&ty) || !matches!(literals(ty), None | Some(LiteralKind::Text))
}

/// Returns a type without the paths before its names: two files can name one type differently, and Rust compares them
/// in the end.
pub(super) fn last_names(ty: &str) -> String {
    let mut text = String::new();
    for (index, part) in ty.split("::").enumerate() {
        if index > 0 {
            let start = text.rfind(|c: char| !c.is_alphanumeric() && c != '_').map_or(0, |at| at + 1);
            text.truncate(start);
        }
        text.push_str(part);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::last_names;

    #[test]
    fn paths_do_not_tell_types_apart() {
        assert_eq!(last_names("super::source::Hello"), "Hello");
        assert_eq!(last_names("Vec<core::time::Duration>"), "Vec<Duration>");
        assert_eq!(last_names("[i32; 3]"), "[i32; 3]");
    }
}
