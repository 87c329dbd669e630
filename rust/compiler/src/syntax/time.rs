// SPDX-License-Identifier: Apache-2.0
//! Units of time.

/// All spellings of the units, shortest unit first, with their length in nanoseconds.
pub(crate) const UNITS: &[(&[&str], i64)] = &[
    (&["ns", "nsec", "nsecs"], 1),
    (&["us", "usec", "usecs"], 1_000),
    (&["ms", "msec", "msecs"], 1_000_000),
    (&["s", "sec", "secs", "second", "seconds"], 1_000_000_000),
    (&["min", "mins", "minute", "minutes"], 60_000_000_000),
    (&["h", "hour", "hours"], 3_600_000_000_000),
    (&["d", "day", "days"], 86_400_000_000_000),
    (&["wk", "week", "weeks"], 604_800_000_000_000),
];

/// Why a number with a unit is no time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TimeError {
    /// There is no such unit.
    UnknownUnit,
    /// More than 292 years.
    TooLarge,
}

/// The length of a unit in nanoseconds.
pub(crate) fn unit_length(unit: &str) -> Option<i64> {
    UNITS.iter().find(|(names, _)| names.contains(&unit)).map(|(_, length)| *length)
}

/// A number of units in nanoseconds.
pub(crate) fn nanoseconds(digits: &str, unit: &str) -> Result<i64, TimeError> {
    let length = unit_length(unit).ok_or(TimeError::UnknownUnit)?;
    let count: i64 = digits.parse().map_err(|_| TimeError::TooLarge)?;
    count.checked_mul(length).ok_or(TimeError::TooLarge)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_counts_and_overflow_is_noticed() {
        for (names, length) in UNITS {
            for name in *names {
                assert_eq!(nanoseconds("3", name), Ok(3 * length));
            }
        }
        assert_eq!(nanoseconds("3", "fortnight"), Err(TimeError::UnknownUnit));
        assert_eq!(nanoseconds("99999", "weeks"), Err(TimeError::TooLarge));
        assert_eq!(nanoseconds("99999999999999999999", "ns"), Err(TimeError::TooLarge));
    }
}
