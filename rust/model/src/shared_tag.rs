// SPDX-License-Identifier: Apache-2.0
//! A tag for other threads and interrupts.
use core::sync::atomic::{AtomicU32, Ordering, fence};

use crate::time::{Instant, Microstep, Tag};

/// A tag that one thread writes without a lock, and others read.
///
/// There are two copies. A reader uses the one that was completed last, and begins again if that has changed meanwhile;
/// so it never waits for the writer, which an interrupt may have interrupted. Not all processors have atomics of 64
/// bits.
#[derive(Debug)]
pub struct SharedTag {
    /// The number of tags so far; the last bit is the position of the complete copy.
    count: AtomicU32,
    /// The halves of the time, and the microstep.
    copies: [[AtomicU32; 3]; 2],
}

impl SharedTag {
    /// Returns one that contains [`Tag::NEVER`].
    pub const fn new() -> Self {
        const fn never() -> [AtomicU32; 3] {
            let [low, high, microstep] = words(Tag::NEVER);
            [AtomicU32::new(low), AtomicU32::new(high), AtomicU32::new(microstep)]
        }
        Self { count: AtomicU32::new(0), copies: [never(), never()] }
    }

    /// Stores a tag; one thread at a time calls it.
    pub fn set(&self, tag: Tag) {
        let next = self.count.load(Ordering::Relaxed).wrapping_add(1);
        // With that of `get`: who reads a word that is stored now sees that the count is no longer the one before.
        fence(Ordering::Release);
        self.copy(next).iter().zip(words(tag)).for_each(|(word, value)| word.store(value, Ordering::Relaxed));
        self.count.store(next, Ordering::Release);
    }

    /// Returns whether this is the tag; no other thread stores more than one meanwhile.
    #[inline]
    pub fn is(&self, tag: Tag) -> bool {
        let words = self.copy(self.count.load(Ordering::Relaxed)).iter().zip(words(tag));
        // Word by word: a processor is slow to load several words at once just after it has stored each.
        words.fold(true, |is, (word, value)| is & (word.load(Ordering::Relaxed) == value))
    }

    /// Returns the tag.
    pub fn get(&self) -> Tag {
        loop {
            let count = self.count.load(Ordering::Acquire);
            let words = self.read(count);
            fence(Ordering::Acquire);
            if self.count.load(Ordering::Relaxed) == count {
                return tag_of(words);
            }
        }
    }

    fn copy(&self, count: u32) -> &[AtomicU32; 3] {
        &self.copies[usize::from(count % 2 == 1)]
    }

    fn read(&self, count: u32) -> [u32; 3] {
        self.copy(count).each_ref().map(|word| word.load(Ordering::Relaxed))
    }
}

impl Default for SharedTag {
    fn default() -> Self {
        Self::new()
    }
}

// The two halves of the time.
#[expect(clippy::cast_possible_truncation)]
const fn words(tag: Tag) -> [u32; 3] {
    let time = tag.time.as_nanos().cast_unsigned();
    [time as u32, (time >> 32) as u32, tag.microstep.0]
}

fn tag_of([low, high, microstep]: [u32; 3]) -> Tag {
    let time = u64::from(high) << 32 | u64::from(low);
    Tag::new(Instant::from_nanos(time.cast_signed()), Microstep(microstep))
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;

    /// A reader of the one is not disturbed by the writer of the other.
    #[test]
    fn a_tag_and_the_next_one_are_in_different_copies() {
        let shared = SharedTag::new();
        for count in [0_u32, 1, 2, 3, 4, u32::MAX] {
            assert!(!core::ptr::eq(shared.copy(count), shared.copy(count.wrapping_add(1))), "{count}");
        }
    }

    #[test]
    fn readers_see_whole_tags_in_the_order_in_which_they_were_stored() {
        static SHARED: SharedTag = SharedTag::new();
        static DONE: AtomicBool = AtomicBool::new(false);
        // Both halves of the time and the microstep are the same number.
        let tag = |number: u32| tag_of([number; 3]);
        assert_eq!(SHARED.get(), Tag::NEVER);
        SHARED.set(tag(0));
        let reader = std::thread::spawn(|| {
            let mut last = 0;
            while !DONE.load(Ordering::Acquire) {
                let [low, high, microstep] = words(SHARED.get());
                assert!(low == high && low == microstep && low >= last, "{low} {high} {microstep} after {last}");
                last = low;
            }
        });
        for number in 1..200_000 {
            assert!(!SHARED.is(tag(number)));
            SHARED.set(tag(number));
            assert!(SHARED.is(tag(number)));
        }
        DONE.store(true, Ordering::Release);
        assert!(reader.join().is_ok());
    }
}
