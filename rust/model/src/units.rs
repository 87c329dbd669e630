// SPDX-License-Identifier: Apache-2.0
//! LF's units of time: the one table and the one parser, for programs, command lines and files of bounds.

use core::fmt;

/// All spellings of the units, shortest unit first, with their lengths in nanoseconds.
pub const UNITS: &[(&[&str], i64)] = &[
    (&["ns", "nsec", "nsecs"], 1),
    (&["us", "usec", "usecs"], 1_000),
    (&["ms", "msec", "msecs"], 1_000_000),
    (&["s", "sec", "secs", "second", "seconds"], 1_000_000_000),
    (&["min", "mins", "minute", "minutes"], 60_000_000_000),
    (&["h", "hour", "hours"], 3_600_000_000_000),
    (&["d", "day", "days"], 86_400_000_000_000),
    (&["wk", "week", "weeks"], 604_800_000_000_000),
];

/// Returns the length of a unit in nanoseconds; `None` if there is no such unit.
pub const fn unit_ns(unit: &str) -> Option<i64> {
    let mut row = 0;
    while row < UNITS.len() {
        let (names, length_ns) = UNITS[row];
        let mut name = 0;
        while name < names.len() {
            if is_same(names[name].as_bytes(), unit.as_bytes()) {
                return Some(length_ns);
            }
            name += 1;
        }
        row += 1;
    }
    None
}

/// The reason why a number with a unit is not a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeError<'a> {
    /// The number does not consist of digits, with or without a dot.
    NotANumber(&'a str),
    /// There is no such unit.
    UnknownUnit(&'a str),
    /// A number and its unit, which are more than 292 years together.
    TooLarge(&'a str, &'a str),
}

impl fmt::Display for TimeError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotANumber(number) => write!(f, "`{number}` is no number; write a time like `1.5 s`"),
            Self::UnknownUnit(unit) => {
                write!(f, "`{unit}` is no unit of time; try ns, us, ms, s, min, h, d or wk")
            }
            Self::TooLarge(number, unit) => write!(f, "`{number} {unit}` is longer than 292 years"),
        }
    }
}

/// Converts a number of units to nanoseconds, `("1.5", "ms")`; fractions of a nanosecond are cut off.
///
/// # Errors
/// The error of one of the two, or of both together.
pub fn nanoseconds<'a>(number: &'a str, unit: &'a str) -> Result<i64, TimeError<'a>> {
    let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
    if whole.is_empty() || !whole.bytes().chain(fraction.bytes()).all(|byte| byte.is_ascii_digit()) {
        return Err(TimeError::NotANumber(number));
    }
    let length_ns = unit_ns(unit).ok_or(TimeError::UnknownUnit(unit))?;
    let too_large = TimeError::TooLarge(number, unit);
    let whole: i64 = whole.parse().map_err(|_| too_large)?;
    let mut total_ns = whole.checked_mul(length_ns).ok_or(too_large)?;
    let mut digit_ns = length_ns;
    for digit in fraction.bytes() {
        digit_ns /= 10;
        total_ns = total_ns.checked_add(i64::from(digit - b'0') * digit_ns).ok_or(too_large)?;
    }
    Ok(total_ns)
}

/// Splits a text like `1.5 min` into its number and its unit, which may be empty. A text that does not begin with a
/// number is not split.
pub fn number_and_unit(text: &str) -> (&str, &str) {
    let text = text.trim();
    let end = text.find(|character: char| character != '.' && !character.is_ascii_digit());
    let (number, unit) = text.split_at(end.filter(|end| *end > 0).unwrap_or(text.len()));
    (number, unit.trim_start())
}

/// Compares like `==`, which is not available in constants.
const fn is_same(one: &[u8], other: &[u8]) -> bool {
    let mut index = 0;
    while index < one.len() && index < other.len() && one[index] == other[index] {
        index += 1;
    }
    index == one.len() && index == other.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_is_found_and_nothing_else() {
        for (names, length_ns) in UNITS {
            for name in *names {
                assert_eq!(unit_ns(name), Some(*length_ns), "{name}");
            }
        }
        for other in ["", "m", "n", "nsecss", "S", "fortnight"] {
            assert_eq!(unit_ns(other), None, "{other}");
        }
    }

    #[test]
    fn numbers_may_have_fractions() {
        assert_eq!(nanoseconds("3", "usec"), Ok(3_000));
        assert_eq!(nanoseconds("1.5", "min"), Ok(90_000_000_000));
        assert_eq!(nanoseconds("0.0000000019", "s"), Ok(1));
        assert_eq!(number_and_unit(" 1.5 min "), ("1.5", "min"));
        assert_eq!(number_and_unit("30"), ("30", ""));
        assert_eq!(number_and_unit("-1 ms"), ("-1 ms", ""));
    }

    #[test]
    fn text_that_is_no_time_is_named() {
        for number in ["", "-5", ".5", "1.2.3", "1,5", "5e3"] {
            assert_eq!(nanoseconds(number, "s"), Err(TimeError::NotANumber(number)));
        }
        assert_eq!(nanoseconds("3", "fortnight"), Err(TimeError::UnknownUnit("fortnight")));
        for (number, unit) in [("99999", "weeks"), ("99999999999999999999", "ns"), ("9223372036.9", "s")] {
            assert_eq!(nanoseconds(number, unit), Err(TimeError::TooLarge(number, unit)));
        }
    }

    #[test]
    fn macros_take_the_same_words() {
        assert_eq!(crate::delay!(2 wk).as_secs(), 1_209_600);
        assert_eq!(crate::delay!(3 nsecs).as_nanos(), 3);
        assert_eq!(crate::tag!(T0 + 1 hour, 3), crate::EventTag::new(crate::delay!(3600 s), 3));
    }
}
