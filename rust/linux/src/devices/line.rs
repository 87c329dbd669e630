// SPDX-License-Identifier: Apache-2.0
//! The parser of one line of a script for devices.

use lf_model::time::Interval;

use super::binding::Binding;
use super::words::{Words, time};

/// The value of a device from a time on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    /// A level, or a measurement.
    Number(f64),
    /// The bytes of a register, and of those that follow it.
    Bytes(Vec<Vec<u8>>),
    /// Bytes received on a serial line.
    Text(Vec<u8>),
}

/// The content of a line.
pub(super) enum ScriptLine {
    /// A change of a device.
    Change(Schedule),
    /// A binding to a device of this computer.
    Binding(String, Binding),
}

impl ScriptLine {
    pub(super) fn read(line: &str) -> Result<Self, String> {
        let mut words = Words { rest: line };
        // A time begins with a digit, and the name of a device does not.
        if !words.peek().is_some_and(|word| word.starts_with(|first: char| first.is_alphabetic() || first == '_')) {
            return Schedule::read(words).map(Self::Change);
        }
        let device = words.next().unwrap_or_default().to_owned();
        let binding = Binding::read(&device, &mut words)?;
        match words.next() {
            None => Ok(Self::Binding(device, binding)),
            Some(other) => Err(format!("\"{other}\" is one word too many")),
        }
    }
}

/// A change, once or repeatedly.
pub(super) struct Schedule {
    pub(super) at: Interval,
    pub(super) device: String,
    pub(super) value: Value,
    pub(super) every: Option<Interval>,
    pub(super) until: Interval,
}

impl Schedule {
    fn read(mut words: Words<'_>) -> Result<Self, String> {
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

/// Parses a number, bytes such as `0x1980 0x00`, or a text.
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
