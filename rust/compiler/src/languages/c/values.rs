// SPDX-License-Identifier: Apache-2.0
//! Values of parameters and state variables, written as C.

use crate::syntax::ast::{Expression, ExpressionKind, Literal, TimeValue};
use crate::syntax::nanoseconds;

/// A value as an initialiser of C: an expression, or a list in braces.
pub(super) fn text(value: &Expression) -> String {
    match &value.kind {
        ExpressionKind::Code(code) => code.text.clone(),
        ExpressionKind::Name(name) => name.clone(),
        ExpressionKind::Time(TimeValue::Never) => "NEVER".to_owned(),
        ExpressionKind::Time(TimeValue::Forever) => "FOREVER".to_owned(),
        ExpressionKind::Time(TimeValue::Interval { negative, digits, unit }) => {
            let ns = nanoseconds(digits, &unit.text).unwrap_or(i64::MAX);
            format!("((interval_t){}{ns}LL)", if *negative { "-" } else { "" })
        }
        ExpressionKind::List(items) => {
            let items: Vec<_> = items.iter().map(text).collect();
            format!("{{{}}}", items.join(", "))
        }
        ExpressionKind::Literal(literal) => match literal {
            Literal::Bool(value) => value.to_string(),
            Literal::Int(text) | Literal::Float(text) | Literal::Character(text) => text.clone(),
            Literal::Text(text) => match text.strip_prefix("\"\"\"").and_then(|text| text.strip_suffix("\"\"\"")) {
                Some(raw) => quoted(raw),
                None => text.clone(),
            },
        },
    }
}

/// A text with anything in it as a literal.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for character in text.chars() {
        match character {
            '\n' => quoted.push_str("\\n"),
            '\r' => quoted.push_str("\\r"),
            '"' | '\\' => quoted.extend(['\\', character]),
            _ => quoted.push(character),
        }
    }
    quoted + "\""
}
