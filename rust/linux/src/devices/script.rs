// SPDX-License-Identifier: Apache-2.0
//! What devices find: a script of lines such as
//!
//! ```text
//! # time since the start, device, value
//! 100 ms  button0              1
//! 1 s     clock                1  every 2 ms until 3 s
//! 2 s     b.sw0                1
//! 2 s     thermometer[0x00]    0x1980
//! 2 s     line                 "hello\n"
//! ```
//!
//! A name that begins with a federate's is that federate's alone. Before its first line an input is inactive.

use std::collections::BTreeMap;
use std::fmt;

use lf_model::time::Interval;
use lf_model::units::{nanoseconds, number_and_unit};

/// How many changes a script can have, repeated ones included.
const CHANGES: usize = 10_000_000;

/// What a device finds from a time on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    /// A level, or something that is measured.
    Number(f64),
    /// What is in a register, and in those that follow it.
    Bytes(Vec<Vec<u8>>),
    /// What comes on a serial line.
    Text(Vec<u8>),
}

/// Something that happens to a device.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Change {
    /// Since the start.
    pub(crate) at: Interval,
    pub(crate) value: Value,
    /// Where the script says so.
    pub(crate) line: u32,
}

/// The changes of each device, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Script {
    pub(super) devices: BTreeMap<String, Vec<Change>>,
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
            let line = without_comment(line);
            if line.trim().is_empty() {
                continue;
            }
            let error = |what| ScriptError { line: number, what };
            let Line { at, device, value, every, until } = Line::read(line).map_err(error)?;
            let changes = script.devices.entry(device).or_default();
            let (mut time, line) = (at, u32::try_from(number).unwrap_or(u32::MAX));
            loop {
                count += 1;
                if count > CHANGES {
                    return Err(error(format!("there are more than {CHANGES} changes: end the repetition earlier")));
                }
                changes.push(Change { at: time, value: value.clone(), line });
                let Some(every) = every else { break };
                time = Interval::from_nanos(time.as_nanos().saturating_add(every.as_nanos()));
                if time > until {
                    break;
                }
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
        Ok(script)
    }

    /// The changes of a device of a federate.
    pub(crate) fn changes(&self, federate: &str, device: &str) -> &[Change] {
        let own = self.devices.get(&format!("{federate}.{device}"));
        own.or_else(|| self.devices.get(device)).map_or(&[], Vec::as_slice)
    }

    /// The parts of a device of a federate, such as registers: what is behind its name, and its changes. Lines for the
    /// federate alone come last.
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

    /// The devices that should be this federate's, and that it does not have. A name without a federate can be
    /// another's, where there are others.
    pub(crate) fn unknown<'s>(&'s self, federate: &str, is_alone: bool, knows: impl Fn(&str) -> bool) -> Vec<&'s str> {
        let own = format!("{federate}.");
        let knows = |name: &str| knows(name) || knows(name.split(['@', '[']).next().unwrap_or(name));
        let is_unknown = |name: &&'s String| match name.strip_prefix(&own) {
            Some(device) => !knows(device),
            None => is_alone && !knows(name),
        };
        self.devices.keys().filter(is_unknown).map(String::as_str).collect()
    }
}

/// What is behind the name of a device: `@48[0x00]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part<'s> {
    /// Its address on its bus.
    pub(crate) address: Option<u8>,
    /// What is in brackets.
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

    /// The register of this name.
    pub(crate) fn register(&self) -> Option<u8> {
        match self.name.strip_prefix("0x") {
            Some(digits) => u8::from_str_radix(digits, 16).ok(),
            None => self.name.parse().ok(),
        }
    }
}

/// A number without the sign that it is hexadecimal.
fn hexadecimal(text: &str) -> &str {
    text.strip_prefix("0x").unwrap_or(text)
}

/// A line up to the sign of a comment, which is none in a text.
fn without_comment(line: &str) -> &str {
    let (mut is_text, mut is_escaped) = (false, false);
    let is_comment = |character: char| {
        is_text ^= character == '"' && !is_escaped;
        is_escaped = character == '\\' && !is_escaped;
        character == '#' && !is_text
    };
    line.find(is_comment).map_or(line, |end| &line[..end])
}

/// A line, taken apart.
struct Line {
    at: Interval,
    device: String,
    value: Value,
    every: Option<Interval>,
    until: Interval,
}

impl Line {
    fn read(line: &str) -> Result<Self, String> {
        let mut words = Words { rest: line };
        let at = time(&mut words)?;
        let device = words.next().ok_or("after the time comes the name of a device, and its value")?;
        let device = device.to_owned();
        let value = value(&device, &mut words)?;
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
            None => Ok(Self { at, device, value, every, until }),
            Some(other) => Err(format!("\"{other}\" is one word too many")),
        }
    }
}

/// The words of a line.
struct Words<'l> {
    rest: &'l str,
}

impl<'l> Words<'l> {
    fn peek(&self) -> Option<&'l str> {
        self.rest.split_whitespace().next()
    }

    /// A text in quotation marks, if one begins here.
    fn text(&mut self) -> Option<Result<Vec<u8>, String>> {
        let inside = self.rest.trim_start().strip_prefix('"')?;
        let mut text = Vec::new();
        let mut characters = inside.chars();
        while let Some(character) = characters.next() {
            let escaped = if character == '\\' { characters.next() } else { None };
            match (character, escaped) {
                ('"', None) => {
                    self.rest = characters.as_str();
                    return Some(Ok(text));
                }
                ('\\', Some('n')) => text.push(b'\n'),
                ('\\', Some('r')) => text.push(b'\r'),
                ('\\', Some('t')) => text.push(b'\t'),
                ('\\', Some('0')) => text.push(0),
                ('\\', Some(same @ ('"' | '\\'))) => text.push(same as u8),
                ('\\', Some(other)) => return Some(Err(format!("\\{other} is not known in a text"))),
                (other, _) => text.extend_from_slice(other.encode_utf8(&mut [0; 4]).as_bytes()),
            }
        }
        Some(Err("a text has no closing quotation mark".to_owned()))
    }
}

impl<'l> Iterator for Words<'l> {
    type Item = &'l str;

    fn next(&mut self) -> Option<&'l str> {
        let rest = self.rest.trim_start();
        let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end);
        self.rest = rest;
        Some(word).filter(|word| !word.is_empty())
    }
}

/// A number, bytes such as `0x1980 0x00`, or a text.
fn value(device: &str, words: &mut Words<'_>) -> Result<Value, String> {
    if let Some(text) = words.text() {
        return text.map(Value::Text);
    }
    let mut bytes = Vec::new();
    while let Some(digits) = words.peek().and_then(|word| word.strip_prefix("0x")) {
        let is_byte = |at: usize| digits.get(at..at + 2).and_then(|digits| u8::from_str_radix(digits, 16).ok());
        let these: Option<Vec<u8>> = (0..digits.len()).step_by(2).map(is_byte).collect();
        match these {
            Some(these) if !these.is_empty() => bytes.push(these),
            _ => return Err(format!("\"0x{digits}\" is no bytes: two digits of 0 to f for each, such as 0x1980")),
        }
        words.next();
    }
    if !bytes.is_empty() {
        return Ok(Value::Bytes(bytes));
    }
    match words.next() {
        Some(word) => word.parse().ok().filter(|number: &f64| number.is_finite()).map(Value::Number).ok_or_else(|| {
            format!(
                "\"{word}\" is no value: a pin is 0 or 1, a voltage a number of millivolts, registers are bytes such \
                 as 0x1980, and a serial line receives a text such as \"on\\n\""
            )
        }),
        None => Err(format!("after {device} comes its value, such as 0 or 1")),
    }
}

/// A number and a unit, in one word or in two.
fn time(words: &mut Words<'_>) -> Result<Interval, String> {
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
        assert_eq!(script.unknown("a", true, |_| false), ["b.sw0", "sw0"]);
        assert_eq!(script.unknown("b", false, |_| false), ["b.sw0"]);
    }

    #[test]
    fn what_is_repeated_ends() {
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
        assert_eq!(script.unknown("a", true, |name| name == "t"), ["tt[0]"]);
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
