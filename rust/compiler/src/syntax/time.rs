// SPDX-License-Identifier: Apache-2.0
//! Times with units.

use lf_model::units::unit_ns;

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
