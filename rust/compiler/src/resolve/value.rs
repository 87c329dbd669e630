// SPDX-License-Identifier: Apache-2.0
//! Values of parameters and state variables, checked against their types as far as that is possible without the target
//! language's own compiler.

use super::checker::Checker;
use super::model::CheckedParameter;
use crate::diagnostics::{Code, Diagnostic, Span};
use crate::languages::LiteralKind;
use crate::syntax::ast::{Expression, ExpressionKind, Literal, TimeValue};
use crate::syntax::nanoseconds;

/// The destination of a value.
#[derive(Clone, Copy)]
pub(super) struct Destination<'a> {
    /// The name for messages, like "parameter p".
    pub(super) what: &'a str,
    pub(super) ty: &'a str,
    pub(super) ty_span: Span,
    pub(super) is_time: bool,
}

impl Checker<'_> {
    /// Reports a value that does not belong to the type of its destination.
    pub(super) fn check_value(&mut self, value: &Expression, place: Destination<'_>, scope: &[CheckedParameter<'_>]) {
        if place.is_time && self.language.facts().negative_times && is_before_zero(value) {
            return;
        }
        if place.is_time {
            return self.check_time(value, place.what, scope, true);
        }
        match &value.kind {
            ExpressionKind::Code(_) => {}
            ExpressionKind::List(items) => {
                // The items' types are inside the list's type, which is text.
                for item in items {
                    self.check_value(item, Destination { ty: "", ..place }, scope);
                }
            }
            ExpressionKind::Time(time) => {
                self.check_time_literal(time, value.span, place.what);
                if self.converts_nothing(place.ty) {
                    self.wrong_value(value.span, place, "a time");
                }
            }
            ExpressionKind::Name(name) => match scope.iter().find(|parameter| parameter.name.text == *name) {
                None => self.unknown_parameter(name, value.span, scope),
                Some(parameter) if self.converts_nothing(place.ty) => {
                    let differs = self.converts_nothing(&parameter.ty) && parameter.ty != place.ty;
                    if differs || parameter.is_time {
                        self.wrong_value(value.span, place, &format!("of type `{}`", parameter.ty));
                    }
                }
                Some(_) => {}
            },
            ExpressionKind::Literal(literal) => {
                let Some(kind) = (self.language.facts().literals_of)(place.ty) else { return };
                if let Some(found) = mismatch(literal, kind) {
                    self.wrong_value(value.span, place, found);
                }
            }
        }
    }

    /// Returns whether a type accepts only literals and values of its own kind, as far as is known.
    fn converts_nothing(&self, ty: &str) -> bool {
        (self.language.facts().literals_of)(ty).is_some_and(|kind| kind != LiteralKind::Number)
    }

    fn wrong_value(&mut self, span: Span, place: Destination<'_>, found: &str) {
        let message = format!("{} has type `{}`, but this value is {found}", place.what, place.ty);
        let hint = format!("give a value of that type, or {} code: `{{= … =}}`", self.language);
        let diagnostic = Diagnostic::new(Code::WrongValue, span, message).hint(hint);
        self.report(diagnostic.also(place.ty_span, "the type"));
    }
}

/// Returns whether a value is a negative time.
fn is_before_zero(value: &Expression) -> bool {
    match &value.kind {
        ExpressionKind::Time(TimeValue::Never) => true,
        ExpressionKind::Time(TimeValue::Interval { negative, digits, unit }) => {
            *negative && nanoseconds(digits, &unit.text).is_ok()
        }
        _ => false,
    }
}

/// Returns the kind of a literal that the type does not accept.
fn mismatch(literal: &Literal, kind: LiteralKind) -> Option<&'static str> {
    if kind == LiteralKind::Number && !matches!(literal, Literal::Text(_)) {
        return None;
    }
    let (fits, found) = match literal {
        Literal::Int(text) if text.starts_with('-') => {
            (matches!(kind, LiteralKind::Signed | LiteralKind::Float), "a negative number")
        }
        Literal::Int(_) => {
            (matches!(kind, LiteralKind::Signed | LiteralKind::Unsigned | LiteralKind::Float), "a number")
        }
        Literal::Float(_) => (kind == LiteralKind::Float, "a number with a fraction"),
        Literal::Bool(_) => (kind == LiteralKind::Bool, "a boolean"),
        Literal::Character(_) => (kind == LiteralKind::Char, "a character"),
        Literal::Text(_) => (kind == LiteralKind::Text, "a string"),
    };
    (!fits).then_some(found)
}
