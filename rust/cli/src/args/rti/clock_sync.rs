// SPDX-License-Identifier: Apache-2.0
//! The arguments of `-c`.

use lf_linux::model::time::Interval;
use lf_linux::rti::{CLOCK_SYNC_TRIALS, ClockSync};

/// The period in nanoseconds, as the stock RTI's.
const PERIOD_NS_DEFAULT: i64 = 10_000_000;
/// A shorter period would only add load, and with a longer one drift is indistinguishable from temperature.
const PERIOD_NS_MIN: i64 = 1_000_000;
const PERIOD_NS_MAX: i64 = 3_600_000_000_000;

/// The mode of clock synchronization.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Mode {
    Off,
    Init,
    On,
}

/// Parses the arguments. Like the stock RTI, ours ignores an invalid number, or one that does not apply, with a
/// warning: an error would leave a launch script without an RTI.
///
/// # Errors
/// Returns an unknown argument.
pub(super) fn clock_sync(words: &[String], warnings: &mut Vec<String>) -> Result<ClockSync, String> {
    let mut warn = |text: String| warnings.push(format!("-c, --clock_sync: {text}"));
    let (mut mode, mut trials, mut period_ns) = (Mode::Init, CLOCK_SYNC_TRIALS, PERIOD_NS_DEFAULT);
    let mut words = words.iter().map(String::as_str).filter(|word| *word != " ");
    while let Some(word) = words.next() {
        match word {
            "off" => mode = Mode::Off,
            "init" | "initial" => mode = Mode::Init,
            "on" => mode = Mode::On,
            "period" => match (mode, words.next()) {
                (Mode::On, number) => period_ns = period(number, period_ns, &mut warn),
                _ => warn("`period` only applies to `on`, and is ignored".to_owned()),
            },
            "exchanges-per-interval" => match (mode, words.next()) {
                (Mode::Off, _) => warn("`exchanges-per-interval` does not apply to `off`, and is ignored".to_owned()),
                (_, number) => trials = exchanges(number, trials, &mut warn),
            },
            other => return Err(format!("`{other}` is none of off, init, on, period, exchanges-per-interval")),
        }
    }
    Ok(match mode {
        Mode::Off => ClockSync::Off,
        Mode::Init => ClockSync::Init { trials },
        Mode::On => ClockSync::On { trials, period: Interval::from_nanos(period_ns) },
    })
}

/// Parses the period in nanoseconds; returns `otherwise` without one.
fn period(word: Option<&str>, otherwise: i64, warn: &mut impl FnMut(String)) -> i64 {
    let asked = word.and_then(|word| word.parse().ok()).filter(|period_ns| *period_ns > 0);
    let period_ns = asked.unwrap_or(otherwise).clamp(PERIOD_NS_MIN, PERIOD_NS_MAX);
    if asked != Some(period_ns) {
        let word = word.unwrap_or_default();
        warn(format!(
            "`period` takes nanoseconds from {PERIOD_NS_MIN} to {PERIOD_NS_MAX}, not `{word}`; it is {period_ns} now"
        ));
    }
    period_ns
}

/// Parses the number of exchanges before the start; returns `otherwise` if the word is not such a number. Federates
/// count the exchanges too, so any number that they accept stays unchanged.
fn exchanges(word: Option<&str>, otherwise: u32, warn: &mut impl FnMut(String)) -> u32 {
    let most = i32::MAX.unsigned_abs();
    let asked = word.and_then(|word| word.parse().ok()).filter(|trials| (1..=most).contains(trials));
    asked.unwrap_or_else(|| {
        let word = word.unwrap_or_default();
        warn(format!("`exchanges-per-interval` takes a number from 1 to {most}, not `{word}`; it is {otherwise} now"));
        otherwise
    })
}

#[cfg(test)]
mod tests {
    use lf_linux::model::time::Interval;
    use lf_linux::rti::ClockSync;

    use super::clock_sync;

    const INIT: ClockSync = ClockSync::Init { trials: 10 };

    fn on(trials: u32, period_ms: i64) -> ClockSync {
        ClockSync::On { trials, period: Interval::from_millis(period_ms) }
    }

    fn read(words: &[&str]) -> (Result<ClockSync, String>, Vec<String>) {
        let words: Vec<String> = words.iter().copied().map(str::to_owned).collect();
        let mut warnings = Vec::new();
        (clock_sync(&words, &mut warnings), warnings)
    }

    #[test]
    fn words_of_the_stock_rti_are_understood_wherever_blanks_stand() {
        for (words, expected) in [
            (&["off"][..], ClockSync::Off),
            (&["init", " "], INIT),
            (&["initial"], INIT),
            (&["exchanges-per-interval", "3"], ClockSync::Init { trials: 3 }),
            (&["on"], on(10, 10)),
            (&["on", "period", "5000000", " "], on(10, 5)),
            (&[" ", "on", " ", "period", " ", "600000000", "exchanges-per-interval", "2"], on(2, 600)),
            (&["on", "exchanges-per-interval", "2000", "period", "600000000"], on(2000, 600)),
            (&["off", "on"], on(10, 10)),
        ] {
            assert_eq!(read(words), (Ok(expected), Vec::new()), "{words:?}");
        }
    }

    #[test]
    fn options_without_sense_are_warned_of_and_the_rti_goes_on_as_the_stock_one() {
        for (words, expected, warning) in [
            (&["off", "exchanges-per-interval", "5"][..], ClockSync::Off, "does not apply to `off`"),
            (&["init", "period", "5000000"], INIT, "only applies to `on`"),
            (&["init", "period"], INIT, "only applies to `on`"),
            (&["init", "exchanges-per-interval", "0"], INIT, "not `0`; it is 10 now"),
            (&["init", "exchanges-per-interval"], INIT, "takes a number from 1"),
            (&["on", "period", "soon"], on(10, 10), "not `soon`; it is 10000000 now"),
            (&["on", "period", "0"], on(10, 10), "from 1000000"),
            (&["on", "period", "100"], on(10, 1), "not `100`; it is 1000000 now"),
            (&["on", "period", "9000000000000000"], on(10, 3_600_000), "to 3600000000000"),
        ] {
            let (result, warnings) = read(words);
            assert_eq!(result, Ok(expected), "{words:?}");
            assert!(warnings.len() == 1 && warnings[0].contains(warning), "{words:?}: {warnings:?}");
        }
    }

    #[test]
    fn a_word_that_is_none_of_them_is_refused_by_name() {
        assert!(read(&["maybe"]).0.is_err_and(|error| error.contains("`maybe` is none of off, init, on")));
        assert!(read(&["on", "period", "5", "ms"]).0.is_err_and(|error| error.contains("`ms`")));
    }
}
