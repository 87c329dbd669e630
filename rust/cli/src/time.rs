// SPDX-License-Identifier: Apache-2.0
//! Times on the command line, with LF's units.

use std::time::Duration;

use lf_linux::model::units::{nanoseconds, number_and_unit};

/// Parses `30`, `30s`, `1.5 min`; a number without a unit is in seconds.
///
/// # Errors
/// A sentence for the user.
pub(crate) fn parse(text: &str) -> Result<Duration, String> {
    let (number, unit) = number_and_unit(text);
    of_unit(number, if unit.is_empty() { "s" } else { unit })
}

/// Parses a number and its unit, given separately.
///
/// # Errors
/// A sentence for the user.
pub(crate) fn of_unit(number: &str, unit: &str) -> Result<Duration, String> {
    let time_ns = nanoseconds(number, unit).map_err(|error| error.to_string())?;
    Ok(Duration::from_nanos(time_ns.unsigned_abs()))
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::{of_unit, parse};

    #[test]
    fn numbers_with_and_without_unit() {
        assert_eq!(parse("30"), Ok(Duration::from_secs(30)));
        assert_eq!(parse("0.25"), Ok(Duration::from_millis(250)));
        assert_eq!(parse("500ms"), Ok(Duration::from_millis(500)));
        assert_eq!(parse(" 1.5 min "), Ok(Duration::from_secs(90)));
        assert_eq!(of_unit("2", "weeks"), Ok(Duration::from_secs(14 * 86_400)));
        assert_eq!(parse("1wk"), Ok(Duration::from_secs(7 * 86_400)));
    }

    #[test]
    fn text_that_is_no_time_is_named() {
        assert!(parse("5 parsec").is_err_and(|error| error.contains("parsec")));
        for wrong in ["", "-5 s", "s", "1.2.3", "1,5"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
        assert!(parse("999999999999 weeks").is_err_and(|error| error.contains("292 years")));
        assert!(parse("99999999999999999999999").is_err_and(|error| error.contains("292 years")));
    }
}
