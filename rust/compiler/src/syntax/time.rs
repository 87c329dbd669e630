// SPDX-License-Identifier: Apache-2.0
//! Expressions that are times without an evaluation.

use lf_model::units::nanoseconds;

use super::ast::{Expression, ExpressionKind, Literal, TimeValue};

/// Returns the nanoseconds of a value that is a valid time by itself; `forever` is the largest one.
pub(crate) fn literal_ns(value: &Expression) -> Option<i64> {
    match &value.kind {
        ExpressionKind::Time(TimeValue::Interval { negative: false, digits, unit }) => {
            nanoseconds(digits, &unit.text).ok()
        }
        ExpressionKind::Time(TimeValue::Forever) => Some(i64::MAX),
        ExpressionKind::Literal(Literal::Int(text)) if is_zero(text) => Some(0),
        _ => None,
    }
}

/// Returns whether an integer needs no unit to be a time.
pub(crate) fn is_zero(text: &str) -> bool {
    text.trim_start_matches('-').bytes().all(|byte| byte == b'0')
}
