// SPDX-License-Identifier: Apache-2.0
//! Values of parameters and state variables, written as Rust.

use super::types::{DURATION, literals};
use crate::languages::facts::LiteralKind;
use crate::lexical::raw;
use crate::syntax::ast::{Expression, ExpressionKind, Literal};
use crate::syntax::literal_ns;

/// Returns a value as a Rust expression for a place of type `ty`.
pub(super) fn text(value: &Expression, ty: &str) -> String {
    match &value.kind {
        ExpressionKind::Code(code) => code.text.clone(),
        ExpressionKind::Name(name) => raw(name),
        ExpressionKind::Time(_) => {
            let ns = literal_ns(value).unwrap_or(i64::MAX);
            format!("{DURATION}::from_nanos({ns})")
        }
        ExpressionKind::List(items) => {
            let items: Vec<_> = items.iter().map(|item| text(item, "")).collect();
            let vector = ty.starts_with("Vec<") || ty.starts_with("std::vec::Vec<");
            format!("{}[{}]", if vector { "vec!" } else { "" }, items.join(", "))
        }
        ExpressionKind::Literal(literal) => match literal {
            Literal::Bool(value) => value.to_string(),
            // Rust does not accept an integer as a float.
            Literal::Int(text) if literals(ty) == Some(LiteralKind::Float) => format!("{text}.0"),
            Literal::Int(text) | Literal::Float(text) | Literal::Character(text) => text.clone(),
            Literal::Text(text) => {
                let text = match text.strip_prefix("\"\"\"").and_then(|text| text.strip_suffix("\"\"\"")) {
                    Some(raw) => format!("{raw:?}"),
                    None => text.clone(),
                };
                if matches!(ty, "String" | "std::string::String") { format!("{text}.into()") } else { text }
            }
        },
    }
}
