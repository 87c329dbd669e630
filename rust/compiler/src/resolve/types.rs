// SPDX-License-Identifier: Apache-2.0
//! Types of declarations: as written, or worked out from the initial value.

use super::checker::Checker;
use super::model::Parameter;
use crate::diagnostics::{Code, Diagnostic, Span};
use crate::syntax::ast::{Expression, ExpressionKind, Initialiser, Literal, Name, Type, TypeKind};

/// The type of a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Resolved {
    /// In Rust's spelling.
    pub(super) rust: String,
    pub(super) span: Span,
    pub(super) is_time: bool,
}

/// C's types with what Rust calls them.
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

impl Checker<'_> {
    /// The type of a port or action; none is the type without a value.
    pub(super) fn signal_type(&mut self, ty: Option<&Type>, name: &Name) -> Resolved {
        match ty {
            Some(ty) => self.written(ty),
            None => Resolved { rust: "()".to_owned(), span: name.span, is_time: false },
        }
    }

    /// The type of a parameter or state variable; parameters in scope can give it.
    pub(super) fn value_type(
        &mut self,
        ty: Option<&Type>,
        init: Option<&Initialiser>,
        name: &Name,
        scope: &[Parameter<'_>],
    ) -> Resolved {
        if let Some(ty) = ty {
            return self.written(ty);
        }
        let inferred = init.and_then(|init| infer(&init.value, scope));
        if let Some((rust, is_time)) = inferred {
            return Resolved { rust, span: name.span, is_time };
        }
        let unknown_name = init.is_some_and(|init| matches!(init.value.kind, ExpressionKind::Name(_)));
        // A value that names something unknown has its own diagnostic.
        if !unknown_name {
            let message = format!("`{}` needs a type", name.text);
            let hint = format!("write it behind the name: `{}: i32`", name.text);
            self.report(Diagnostic::new(Code::MissingType, name.span, message).hint(hint));
        }
        Resolved { rust: "()".to_owned(), span: name.span, is_time: false }
    }

    fn written(&mut self, ty: &Type) -> Resolved {
        self.check_type(ty);
        Resolved { rust: ty.rust(), span: ty.span, is_time: ty.is_time() }
    }

    fn check_type(&mut self, ty: &Type) {
        let TypeKind::Path { segments, arguments, c_suffix } = &ty.kind else { return };
        for argument in arguments {
            self.check_type(argument);
        }
        if let Some(span) = c_suffix {
            let diagnostic = Diagnostic::new(Code::Unsupported, *span, "`*` and `[]` behind a type are C, not Rust")
                .hint("write a Rust type as code: `{= [i32; 3] =}`");
            self.report(diagnostic);
            return;
        }
        let known = match &segments[..] {
            [one] => C_TYPES.iter().find(|(c, _)| c == one),
            _ => None,
        };
        if let Some((c, rust)) = known {
            let message = format!("`{c}` is a type of C; types here are those of Rust");
            let hint = format!("did you mean `{rust}`?");
            self.report(Diagnostic::new(Code::CType, ty.span, message).hint(hint));
        }
    }
}

/// The type of a value that says it by itself, and whether it is a time.
fn infer(value: &Expression, scope: &[Parameter<'_>]) -> Option<(String, bool)> {
    let plain = |rust: &str| Some((rust.to_owned(), false));
    match &value.kind {
        ExpressionKind::Time(_) => Some(("core::time::Duration".to_owned(), true)),
        ExpressionKind::Name(name) => scope
            .iter()
            .find(|parameter| parameter.name.text == *name)
            .map(|parameter| (parameter.ty.clone(), parameter.is_time)),
        ExpressionKind::Literal(literal) => match literal {
            Literal::Bool(_) => plain("bool"),
            Literal::Int(_) => plain("i32"),
            Literal::Float(_) => plain("f64"),
            Literal::Character(_) => plain("char"),
            Literal::Text(_) => plain("&'static str"),
        },
        ExpressionKind::Code(_) | ExpressionKind::List(_) => None,
    }
}
