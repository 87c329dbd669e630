// SPDX-License-Identifier: Apache-2.0
//! The script of device inputs, with lines such as
//!
//! ```text
//! # time since the start, device, value
//! 100 ms  button0              1
//! 1 s     clock                1  every 2 ms until 3 s
//! 2 s     b.sw0                1
//! 2 s     thermometer[0x00]    0x1980
//! 2 s     line                 "hello\n"
//! # device, its binding on this computer
//! led0    gpio /dev/gpiochip0 17
//! ```
//!
//! A name that begins with a federate's belongs to that federate alone. Before its first line an input is inactive.

use std::collections::BTreeMap;
use std::fmt;

use lf_devices::Channel;
use lf_model::time::Interval;

use super::binding::Bound;
use super::line::{Schedule, ScriptLine, Value};
use super::words::{hexadecimal, without_comment};

/// The maximum number of changes of a script, repeated ones included.
const CHANGES: usize = 10_000_000;

/// A change of a device.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Change {
    /// The time since the start.
    pub(crate) at: Interval,
    pub(crate) value: Value,
    /// The line of the script.
    pub(crate) line: u32,
}

/// The changes of each simulated device, in order, and the bindings of real ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Script {
    pub(super) devices: BTreeMap<String, Vec<Change>>,
    pub(super) bound: BTreeMap<String, Bound>,
}

/// The wrong lines, in order.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct ScriptError {
    pub(super) lines: Vec<(u32, String)>,
}

impl fmt::Display for ScriptError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (line, what)) in self.lines.iter().enumerate() {
            write!(f, "{}line {line}: {what}", if index == 0 { "" } else { "\n" })?;
        }
        Ok(())
    }
}

impl Script {
    /// Parses a script.
    ///
    /// # Errors
    /// All wrong lines.
    pub(crate) fn read(text: &str) -> Result<Self, ScriptError> {
        let mut script = Self::default();
        let mut lines = Vec::new();
        let mut count = 0;
        for (number, line) in (1..).zip(text.lines()) {
            let line = without_comment(line);
            if line.trim().is_empty() {
                continue;
            }
            if let Err(what) = ScriptLine::read(line).and_then(|read| script.take(number, read, &mut count)) {
                lines.push((number, what));
            }
        }
        for changes in script.devices.values_mut() {
            // Of two lines for one time the later one counts, but both of two texts are received.
            let is_replaced = |change: &Change| !matches!(change.value, Value::Text(_));
            changes.sort_by_key(|change| change.at);
            changes.reverse();
            changes.dedup_by(|earlier, later| earlier.at == later.at && is_replaced(earlier) && is_replaced(later));
            changes.reverse();
        }
        lines.extend(script.both_real_and_simulated());
        lines.sort_by_key(|(line, _)| *line);
        if lines.is_empty() { Ok(script) } else { Err(ScriptError { lines }) }
    }

    /// Adds the content of a line. `count` is the number of changes.
    fn take(&mut self, line: u32, read: ScriptLine, count: &mut usize) -> Result<(), String> {
        let Schedule { at, device, value, every, until } = match read {
            ScriptLine::Change(schedule) => schedule,
            ScriptLine::Binding(device, binding) => {
                if let Some(Bound { line, .. }) = self.bound.get(&device) {
                    return Err(format!("line {line} says already which device {device} is"));
                }
                self.bound.insert(device, Bound { line, binding });
                return Ok(());
            }
        };
        check_part(&device)?;
        let changes = self.devices.entry(device).or_default();
        let mut time = at;
        loop {
            *count += 1;
            if *count > CHANGES {
                return Err(format!("there are more than {CHANGES} changes: end the repetition earlier"));
            }
            changes.push(Change { at: time, value: value.clone(), line });
            let Some(every) = every else { return Ok(()) };
            time = Interval::from_nanos(time.as_nanos().saturating_add(every.as_nanos()));
            if time > until {
                return Ok(());
            }
        }
    }

    /// Returns lines with values for a real device, which the script cannot determine.
    fn both_real_and_simulated(&self) -> Vec<(u32, String)> {
        let of = |(name, Bound { line, .. }): (&String, &Bound)| {
            let of_name = |key: &str| key == name || key.strip_prefix(name.as_str()).is_some_and(is_register);
            let changes = self.devices.iter().filter(|(key, _)| of_name(key)).flat_map(|(_, changes)| changes);
            let first = changes.map(|change| change.line).min()?;
            let what = format!("{name} is a device of this computer, says line {line}: what it does is not written");
            Some((first, what))
        };
        self.bound.iter().filter_map(of).collect()
    }

    /// Returns the binding of a device of a federate; `None` for a simulated one.
    pub(crate) fn bound(&self, federate: &str, device: &str) -> Option<&Bound> {
        let own = format!("{federate}.{device}");
        let is_simulated = self.devices.contains_key(&own);
        self.bound.get(&own).or_else(|| self.bound.get(device).filter(|_| !is_simulated))
    }

    /// Returns the changes of a device of a federate.
    pub(crate) fn changes(&self, federate: &str, device: &str) -> &[Change] {
        let own = self.devices.get(&format!("{federate}.{device}"));
        own.or_else(|| self.devices.get(device)).map_or(&[], Vec::as_slice)
    }

    /// Returns the parts of a device of a federate, such as registers: the text behind its name, and its changes. Lines
    /// for the federate alone come last.
    pub(crate) fn parts<'s>(
        &'s self,
        federate: &str,
        device: &str,
    ) -> impl Iterator<Item = (Part<'s>, &'s [Change])> + use<'s> {
        let find = |name: String| {
            let of_device = move |(key, changes): (&'s String, &'s Vec<Change>)| {
                Some((Part::read(key.strip_prefix(&name)?)?, changes.as_slice()))
            };
            self.devices.iter().filter_map(of_device)
        };
        find(device.to_owned()).chain(find(format!("{federate}.{device}")))
    }

    /// Returns the devices that the script has for this federate, and that the federate lacks. A name without a
    /// federate can belong to another one, if there are others.
    pub(crate) fn unknown<'s>(
        &'s self,
        federate: &str,
        is_alone: bool,
        knows: impl Fn(&str) -> bool,
    ) -> Vec<(u32, &'s str)> {
        let own = format!("{federate}.");
        let knows = |name: &str| knows(name) || knows(name.split(['@', '[']).next().unwrap_or(name));
        let is_unknown = |name: &&'s String| match name.strip_prefix(&own) {
            Some(device) => !knows(device),
            None => is_alone && !knows(name),
        };
        let changed = self.devices.iter().map(|(name, changes)| (changes.first().map_or(0, |it| it.line), name));
        let bound = self.bound.iter().map(|(name, bound)| (bound.line, name));
        let unknown = changed.chain(bound).filter(|(_, name)| is_unknown(name));
        unknown.map(|(line, name)| (line, name.as_str())).collect()
    }
}

/// The text behind the name of a device: `@48[0x00]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part<'s> {
    /// Its address on its bus.
    pub(crate) address: Option<u8>,
    /// The text in brackets.
    pub(crate) name: &'s str,
}

impl<'s> Part<'s> {
    fn read(text: &'s str) -> Option<Self> {
        let (address, rest) = text.split_once('[')?;
        let name = rest.strip_suffix(']')?;
        match address.strip_prefix('@') {
            Some(address) => Some(Self { address: u8::from_str_radix(hexadecimal(address), 16).ok(), name }),
            None if address.is_empty() => Some(Self { address: None, name }),
            None => None,
        }
    }

    /// Returns the register of this name.
    pub(crate) fn register(&self) -> Option<u8> {
        match self.name.strip_prefix("0x") {
            Some(digits) => u8::from_str_radix(digits, 16).ok(),
            None => self.name.parse().ok(),
        }
    }
}

/// Checks that the text in brackets behind a device's name can be a part of a device: a register, a channel of a
/// sensor, or a number in the device's own name.
fn check_part(device: &str) -> Result<(), String> {
    let Some(begin) = device.find(['@', '[']) else { return Ok(()) };
    let (name, behind) = device.split_at(begin);
    let wrong = |what: &str| Err(format!("\"{device}\" is no part of a device: {what}"));
    let Some((address, rest)) = behind.split_once('[') else {
        return wrong("behind an address comes a register, such as [0x00]");
    };
    let Some(part) = rest.strip_suffix(']').filter(|_| !name.is_empty()) else {
        return wrong("it has to be a name, perhaps an address, and a register or a channel in brackets");
    };
    if let Some(address) = address.strip_prefix('@') {
        if u8::from_str_radix(hexadecimal(address), 16).is_err() {
            return wrong("an address is hexadecimal, such as @48, and ff at most");
        }
    } else if !address.is_empty() {
        return wrong("an address begins with @, as in @48[0x00]");
    }
    let is_channel = Channel::ALL.iter().any(|channel| channel.name() == part);
    if is_channel || (Part { address: None, name: part }).register().is_some() {
        return Ok(());
    }
    wrong("in brackets is a register, from 0x00 to 0xff, or a channel that sensors have, such as ambient_temp")
}

/// Returns whether the text in brackets is a register, and not a part of the name, as `[1]` is in `keys[1]`.
fn is_register(text: &str) -> bool {
    Part::read(text).is_some_and(|part| part.address.is_some() || part.name.starts_with("0x"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: i64) -> Interval {
        Interval::from_millis(ms)
    }

    fn numbers(changes: &[Change]) -> Vec<(Interval, f64)> {
        let number = |change: &Change| match change.value {
            Value::Number(number) => (change.at, number),
            _ => panic!("{change:?} is no number"),
        };
        changes.iter().map(number).collect()
    }

    #[test]
    fn lines_are_changes_in_the_order_of_their_times() {
        let text = "# what a hand does\n 30 ms sw0 0\n10ms sw0 0\n10ms sw0 1 # pressed\n\n1 s b.sw0 1\n";
        let script = Script::read(text).expect("it makes sense");
        assert_eq!(numbers(script.changes("a", "sw0")), [(ms(10), 1.0), (ms(30), 0.0)]);
        assert_eq!(numbers(script.changes("b", "sw0")), [(ms(1000), 1.0)]);
        assert_eq!(script.changes("a", "led0"), []);
        assert_eq!(script.unknown("a", true, |_| false), [(6, "b.sw0"), (4, "sw0")]);
        assert_eq!(script.unknown("b", false, |_| false), [(6, "b.sw0")]);
    }

    #[test]
    fn repetitions_end() {
        let script =
            Script::read("0 ms c 1 every 2 ms until 5 ms\n1 ms c 0 every 2 ms until 5 ms").expect("it is sound");
        let expected: Vec<_> = (0..6).map(|at| (ms(at), f64::from(u8::from(at % 2 == 0)))).collect();
        assert_eq!(numbers(script.changes("", "c")), expected);
    }

    #[test]
    fn a_device_has_parts_at_addresses() {
        let text = "0 s t@48[0x01] 0x1980 0x7f\n0 s a.t[2] 7\n0 s t[ambient_temp] -2.5\n0 s tt[0] 1\n";
        let script = Script::read(text).expect("it makes sense");
        let parts: Vec<_> = script.parts("a", "t").collect();
        let values: Vec<_> = parts.iter().map(|(part, changes)| (part.address, part.name, &changes[0].value)).collect();
        assert_eq!(
            values,
            [
                (Some(0x48), "0x01", &Value::Bytes(vec![vec![0x19, 0x80], vec![0x7f]])),
                (None, "ambient_temp", &Value::Number(-2.5)),
                (None, "2", &Value::Number(7.0)),
            ]
        );
        assert_eq!(parts.iter().map(|(part, _)| part.register()).collect::<Vec<_>>(), [Some(1), None, Some(2)]);
        assert_eq!(script.unknown("a", true, |name| name == "t"), [(4, "tt[0]")]);
    }

    #[test]
    fn texts_are_received_one_after_the_other() {
        let script =
            Script::read("1 s line \"a \\\"b\\\" # \\r\\n\" every 1 s until 2 s\n1 s line \"c\"").expect("sound");
        let texts: Vec<_> = script.changes("", "line").iter().map(|change| (change.at, &change.value)).collect();
        let first = Value::Text(b"a \"b\" # \r\n".to_vec());
        assert_eq!(texts, [(ms(1000), &first), (ms(1000), &Value::Text(b"c".to_vec())), (ms(2000), &first)]);
    }

    #[test]
    fn every_line_without_sense_is_named() {
        let text = "5 ms sw0\n1 s sw1 1\nled0 gpio /dev/gpiochip0 17\n6 ms t@xyz[0] 1\n7 ms led0 1";
        let error = Script::read(text).expect_err("three lines make no sense").to_string();
        let lines: Vec<_> = error.lines().filter_map(|line| line.split(':').next()).collect();
        assert_eq!(lines, ["line 1", "line 4", "line 5"], "{error}");
    }

    #[test]
    fn a_part_that_no_device_can_have_is_named() {
        for part in ["t@48", "t@123[0]", "t[ambient_tmp]", "t[0x100]", "t[300]", "t48[0", "[0]", "t@[0]"] {
            let error = Script::read(&format!("\n0 s {part} 1")).expect_err(part).to_string();
            assert!(error.starts_with(&format!("line 2: \"{part}\" is no part of a device")), "{error}");
        }
        Script::read("0 s keys[1] 1\n0 s t@48[0x00] 0x01\n0 s t[255] 1\n0 s t[ambient_temp] 1")
            .expect("these are sound");
    }

    #[test]
    fn a_line_without_sense_is_named() {
        for (text, told) in [
            ("x sw0 1", "line 1: "),
            ("\n5 parsecs sw0 1", "line 2: "),
            ("5", "line 1: 5 needs a unit, such as ms"),
            ("5 ms", "line 1: after the time comes the name of a device, and its value"),
            ("5 ms sw0", "line 1: after sw0 comes its value, such as 0 or 1"),
            ("5 ms sw0 on", "line 1: \"on\" is no value: a pin is 0 or 1"),
            ("5 ms sw0 0x", "line 1: \"0x\" is no bytes"),
            ("5 ms sw0 0x123", "line 1: \"0x123\" is no bytes"),
            ("5 ms sw0 \"on", "line 1: a text has no closing quotation mark"),
            ("5 ms sw0 \"\\q\"", "line 1: \\q is not known in a text"),
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
