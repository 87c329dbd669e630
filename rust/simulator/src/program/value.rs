// SPDX-License-Identifier: Apache-2.0
//! The values of all ports and actions: a number that depends on all causes, and its length in bytes.

use lf_model::{Payload, PayloadError};
use lf_testkit::random::combine;

/// The number of bytes in one word of a value.
const WORD: usize = 8;

/// A value. Its bytes repeat its number, so that lost or mixed bytes are detected.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Value {
    number: u64,
    words: u16,
}

impl Value {
    /// Returns a value that follows from `origin` and can cause this number of reactions in a row.
    pub(crate) fn new(origin: u64, energy: u64, shape: Shape) -> Self {
        let number = (origin << 8) | energy.min(255);
        let words = match shape {
            Shape::Fixed(words) => words,
            Shape::UpTo(most) => 1 + u16::try_from(combine(origin, 1) % u64::from(most)).unwrap_or(0),
        };
        Self { number, words }
    }

    pub(crate) fn number(self) -> u64 {
        self.number
    }

    pub(crate) fn energy(self) -> u64 {
        self.number & 0xff
    }
}

/// The length of a type's values, in words.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Shape {
    Fixed(u16),
    /// From one word to this many.
    UpTo(u16),
}

impl Shape {
    /// Returns the shape of a type by its name in Rust.
    pub(crate) fn of(ty: &str) -> Self {
        match ty {
            "[u64; 32]" => Self::Fixed(32),
            "heapless::Vec<u64, 40>" => Self::UpTo(40),
            _ => Self::Fixed(1),
        }
    }

    /// Returns the maximum number of bytes of a value.
    pub(crate) fn bytes_max(self) -> usize {
        let (Self::Fixed(words) | Self::UpTo(words)) = self;
        WORD * usize::from(words)
    }
}

impl Payload for Value {
    const MAX_LEN: usize = WORD * 40;

    fn encode(&self, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        let needed = WORD * usize::from(self.words);
        let available = bytes.len();
        let target = bytes.get_mut(..needed).ok_or(PayloadError::NoRoom { needed, available })?;
        for word in target.chunks_exact_mut(WORD) {
            word.copy_from_slice(&self.number.to_le_bytes());
        }
        Ok(needed)
    }

    fn decode(bytes: &[u8]) -> Result<Self, PayloadError> {
        let (words, rest) = bytes.as_chunks::<WORD>();
        let Some(first) = words.first().filter(|_| rest.is_empty()) else {
            return Err(PayloadError::Remainder { element: WORD, found: bytes.len() });
        };
        if words.iter().any(|word| word != first) {
            return Err(PayloadError::TooLong { capacity: 1, found: 2 });
        }
        let words = u16::try_from(words.len()).unwrap_or(u16::MAX);
        Ok(Self { number: u64::from_le_bytes(*first), words })
    }
}
