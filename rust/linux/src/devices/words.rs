// SPDX-License-Identifier: Apache-2.0
//! The words of a script for devices.

use lf_model::time::Interval;
use lf_model::units::{nanoseconds, number_and_unit};

/// Returns a line up to the comment sign, unless that is within a text.
pub(super) fn without_comment(line: &str) -> &str {
    let (mut is_text, mut is_escaped) = (false, false);
    let is_comment = |character: char| {
        is_text ^= character == '"' && !is_escaped;
        is_escaped = character == '\\' && !is_escaped;
        character == '#' && !is_text
    };
    line.find(is_comment).map_or(line, |end| &line[..end])
}

/// The words of a line.
pub(super) struct Words<'l> {
    pub(super) rest: &'l str,
}

impl<'l> Words<'l> {
    pub(super) fn peek(&self) -> Option<&'l str> {
        self.rest.split_whitespace().next()
    }

    /// Parses a text in quotation marks, if one begins here.
    pub(super) fn text(&mut self) -> Option<Result<Vec<u8>, String>> {
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

/// Parses a number and a unit, in one word or in two.
pub(super) fn time(words: &mut Words<'_>) -> Result<Interval, String> {
    let first = words.next().ok_or("a time is missing, such as 100 ms")?;
    let (number, mut unit) = number_and_unit(first);
    if unit.is_empty() {
        unit = words.next().ok_or_else(|| format!("{number} needs a unit, such as ms"))?;
    }
    nanoseconds(number, unit).map(Interval::from_nanos).map_err(|error| error.to_string())
}

/// Removes the prefix of a hexadecimal number.
pub(super) fn hexadecimal(text: &str) -> &str {
    text.strip_prefix("0x").unwrap_or(text)
}
