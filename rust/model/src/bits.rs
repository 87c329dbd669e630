// SPDX-License-Identifier: Apache-2.0
//! A set of small numbers over borrowed words.
use crate::ids::ReactionId;

#[derive(Debug)]
pub(crate) struct Bits<'a>(pub(crate) &'a mut [u32]);

impl Bits<'_> {
    /// Adds a number; returns `false` when it was in already.
    pub(crate) fn insert(&mut self, index: u16) -> bool {
        let (word, bit) = (usize::from(index / 32), 1 << (index % 32));
        let new = self.0[word] & bit == 0;
        self.0[word] |= bit;
        new
    }

    pub(crate) fn contains(&self, index: u16) -> bool {
        self.0[usize::from(index / 32)] & (1 << (index % 32)) != 0
    }

    pub(crate) fn remove(&mut self, index: u16) {
        self.0[usize::from(index / 32)] &= !(1 << (index % 32));
    }

    /// Adds reactions, those of a word at once: a processor waits for what it has just written.
    pub(crate) fn insert_reactions(&mut self, reactions: &[ReactionId]) {
        let mut rest = reactions;
        while let [first, others @ ..] = rest {
            let (word, mut bits) = (first.0 / 32, 1 << (first.0 % 32));
            rest = others;
            while let [next, others @ ..] = rest
                && next.0 / 32 == word
            {
                bits |= 1 << (next.0 % 32);
                rest = others;
            }
            self.0[usize::from(word)] |= bits;
        }
    }

    /// Returns the smallest number in the set, not below `from`.
    pub(crate) fn first_from(&self, from: u16) -> Option<u16> {
        let mut mask = u32::MAX << (from % 32);
        for (index, word) in self.0.iter().enumerate().skip(usize::from(from / 32)) {
            if word & mask != 0 {
                return Some(number(index, word & mask));
            }
            mask = u32::MAX;
        }
        None
    }

    /// Removes the next number of a walk, and returns it; `None` if that is above `last`.
    #[inline]
    pub(crate) fn next(&mut self, walk: &mut Walk, last: u16) -> Option<u16> {
        let mut rest = self.0[walk.word] & walk.above;
        while rest == 0 && walk.word < usize::from(last / 32) {
            self.0[walk.word] = 0;
            walk.word += 1;
            (rest, walk.above) = (self.0[walk.word], u32::MAX);
        }
        let next = (rest != 0).then(|| number(walk.word, rest)).filter(|next| *next <= last);
        if next.is_some() {
            walk.above = !(rest ^ (rest - 1));
        } else {
            self.0[walk.word] &= walk.above;
        }
        next
    }

    pub(crate) fn pop_first(&mut self) -> Option<u16> {
        let first = self.first_from(0)?;
        self.remove(first);
        Some(first)
    }

    #[cfg(feature = "workers")]
    pub(crate) fn insert_all(&mut self, other: &Bits<'_>) {
        for (word, bits) in self.0.iter_mut().zip(&*other.0) {
            *word |= bits;
        }
    }

    pub(crate) fn clear(&mut self) {
        self.0.fill(0);
    }
}

/// A walk upwards through a set that has nothing below its begin, and gets nothing below where the walk is. The set
/// loses the numbers of a word when the walk leaves it: a processor waits for what it has just written.
pub(crate) struct Walk {
    word: usize,
    /// The bits of the word that the walk has not reached.
    above: u32,
}

impl Walk {
    /// Returns a walk to the numbers above this one.
    pub(crate) fn above(number: u16) -> Self {
        Self { word: usize::from(number / 32), above: (u32::MAX << (number % 32)) << 1 }
    }
}

/// Returns the smallest number of a word that has some.
#[inline]
fn number(index: usize, word: u32) -> u16 {
    // The index fits: a set is never larger than its 16-bit numbers.
    #[allow(clippy::cast_possible_truncation)]
    let number = index as u16 * 32 + word.trailing_zeros() as u16;
    number
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// It behaves like a sorted set of the numbers that its words have bits for.
        #[test]
        fn bits_are_a_sorted_set(changes in prop::collection::vec((0..96u16, any::<bool>()), 0..50), from in 0..96u16) {
            let mut words = [0; 3];
            let mut bits = Bits(&mut words);
            let mut set = BTreeSet::new();
            for (number, insert) in changes {
                if insert {
                    prop_assert_eq!(bits.insert(number), set.insert(number));
                } else {
                    bits.remove(number);
                    set.remove(&number);
                }
                prop_assert_eq!(bits.first_from(from), set.range(from..).next().copied());
                prop_assert_eq!(bits.contains(from), set.contains(&from));
            }
            while let Some(first) = bits.pop_first() {
                prop_assert_eq!(Some(first), set.pop_first());
            }
            prop_assert!(set.is_empty());
        }

        /// A walk finds all numbers up to the last, also those that are added above it meanwhile, and removes them.
        #[test]
        fn a_walk_takes_what_is_ahead(
            begin in prop::collection::btree_set(0..96u16, 1..30),
            added in prop::collection::vec(0..96u16, 0..30),
            last in 0..96u16,
        ) {
            let mut words = [0; 3];
            let mut bits = Bits(&mut words);
            let mut set = begin;
            for number in &set {
                bits.insert(*number);
            }
            let mut at = set.pop_first().unwrap();
            bits.remove(at);
            let (last, mut added, mut walk) = (last.max(at), added.into_iter(), Walk::above(at));
            loop {
                for number in added.by_ref().take(2).filter(|number| *number > at) {
                    bits.insert_reactions(&[ReactionId(number)]);
                    set.insert(number);
                }
                let next = set.first().copied().filter(|next| *next <= last);
                prop_assert_eq!(bits.next(&mut walk, last), next);
                let Some(next) = next else { break };
                set.remove(&next);
                at = next;
            }
            prop_assert!((0..96).all(|number| bits.contains(number) == set.contains(&number)));
        }
    }
}
