// SPDX-License-Identifier: Apache-2.0
//! Values of parameters and state variables: checked against their types as far as that can be done without Rust, and
//! written as Rust.

use super::checker::Checker;
use super::model::Parameter;
use super::names::rust_name;
use super::time_value::literal_ns;
use crate::diagnostics::{Code, Diagnostic, Span};
use crate::syntax::ast::{Expression, ExpressionKind, Literal};

/// Where a value goes.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    /// For people, like "parameter p".
    pub(super) what: &'a str,
    pub(super) ty: &'a str,
    pub(super) ty_span: Span,
    pub(super) is_time: bool,
}

/// What kind of literals a simple type of Rust takes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Simple {
    Signed,
    Unsigned,
    Float,
    Bool,
    Char,
    Text,
}

fn simple(ty: &str) -> Option<Simple> {
    Some(match ty {
        "i8" | "i16" | "i32" | "i64" | "i128" | "isize" => Simple::Signed,
        "u8" | "u16" | "u32" | "u64" | "u128" | "usize" => Simple::Unsigned,
        "f32" | "f64" => Simple::Float,
        "bool" => Simple::Bool,
        "char" => Simple::Char,
        "String" | "std::string::String" | "&'static str" => Simple::Text,
        _ => return None,
    })
}

impl Checker<'_> {
    /// Reports a value that cannot have the type of its place.
    pub(super) fn check_value(&mut self, value: &Expression, place: Place<'_>, scope: &[Parameter<'_>]) {
        if place.is_time {
            return self.check_time(value, place.what, scope, true);
        }
        match &value.kind {
            ExpressionKind::Code(_) => {}
            ExpressionKind::List(items) => {
                // The items' types are inside the list's type, which is text.
                for item in items {
                    self.check_value(item, Place { ty: "", ..place }, scope);
                }
            }
            ExpressionKind::Time(time) => {
                self.check_time_literal(time, value.span, place.what);
                if simple(place.ty).is_some() {
                    self.wrong_value(value.span, place, "a time");
                }
            }
            ExpressionKind::Name(name) => match scope.iter().find(|parameter| parameter.name.text == *name) {
                None => self.unknown_parameter(name, value.span, scope),
                Some(parameter) if simple(place.ty).is_some() => {
                    let differs = simple(&parameter.ty).is_some() && parameter.ty != place.ty;
                    if differs || parameter.is_time {
                        self.wrong_value(value.span, place, &format!("of type `{}`", parameter.ty));
                    }
                }
                Some(_) => {}
            },
            ExpressionKind::Literal(literal) => {
                let Some(simple) = simple(place.ty) else { return };
                if let Some(found) = mismatch(literal, simple) {
                    self.wrong_value(value.span, place, found);
                }
            }
        }
    }

    fn wrong_value(&mut self, span: Span, place: Place<'_>, found: &str) {
        let message = format!("{} has type `{}`, but this value is {found}", place.what, place.ty);
        let hint = "give a value of that type, or Rust code: `{= … =}`";
        let diagnostic = Diagnostic::new(Code::WrongValue, span, message).hint(hint);
        self.report(diagnostic.also(place.ty_span, "the type"));
    }
}

/// What a literal is, if the type does not take it.
fn mismatch(literal: &Literal, simple: Simple) -> Option<&'static str> {
    let (fits, found) = match literal {
        Literal::Int(text) if text.starts_with('-') => {
            (matches!(simple, Simple::Signed | Simple::Float), "a negative number")
        }
        Literal::Int(_) => (matches!(simple, Simple::Signed | Simple::Unsigned | Simple::Float), "a number"),
        Literal::Float(_) => (simple == Simple::Float, "a number with a fraction"),
        Literal::Bool(_) => (simple == Simple::Bool, "a boolean"),
        Literal::Character(_) => (simple == Simple::Char, "a character"),
        Literal::Text(_) => (simple == Simple::Text, "a string"),
    };
    (!fits).then_some(found)
}

/// A value as a Rust expression for a place of type `ty`.
pub(crate) fn rust_text(value: &Expression, ty: &str) -> String {
    match &value.kind {
        ExpressionKind::Code(code) => code.text.clone(),
        ExpressionKind::Name(name) => rust_name(name),
        ExpressionKind::Time(_) => {
            let ns = literal_ns(value).unwrap_or(i64::MAX);
            format!("core::time::Duration::from_nanos({ns})")
        }
        ExpressionKind::List(items) => {
            let items: Vec<_> = items.iter().map(|item| rust_text(item, "")).collect();
            let vector = ty.starts_with("Vec<") || ty.starts_with("std::vec::Vec<");
            format!("{}[{}]", if vector { "vec!" } else { "" }, items.join(", "))
        }
        ExpressionKind::Literal(literal) => match literal {
            Literal::Bool(value) => value.to_string(),
            // Rust takes no integer where a float belongs.
            Literal::Int(text) if simple(ty) == Some(Simple::Float) => format!("{text}.0"),
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
