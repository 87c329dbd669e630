// SPDX-License-Identifier: Apache-2.0
//! Packing of sentences.

use std::sync::LazyLock;

use super::pairs::PAIRS;

/// The byte that stands for the first pair. Those that do not fit behind it have the bytes from 0 on, below the
/// characters.
pub(super) const FIRST: u8 = 128;
/// The maximum number of pairs: bytes that are neither characters nor [`VALUE`].
#[cfg(test)]
pub(super) const PAIRS_MAX: usize = 128 + VALUE as usize;
/// The byte that stands for a value.
pub(super) const VALUE: u8 = b' ' - 1;

/// The end mark of a value in a list of values: no value contains it.
pub(super) const END: &str = "\u{1f}";

/// Returns the meanings of the bytes of pairs.
pub(super) fn pairs() -> &'static [[u8; 2]] {
    static MADE: LazyLock<Vec<[u8; 2]>> = LazyLock::new(|| {
        let mut made: Vec<(String, [u8; 2])> = Vec::new();
        for parts in PAIRS {
            let byte = |part: &str| match made.iter().position(|(text, _)| text == part) {
                Some(index) => of_pair(index),
                None => character(part),
            };
            made.push((parts.concat(), parts.map(byte)));
        }
        made.into_iter().map(|(_, pair)| pair).collect()
    });
    &MADE
}

/// Returns the byte of a part that is not a pair. In the list of pairs `{}` is a value.
fn character(part: &str) -> u8 {
    match part.as_bytes() {
        [character] => *character,
        b"{}" => VALUE,
        _ => panic!("`{part}` in the list of pairs is neither a character nor an earlier pair"),
    }
}

/// Returns the byte of the pair at this index of the list.
pub(super) fn of_pair(index: usize) -> u8 {
    FIRST.wrapping_add(u8::try_from(index).expect("there are fewer pairs than bytes"))
}

/// Returns the bytes with pairs replaced, in the order of the list, in which they were found.
pub(super) fn pack(text: &[u8]) -> Vec<u8> {
    let mut bytes = text.to_vec();
    for (index, pair) in pairs().iter().enumerate() {
        replace(&mut bytes, *pair, of_pair(index));
    }
    bytes
}

/// Replaces each occurrence of two bytes by one byte.
pub(super) fn replace(bytes: &mut Vec<u8>, pair: [u8; 2], by: u8) {
    let mut index = 0;
    while index + 1 < bytes.len() {
        if bytes[index..].starts_with(&pair) {
            bytes.splice(index..index + 2, [by]);
        }
        index += 1;
    }
}
