// SPDX-License-Identifier: Apache-2.0
//! println! and related macros for Zephyr's console, without allocation.

use core::fmt::{self, Write};

use lf_embedded::whole_characters;

use crate::kconfig::LF_LINE_SIZE;
use crate::mutex::ConsoleGuard;
use crate::raw;

/// Prints; see [`crate::print!`].
pub fn print(text: fmt::Arguments<'_>) {
    let _turn = ConsoleGuard::lock();
    let mut piece = Piece::new();
    // Displaying fails only when a value's own Display does; what it has written until then is printed.
    let _ = piece.write_fmt(text);
    piece.flush();
}

/// Prints a line; see [`crate::println!`].
pub fn print_line(text: fmt::Arguments<'_>) {
    print(format_args!("{text}\n"));
}

/// Text for the console: collected, because each call of the console has a cost.
struct Piece {
    bytes: [u8; LF_LINE_SIZE],
    length: usize,
}

impl Piece {
    const fn new() -> Self {
        Self { bytes: [0; LF_LINE_SIZE], length: 0 }
    }

    fn flush(&mut self) {
        // SAFETY: the pointer and the length are those of a part of one array; the console only reads it.
        unsafe { raw::k_str_out(self.bytes.as_mut_ptr().cast(), self.length) };
        self.length = 0;
    }
}

impl Write for Piece {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        // Bytes, and not texts: an index into a text can be wrong in a way whose message takes 5 KiB of tables.
        let mut rest = text.as_bytes();
        while !rest.is_empty() {
            let room = &mut self.bytes[self.length..];
            let (piece, behind) = rest.split_at(whole_characters(rest, room.len()));
            if piece.is_empty() {
                // The next character does not fit any more; an empty line has room for each.
                self.flush();
                continue;
            }
            room[..piece.len()].copy_from_slice(piece);
            self.length += piece.len();
            rest = behind;
        }
        Ok(())
    }
}
