// SPDX-License-Identifier: Apache-2.0
//! Times with units.

use lf_model::units::unit_ns;

use super::ast::{Expression, ExpressionKind, Literal, TimeValue};

/// Why a number with a unit is no time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TimeError {
    /// There is no such unit.
    UnknownUnit,
    /// More than 292 years.
    TooLarge,
}

/// A number of units in nanoseconds.
pub(crate) fn nanoseconds(digits: &str, unit: &str) -> Result<i64, TimeError> {
    let length = unit_ns(unit).ok_or(TimeError::UnknownUnit)?;
    let count: i64 = digits.parse().map_err(|_| TimeError::TooLarge)?;
    count.checked_mul(length).ok_or(TimeError::TooLarge)
}

/// The nanoseconds of a value that is a correct time by itself; `forever` is the largest one.
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

/// Whether an integer needs no unit to be a time.
pub(crate) fn is_zero(text: &str) -> bool {
    text.trim_start_matches('-').bytes().all(|byte| byte == b'0')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_count_and_overflow_is_noticed() {
        assert_eq!(nanoseconds("3", "usec"), Ok(3_000));
        assert_eq!(nanoseconds("2", "wk"), Ok(2 * 604_800_000_000_000));
        assert_eq!(nanoseconds("3", "fortnight"), Err(TimeError::UnknownUnit));
        assert_eq!(nanoseconds("99999", "weeks"), Err(TimeError::TooLarge));
        assert_eq!(nanoseconds("99999999999999999999", "ns"), Err(TimeError::TooLarge));
    }
}
