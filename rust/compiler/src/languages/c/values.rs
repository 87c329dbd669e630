// SPDX-License-Identifier: Apache-2.0
//! Values of parameters and state variables, written as C.

use crate::syntax::ast::{Expression, ExpressionKind, Literal, TimeValue};
use crate::syntax::nanoseconds;

/// Returns a value as an initialiser of C for a place of type `ty`: an expression, or a list in braces.
pub(super) fn text(value: &Expression, ty: &str) -> String {
    let text = of_one(value);
    // The older form of a list with one item looks like that of a value.
    let is_item = match &value.kind {
        ExpressionKind::Literal(literal) => !matches!(literal, Literal::Text(_)),
        ExpressionKind::Time(_) => true,
        _ => false,
    };
    if is_item && ty.ends_with(']') { format!("{{{text}}}") } else { text }
}

fn of_one(value: &Expression) -> String {
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
            let items: Vec<_> = items.iter().map(of_one).collect();
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

/// Returns any text as a literal.
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
