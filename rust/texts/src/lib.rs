// SPDX-License-Identifier: Apache-2.0
//! Sentences that take half of their bytes: packed at compile time, and unpacked when they are displayed.
//!
//! [`say!`] is `write!` for the sentences of errors and log events. A byte of a packed sentence is a character, stands
//! for a value, or for two such bytes, which can be pairs in turn.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

// The macros' code names this crate from outside.
#[cfg(test)]
extern crate self as lf_texts;

use core::fmt::{self, Write as _};

pub use lf_derive::{say, text};

/// The meanings of the bytes of pairs, from [`FIRST`] on. Pairs consist of characters and of earlier pairs.
static PAIRS: [[u8; 2]; lf_derive::pairs!(count)] = lf_derive::pairs!(bytes);
/// The byte of the first pair. The last ones are below the characters, behind an overflow.
const FIRST: u8 = lf_derive::pairs!(first);
/// The byte that stands for a value.
const VALUE: u8 = lf_derive::pairs!(value);

/// The end mark behind each value in a list of values.
const END: &str = lf_derive::pairs!(end);

/// A packed sentence, or a part of one, of [`text!`].
#[derive(Clone, Copy)]
pub struct Text(&'static [u8]);

impl Text {
    /// Returns the sentence of these bytes, which only [`say!`] and [`text!`] can make.
    #[doc(hidden)]
    pub const fn new(packed: &'static [u8]) -> Self {
        Self(packed)
    }

    /// Displays the sentence without values.
    ///
    /// # Errors
    /// Those of the formatter.
    #[doc(hidden)]
    #[inline(never)]
    pub fn show(self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, format_args!(""))
    }

    /// Displays the sentence with these values, each of which ends with [`END`]. Missing values are left out.
    ///
    /// # Errors
    /// Those of the formatter.
    #[doc(hidden)]
    #[inline(never)]
    pub fn write(self, f: &mut fmt::Formatter<'_>, values: fmt::Arguments<'_>) -> fmt::Result {
        let mut said = Said { f, values, next: 0 };
        self.0.iter().try_for_each(|byte| said.unpack(*byte))
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.show(f)
    }
}

impl fmt::Debug for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"{self}\"")
    }
}

/// A sentence that is being displayed.
struct Said<'a, 'f> {
    f: &'a mut fmt::Formatter<'f>,
    values: fmt::Arguments<'a>,
    /// The index of the next value.
    next: usize,
}

impl Said<'_, '_> {
    /// Displays a byte. The recursion ends, because pairs consist of earlier ones.
    #[inline(never)]
    fn unpack(&mut self, byte: u8) -> fmt::Result {
        match PAIRS.get(usize::from(byte.wrapping_sub(FIRST))) {
            Some([first, second]) => {
                self.unpack(*first)?;
                self.unpack(*second)
            }
            None if byte == VALUE => {
                self.next += 1;
                One { f: self.f, skipped: self.next - 1 }.write_fmt(self.values)
            }
            None => self.f.write_char(char::from(byte)),
        }
    }
}

/// Displays one of the values. References to trait objects, by which each could be displayed, take tables of 16 bytes
/// for each type.
struct One<'a, 'f> {
    f: &'a mut fmt::Formatter<'f>,
    /// The number of values that precede it.
    skipped: usize,
}

impl fmt::Write for One<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        if text == END {
            self.skipped = self.skipped.wrapping_sub(1);
        } else if self.skipped == 0 {
            return self.f.write_str(text);
        }
        Ok(())
    }

    /// Single characters end no value, so that they need not be texts first.
    fn write_char(&mut self, character: char) -> fmt::Result {
        if self.skipped == 0 { self.f.write_char(character) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use core::fmt;
    use std::format;
    use std::string::ToString as _;

    use super::{FIRST, PAIRS, Text};

    /// Displays the output of a closure.
    struct Said<F>(F);

    impl<F: Fn(&mut fmt::Formatter<'_>) -> fmt::Result> fmt::Display for Said<F> {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            (self.0)(f)
        }
    }

    #[test]
    fn a_sentence_is_said_as_write_writes_it() {
        let (federate, tag) = (7_u16, Some("(3 ns, 0)"));
        let said = Said(|f: &mut fmt::Formatter<'_>| {
            crate::say!(f, "federate {federate} takes {:>5}% of {{it}} \"at\" {tag:?}, {0}, {:#x}", 1.5, federate)
        });
        let written = format!("federate {federate} takes {:>5}% of {{it}} \"at\" {tag:?}, {0}, {:#x}", 1.5, federate);
        assert_eq!(said.to_string(), written);
        assert_eq!(format!("{said:>300}"), written, "a width is that of no part");
    }

    #[test]
    fn each_pair_consists_of_characters_and_earlier_pairs() {
        for (index, pair) in PAIRS.iter().enumerate() {
            let is_earlier = |byte: &u8| {
                let place = usize::from(byte.wrapping_sub(FIRST));
                place >= PAIRS.len() || place < index
            };
            assert!(pair.iter().all(is_earlier), "pair {index}: {pair:?}");
        }
    }

    #[test]
    fn any_bytes_are_shown_to_an_end() {
        for byte in 0..=u8::MAX {
            let text = Text::new(std::vec![byte; 3].leak()).to_string();
            assert!(text.len() <= 3 * 40, "{byte}: {text}");
        }
    }
}
