// SPDX-License-Identifier: Apache-2.0
//! Types in C's spelling, and their properties that are known without a compiler.

use crate::diagnostics::{Code, Diagnostic};
use crate::languages::facts::{LiteralKind, Unsendable};
use crate::plan::Serializer;
use crate::syntax::ast::{Literal, TypeKind, TypeSyntax};

/// C's type for LF's `time`.
pub(crate) const INTERVAL: &str = "interval_t";

/// The type without values.
pub(super) const VOID: &str = "void";

/// Returns a type as bodies spell it; `*` and `[]` come without spaces.
pub(super) fn text(ty: &TypeSyntax) -> String {
    match &ty.kind {
        TypeKind::Time => INTERVAL.to_owned(),
        TypeKind::Code(text) => text.split_whitespace().collect::<Vec<_>>().join(" "),
        TypeKind::Path { segments, arguments, c_suffix } => {
            let mut text = segments.join("::");
            if !arguments.is_empty() {
                let arguments: Vec<_> = arguments.iter().map(self::text).collect();
                text = format!("{text}<{}>", arguments.join(", "));
            }
            text + c_suffix.as_ref().map_or("", |suffix| &suffix.text)
        }
    }
}

/// Returns the problem of an array that C does not have.
pub(super) fn problem(ty: &TypeSyntax) -> Option<Diagnostic> {
    let TypeKind::Path { segments, c_suffix: Some(suffix), .. } = &ty.kind else { return None };
    let length = suffix.text.split_once('[').map(|(_, rest)| rest.trim_end_matches(']'));
    let (message, hint) = match length {
        Some(length) if !length.is_empty() && length.bytes().all(|byte| byte == b'0') => {
            ("an array has at least one element", "write how many it has, or `[]` for as many as a value brings")
        }
        Some(_) if suffix.text.starts_with('[') && segments == &[VOID] => {
            ("there are no arrays of `void`", "name the type of the elements")
        }
        _ => return None,
    };
    Some(Diagnostic::new(Code::BadType, ty.span, message).hint(hint))
}

/// Returns the type of a literal without a declared type.
pub(super) fn of_literal(literal: &Literal) -> &'static str {
    match literal {
        Literal::Bool(_) => "bool",
        Literal::Int(_) => "int",
        Literal::Float(_) => "double",
        Literal::Character(_) => "char",
        Literal::Text(_) => "string",
    }
}

/// The types between which C converts numbers.
const NUMBERS: [&str; 24] = [
    "bool",
    "_Bool",
    "char",
    "short",
    "int",
    "long",
    "signed",
    "unsigned",
    "float",
    "double",
    "size_t",
    "ssize_t",
    "int8_t",
    "int16_t",
    "int32_t",
    "int64_t",
    "uint8_t",
    "uint16_t",
    "uint32_t",
    "uint64_t",
    "intptr_t",
    "uintptr_t",
    "intmax_t",
    "uintmax_t",
];

/// Returns the kind of literals that a simple type accepts.
pub(crate) fn literals(ty: &str) -> Option<LiteralKind> {
    ty.split(' ').all(|word| NUMBERS.contains(&word)).then_some(LiteralKind::Number)
}

/// Returns a type without insignificant spaces.
pub(super) fn spelled(ty: &str) -> String {
    ["*", "[", "]", "<", ">", ","]
        .into_iter()
        .fold(ty.to_owned(), |text, mark| text.split(mark).map(str::trim).collect::<Vec<_>>().join(mark))
}

/// Names of one integer type on all platforms of LF's C runtime, each with the first of them.
const SAME: [(&str, &[&str]); 8] = [
    ("int8_t", &["signed char"]),
    ("uint8_t", &["unsigned char"]),
    ("int16_t", &["short", "short int", "signed short"]),
    ("uint16_t", &["unsigned short", "unsigned short int"]),
    ("int32_t", &["int", "signed", "signed int"]),
    ("uint32_t", &["unsigned", "unsigned int"]),
    ("int64_t", &["long long", "long long int", INTERVAL, "instant_t"]),
    ("uint64_t", &["unsigned long long", "unsigned long long int"]),
];

/// Returns a type without insignificant spaces, integers by the name that says their size.
pub(super) fn representation(ty: &str) -> String {
    let ty = spelled(ty);
    let (element, suffix) = ty.split_at(ty.find(['*', '[']).unwrap_or(ty.len()));
    let known = SAME.iter().find(|(_, names)| names.contains(&element));
    known.map_or(ty.clone(), |(name, _)| format!("{name}{suffix}"))
}

/// The operator by which a pointer is a type without an asterisk at its end, and so a value that no token has.
pub(crate) const TYPE_OF: &str = "__typeof__";

/// The serializer of messages of Protocol Buffers, which are pointers to what protobuf-c generates.
pub(crate) const PROTO: &str = "proto";

/// Returns the reason why values cannot be sent: a pointer refers to the sender's memory, or the serializer is one of
/// other types.
pub(super) fn unsendable(ty: &str, serializer: Option<&Serializer>) -> Option<Unsendable> {
    let ty = spelled(ty);
    if serializer.is_some_and(|by| by.name.as_deref() == Some(PROTO)) {
        let is_word = |ty: &str| ty.chars().all(|one| one.is_ascii_alphanumeric() || one == '_');
        let message = format!("`{ty}` is no pointer to a message, so the serializer \"{PROTO}\" cannot send it");
        let hint = "give the port the type `Message*`, with the name that the file of `protobufs` gives the message";
        let is_message = ty.strip_suffix('*').is_some_and(is_word);
        return (!is_message).then(|| Unsendable { message, hint: hint.into(), place: None });
    }
    if ty.starts_with(TYPE_OF) {
        let message = "a pointer means nothing to another federate".to_owned();
        return Some(Unsendable { message, hint: "send the value that it points to".into(), place: None });
    }
    let element =
        ty.strip_suffix('*').or_else(|| ty.strip_suffix(']').map(|ty| ty.rsplit('[').nth(1).unwrap_or("")))?;
    let message = match element {
        VOID => format!("nothing says how long a value of `{ty}` is, so it cannot go to another federate"),
        _ if element.ends_with('*') => format!("`{ty}` points to pointers, which mean nothing to another federate"),
        _ => return None,
    };
    Some(Unsendable { message, hint: "send an array of values, or a struct without pointers".into(), place: None })
}

/// Returns the reason why a state cannot be handed over: it is sent as it lies in memory.
pub(super) fn not_handed_over(ty: &str, serializer: Option<&Serializer>) -> Option<Unsendable> {
    let ty = spelled(ty);
    let refused = |message: String, hint: &str| Some(Unsendable { message, hint: hint.into(), place: None });
    if serializer.is_some() {
        let message = "a state in C is handed over as it lies in memory, without a serializer".to_owned();
        return refused(message, "remove `@serializer` and `@max_length`");
    }
    let is_pointer = ty.ends_with('*') || ty.ends_with("[]") || ty == "string" || ty.starts_with(TYPE_OF);
    if is_pointer {
        let message = format!("`{ty}` refers to memory of this instance, which the next one does not have");
        return refused(message, "hand over an array with a length, or a struct without pointers");
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spaces_do_not_tell_types_apart() {
        assert_eq!(spelled("struct foo *"), spelled("struct foo*"));
        assert_eq!(spelled("int [ 3 ]"), "int[3]");
        assert_ne!(spelled("unsigned int"), spelled("unsignedint"));
    }

    #[test]
    fn integers_of_one_size_are_one_type() {
        for (one, other) in
            [("int", "int32_t"), ("unsigned int*", "uint32_t *"), ("time", "time"), ("short[3]", "int16_t[3]")]
        {
            assert_eq!(representation(one), representation(other));
        }
        for (one, other) in
            [("int", "unsigned"), ("int*", "int"), ("long", "int"), ("float", "int32_t"), ("bool", "int8_t")]
        {
            assert_ne!(representation(one), representation(other));
        }
    }

    #[test]
    fn pointers_to_pointers_stay_where_they_are() {
        let is_sent = |ty| unsendable(ty, None).is_none();
        assert!(["int", "int*", "char *", "int[]", "int[3]", "struct s*", "string"].into_iter().all(is_sent));
        assert!(!["int**", "char *[]", "void*", "void []", "int*[3]"].into_iter().any(is_sent));
    }

    #[test]
    fn numbers_are_known_by_their_words() {
        assert_eq!(literals("unsigned long"), Some(LiteralKind::Number));
        assert_eq!(literals("int*"), None);
        assert_eq!(literals("foo_t"), None);
    }
}
