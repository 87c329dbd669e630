// SPDX-License-Identifier: Apache-2.0
//! Text of limited length, for C.

use core::ffi::CStr;
use core::fmt::{self, Write};

/// Text for C of at most this many bytes: a longer text is cut, and ends with three dots.
#[derive(Debug)]
pub struct Text<const BYTES: usize> {
    bytes: [u8; BYTES],
    length: usize,
    cut: bool,
}

impl<const BYTES: usize> Text<BYTES> {
    const DOTS: &'static [u8; 3] = b"...";
    /// The number of bytes for text, beside the dots and the terminating zero.
    const ROOM: usize = BYTES - Self::DOTS.len() - 1;

    /// Returns an empty text.
    #[expect(clippy::new_without_default, reason = "it is made for a line, and never the default of anything")]
    pub const fn new() -> Self {
        Self { bytes: [0; BYTES], length: 0, cut: false }
    }

    /// Adds text at the end.
    pub fn append(&mut self, text: fmt::Arguments<'_>) {
        // It fails only when the text is cut, which the dots show.
        let _ = self.write_fmt(text);
    }

    /// Returns the text with a zero at its end.
    pub fn terminated(&mut self) -> &CStr {
        if self.cut {
            self.bytes[self.length..][..Self::DOTS.len()].copy_from_slice(Self::DOTS);
        }
        CStr::from_bytes_until_nul(&self.bytes).unwrap_or_default()
    }
}

impl<const BYTES: usize> Write for Text<BYTES> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        if self.cut {
            return Err(fmt::Error);
        }
        let count = whole_characters(text.as_bytes(), Self::ROOM - self.length);
        self.bytes[self.length..][..count].copy_from_slice(&text.as_bytes()[..count]);
        self.length += count;
        self.cut = count < text.len();
        if self.cut { Err(fmt::Error) } else { Ok(()) }
    }
}

/// Returns the length of the longest beginning of a text that has at most `room` bytes and ends with a complete
/// character.
pub fn whole_characters(text: &[u8], room: usize) -> usize {
    // The bytes of a character after its first begin with the bits 10.
    let begins_character = |length: &usize| text.get(*length).is_none_or(|byte| byte & 0xC0 != 0x80);
    (0..=room.min(text.len())).rev().find(begins_character).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use std::string::String;
    use std::vec::Vec;

    use super::Text;

    proptest! {
        /// Appended text is there completely, or as many complete characters of it as fit, and dots.
        #[test]
        fn long_text_is_cut_behind_a_whole_character(parts in proptest::collection::vec("[a-zäß€𝄞]{0,12}", 0..4)) {
            const ROOM: usize = 16;
            let whole: String = parts.concat();
            let mut text = Text::<{ ROOM + 4 }>::new();
            for part in &parts {
                text.append(format_args!("{part}"));
            }
            let shown = text.terminated().to_str().expect("characters are whole");
            if whole.len() <= ROOM {
                prop_assert_eq!(shown, whole);
            } else {
                let ends: Vec<usize> = whole.char_indices().map(|(end, _)| end).filter(|end| *end <= ROOM).collect();
                let longest = ends.last().copied().unwrap_or_default();
                prop_assert_eq!(shown.strip_suffix("..."), Some(&whole[..longest]));
            }
        }
    }
}
