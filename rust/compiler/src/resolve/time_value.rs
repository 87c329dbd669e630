// SPDX-License-Identifier: Apache-2.0
//! Values that are times.

use lf_model::units::UNITS;

use super::checker::Checker;
use super::model::CheckedParameter;
use crate::diagnostics::{Code, Diagnostic, Span, did_you_mean};
use crate::syntax::ast::{Expression, ExpressionKind, Literal, TimeValue};
use crate::syntax::{TimeError, is_zero, nanoseconds};

impl Checker<'_> {
    /// Reports a value that is no time. `what` is its role, like "the period of timer t". Code is allowed only if the
    /// value is not needed at compile time.
    pub(super) fn check_time(
        &mut self,
        value: &Expression,
        what: &str,
        scope: &[CheckedParameter<'_>],
        code_allowed: bool,
    ) {
        match &value.kind {
            ExpressionKind::Time(time) => self.check_time_literal(time, value.span, what),
            ExpressionKind::Literal(Literal::Int(text)) if is_zero(text) => {}
            ExpressionKind::Literal(Literal::Int(text)) => {
                let message = format!("{what} needs a unit of time");
                let hint = format!("write `{text} ms`, or another unit: ns, us, s, min, h, d, wk; only 0 needs none");
                self.report(Diagnostic::new(Code::MissingUnit, value.span, message).hint(hint));
            }
            ExpressionKind::Name(name) => self.check_time_name(name, value.span, what, scope),
            ExpressionKind::Code(_) if code_allowed => {}
            ExpressionKind::Code(_) => {
                let message = format!("{what} must be known when the program is compiled, so it cannot be code");
                let hint = "write a time, like `10 ms`, or a parameter of type `time`";
                self.report(Diagnostic::new(Code::NotATime, value.span, message).hint(hint));
            }
            _ => self.not_a_time(value.span, what),
        }
    }

    fn not_a_time(&mut self, span: Span, what: &str) {
        let message = format!("{what} is not a time");
        let hint = "write a number with a unit, like `10 ms`, or a parameter of type `time`";
        self.report(Diagnostic::new(Code::NotATime, span, message).hint(hint));
    }

    fn check_time_name(&mut self, name: &str, span: Span, what: &str, scope: &[CheckedParameter<'_>]) {
        let Some(parameter) = scope.iter().find(|parameter| parameter.name.text == name) else {
            return self.unknown_parameter(name, span, scope);
        };
        if !parameter.is_time {
            let message = format!("{what} is not a time: parameter `{name}` has type `{}`", parameter.ty);
            let hint = format!("declare it as `{name}: time`");
            let diagnostic = Diagnostic::new(Code::NotATime, span, message).hint(hint);
            self.report(diagnostic.also(parameter.ty_span, "its type"));
        }
    }

    /// Reports a name that no parameter in scope has.
    pub(super) fn unknown_parameter(&mut self, name: &str, span: Span, scope: &[CheckedParameter<'_>]) {
        let message = format!("there is no parameter `{name}` here");
        let hint = did_you_mean(name, scope.iter().map(|parameter| parameter.name.text.as_str()));
        let hint =
            hint.or_else(|| Some(format!("other {} expressions are written as code: `{{= … =}}`", self.language)));
        self.report(Diagnostic::new(Code::UnknownName, span, message).hint_maybe(hint));
    }

    /// Reports an unknown unit, a negative time, and one that is too long.
    pub(super) fn check_time_literal(&mut self, time: &TimeValue, span: Span, what: &str) {
        match time {
            TimeValue::Forever => {}
            TimeValue::Never => {
                let message = format!("{what} cannot be `never`, which is before all times");
                self.report(Diagnostic::new(Code::NegativeTime, span, message).hint("write `forever` or a time"));
            }
            TimeValue::Interval { negative, digits, unit } => match nanoseconds(digits, &unit.text) {
                Ok(ns) if *negative && ns > 0 => {
                    let message = format!("{what} cannot be negative");
                    let hint = format!("write `{digits} {}` or 0", unit.text);
                    self.report(Diagnostic::new(Code::NegativeTime, span, message).hint(hint));
                }
                Ok(_) => {}
                // A time of the parser has digits.
                Err(TimeError::TooLarge(..) | TimeError::NotANumber(_)) => {
                    let message = format!("{what} is longer than 292 years");
                    let hint = "write `forever` for a time that never comes";
                    self.report(Diagnostic::new(Code::NumberTooLarge, span, message).hint(hint));
                }
                Err(TimeError::UnknownUnit(_)) => {
                    let message = format!("there is no unit of time `{}`", unit.text);
                    let units = UNITS.iter().flat_map(|(names, _)| names.iter().copied());
                    let hint = did_you_mean(&unit.text, units)
                        .unwrap_or_else(|| "units of time are ns, us, ms, s, min, h, d and wk".to_owned());
                    self.report(Diagnostic::new(Code::BadUnit, unit.span, message).hint(hint));
                }
            },
        }
    }
}
