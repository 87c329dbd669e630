// SPDX-License-Identifier: Apache-2.0
//! What happens to inputs: a script of lines such as
//!
//! ```text
//! # time since the start, device, value
//! 100 ms  button0  1
//! 1 s     clock    1  every 2 ms until 3 s
//! 2 s     b.sw0    1
//! ```
//!
//! A name that begins with a federate's is that federate's alone. Before its first line an input is inactive.

use std::collections::BTreeMap;
use std::fmt;
use std::str::SplitWhitespace;

use lf_model::time::Interval;
use lf_model::units::{nanoseconds, number_and_unit};

/// How many changes a script can have, repeated ones included.
const CHANGES: usize = 10_000_000;

/// The changes of each input, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Script {
    inputs: BTreeMap<String, Vec<(Interval, bool)>>,
}

/// What is wrong with a line.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct ScriptError {
    line: usize,
    what: String,
}

impl fmt::Display for ScriptError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.what)
    }
}

impl Script {
    /// Reads a script.
    ///
    /// # Errors
    /// The first line that makes no sense.
    pub(crate) fn read(text: &str) -> Result<Self, ScriptError> {
        let mut script = Self::default();
        let mut count = 0;
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.split('#').next().unwrap_or_default();
            if line.trim().is_empty() {
                continue;
            }
            let error = |what| ScriptError { line: number, what };
            let Line { at, device, active, every, until } = Line::read(line).map_err(error)?;
            let changes = script.inputs.entry(device.to_owned()).or_default();
            let mut time = at;
            loop {
                count += 1;
                if count > CHANGES {
                    return Err(error(format!("there are more than {CHANGES} changes: end the repetition earlier")));
                }
                changes.push((time, active));
                let Some(every) = every else { break };
                time = Interval::from_nanos(time.as_nanos().saturating_add(every.as_nanos()));
                if time > until {
                    break;
                }
            }
        }
        for changes in script.inputs.values_mut() {
            // Of two lines for one time the later one counts.
            changes.sort_by_key(|(time, _)| *time);
            let mut active = false;
            changes.reverse();
            changes.dedup_by_key(|(time, _)| *time);
            changes.reverse();
            changes.retain(|(_, now)| std::mem::replace(&mut active, *now) != *now);
        }
        Ok(script)
    }

    /// The changes of a device of a federate; the first one is from inactive to active.
    pub(crate) fn changes(&self, federate: &str, device: &str) -> &[(Interval, bool)] {
        let own = self.inputs.get(&format!("{federate}.{device}"));
        own.or_else(|| self.inputs.get(device)).map_or(&[], Vec::as_slice)
    }

    /// The devices that should be this federate's, and that it does not have. A name without a federate can be
    /// another's, where there are others.
    pub(crate) fn unknown<'s>(&'s self, federate: &str, is_alone: bool, knows: impl Fn(&str) -> bool) -> Vec<&'s str> {
        let own = format!("{federate}.");
        let is_unknown = |name: &&'s String| match name.strip_prefix(&own) {
            Some(device) => !knows(device),
            None => is_alone && !knows(name),
        };
        self.inputs.keys().filter(is_unknown).map(String::as_str).collect()
    }
}

/// A line, taken apart.
struct Line<'l> {
    at: Interval,
    device: &'l str,
    active: bool,
    every: Option<Interval>,
    until: Interval,
}

impl<'l> Line<'l> {
    fn read(line: &'l str) -> Result<Self, String> {
        let mut words = line.split_whitespace();
        let at = time(&mut words)?;
        let device = words.next().ok_or("after the time comes the name of a device, and 0 or 1")?;
        let active = match words.next() {
            Some("0") => false,
            Some("1") => true,
            Some(other) => return Err(format!("\"{other}\" is no value of a pin: it is 0 or 1")),
            None => return Err(format!("after {device} comes its value: 0 or 1")),
        };
        let (mut every, mut until) = (None, at);
        match words.next() {
            None => {}
            Some("every") => {
                every = Some(time(&mut words)?).filter(|every| *every > Interval::ZERO);
                if every.is_none() {
                    return Err("what is repeated every 0 s never ends".to_owned());
                }
                if words.next() != Some("until") {
                    return Err("after `every` and a time comes `until` and a time".to_owned());
                }
                until = time(&mut words)?;
            }
            Some(other) => return Err(format!("\"{other}\" is not known: only `every TIME until TIME` can come here")),
        }
        match words.next() {
            None => Ok(Self { at, device, active, every, until }),
            Some(other) => Err(format!("\"{other}\" is one word too many")),
        }
    }
}

/// A number and a unit, in one word or in two.
fn time(words: &mut SplitWhitespace<'_>) -> Result<Interval, String> {
    let first = words.next().ok_or("a time is missing, such as 100 ms")?;
    let (number, mut unit) = number_and_unit(first);
    if unit.is_empty() {
        unit = words.next().ok_or_else(|| format!("{number} needs a unit, such as ms"))?;
    }
    nanoseconds(number, unit).map(Interval::from_nanos).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: i64) -> Interval {
        Interval::from_millis(ms)
    }

    #[test]
    fn lines_are_changes_in_the_order_of_their_times() {
        let text = "# what a hand does\n 30 ms sw0 0\n10ms sw0 1 # pressed\n\n20 ms sw0 1\n1 s b.sw0 1\n";
        let script = Script::read(text).expect("it makes sense");
        assert_eq!(script.changes("a", "sw0"), [(ms(10), true), (ms(30), false)]);
        assert_eq!(script.changes("b", "sw0"), [(ms(1000), true)]);
        assert_eq!(script.changes("a", "led0"), []);
        assert_eq!(script.unknown("a", true, |_| false), ["b.sw0", "sw0"]);
        assert_eq!(script.unknown("b", false, |_| false), ["b.sw0"]);
    }

    #[test]
    fn what_is_repeated_ends() {
        let script =
            Script::read("0 ms c 1 every 2 ms until 5 ms\n1 ms c 0 every 2 ms until 5 ms").expect("it is sound");
        let expected: Vec<_> = (0..6).map(|at| (ms(at), at % 2 == 0)).collect();
        assert_eq!(script.changes("", "c"), expected);
    }

    #[test]
    fn a_line_without_sense_is_named() {
        for (text, told) in [
            ("x sw0 1", "line 1: "),
            ("\n5 parsecs sw0 1", "line 2: "),
            ("5", "line 1: 5 needs a unit, such as ms"),
            ("5 ms", "line 1: after the time comes the name of a device, and 0 or 1"),
            ("5 ms sw0", "line 1: after sw0 comes its value: 0 or 1"),
            ("5 ms sw0 2", "line 1: \"2\" is no value of a pin: it is 0 or 1"),
            ("5 ms sw0 1 later", "line 1: \"later\" is not known: only `every TIME until TIME` can come here"),
            ("5 ms sw0 1 every 0 ms until 1 s", "line 1: what is repeated every 0 s never ends"),
            ("5 ms sw0 1 every 1 ms", "line 1: after `every` and a time comes `until` and a time"),
            ("5 ms sw0 1 every 1 ms until 2 ms 3", "line 1: \"3\" is one word too many"),
            (
                "0 ms s 1 every 1 ns until 1 s",
                "line 1: there are more than 10000000 changes: end the repetition earlier",
            ),
        ] {
            let error = Script::read(text).expect_err(text).to_string();
            assert!(error.starts_with(told), "{text}: {error}");
        }
    }
}
