// SPDX-License-Identifier: Apache-2.0
//! The memory layout of a path between two federates.

use super::delay::PathDelay;

/// The storage of one [`Path`]. It consists of plain numbers, so that memory from the system, all zero, can be used
/// unchanged: what a federation does not use is then never touched.
pub type PathWords = [u64; 2];

/// A path to or from a federate, with the minimum delay of all that lead the same way; or one connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Path {
    /// The federate at the other end.
    pub(super) federate: u16,
    pub(super) delay: PathDelay,
    /// The index of this same path in the row of the federate at the other end.
    pub(super) reverse: u16,
}

impl Path {
    /// Writes the path to its words. The number beside it stays unchanged.
    pub(super) fn write(self, words: &mut PathWords) {
        let (time, microsteps) = self.delay.parts();
        // At most one for each federate that the path goes through, whose number has 16 bits.
        let microsteps = microsteps.min(u16::MAX.into());
        let beside = words[1] & BESIDE;
        *words = [
            time.cast_unsigned(),
            u64::from(self.federate) | u64::from(microsteps) << 16 | u64::from(self.reverse) << 32 | beside,
        ];
    }

    /// Returns the path in these words.
    pub(super) fn read(words: &PathWords) -> Self {
        let [time, rest] = *words;
        Self {
            federate: part(rest, 0),
            delay: PathDelay::of_parts(time.cast_signed(), part(rest, 16).into()),
            reverse: part(rest, 32),
        }
    }
}

/// Returns the federate at the other end, without the rest of the path.
pub(super) fn federate(words: &PathWords) -> usize {
    part(words[1], 0).into()
}

/// The bits of a number that lies beside the path and is independent of it: a node of the tournament of a row.
const BESIDE: u64 = 0xffff << 48;

/// Returns the number beside a path.
pub(super) fn beside(words: &PathWords) -> u16 {
    part(words[1], 48)
}

/// Sets the number beside a path.
pub(super) fn set_beside(words: &mut PathWords, number: u16) {
    words[1] = words[1] & !BESIDE | u64::from(number) << 48;
}

#[expect(clippy::cast_possible_truncation, reason = "16 bits are taken out of 64")]
fn part(word: u64, shift: u32) -> u16 {
    (word >> shift) as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn written_paths_are_read_back(
            time in 0..i64::MAX, microsteps: u16, federate: u16, reverse: u16, first: u16, second: u16,
        ) {
            let path = Path { federate, delay: PathDelay::of_parts(time, microsteps.into()), reverse };
            let mut words = PathWords::default();
            set_beside(&mut words, first);
            path.write(&mut words);
            prop_assert_eq!((Path::read(&words), beside(&words)), (path, first));
            prop_assert_eq!(super::federate(&words), usize::from(federate));
            set_beside(&mut words, second);
            prop_assert_eq!((Path::read(&words), beside(&words)), (path, second));
        }
    }
}
