// SPDX-License-Identifier: Apache-2.0
//! Times on the command line, with LF's units.

use std::time::Duration;

use lf_linux::model::units::unit_ns;

/// Reads `30`, `30s`, `1.5 min`; a number without a unit is in seconds.
///
/// # Errors
/// A sentence for the user.
pub(crate) fn parse(text: &str) -> Result<Duration, String> {
    let text = text.trim();
    let split = text.find(|c: char| c != '.' && !c.is_ascii_digit()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    of_unit(number, if unit.trim().is_empty() { "s" } else { unit.trim() })
}

/// Reads a number and its unit, which are given apart.
///
/// # Errors
/// A sentence for the user.
pub(crate) fn of_unit(number: &str, unit: &str) -> Result<Duration, String> {
    let length_ns = unit_ns(unit).and_then(|length_ns| u64::try_from(length_ns).ok());
    let length_ns =
        length_ns.ok_or_else(|| format!("`{unit}` is no unit of time; try ns, us, ms, s, min, h, d or wk"))?;
    let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
    let wrong = || format!("`{number}` is no number");
    let too_long = || format!("`{number} {unit}` is longer than 292 years");
    if whole.is_empty() || !fraction.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(wrong());
    }
    let whole: u64 =
        whole.parse().map_err(|_| if whole.bytes().all(|b| b.is_ascii_digit()) { too_long() } else { wrong() })?;
    let mut total_ns = whole.checked_mul(length_ns).ok_or_else(too_long)?;
    let mut digit_ns = length_ns;
    for digit in fraction.bytes() {
        digit_ns /= 10;
        total_ns = total_ns.checked_add(u64::from(digit - b'0') * digit_ns).ok_or_else(too_long)?;
    }
    i64::try_from(total_ns).map_err(|_| too_long())?;
    Ok(Duration::from_nanos(total_ns))
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
    fn what_is_no_time_is_named() {
        assert!(parse("5 parsec").is_err_and(|error| error.contains("parsec")));
        for wrong in ["", "-5 s", "s", "1.2.3", "1,5"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
        assert!(parse("999999999999 weeks").is_err_and(|error| error.contains("292 years")));
        assert!(parse("99999999999999999999999").is_err_and(|error| error.contains("292 years")));
    }
}
