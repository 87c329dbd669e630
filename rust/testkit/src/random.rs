// SPDX-License-Identifier: Apache-2.0
//! Choices that a seed decides, for simulations and tests: the same on every computer and in every version, so that a
//! seed names a run. None of them is hard to predict.

/// The increment of the generator's state.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// Mixes all bits of a number: each bit of the result depends on each bit of the number.
pub fn mix(number: u64) -> u64 {
    let mut mixed = number.wrapping_add(STEP);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

/// Combines two numbers into one that depends on their order.
pub fn combine(one: u64, other: u64) -> u64 {
    mix(mix(one) ^ other)
}

/// Numbers that follow from a seed (`SplitMix64`).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// Returns the generator of this seed.
    pub fn new(seed: u64) -> Self {
        Self(mix(seed))
    }

    /// Returns any number.
    pub fn number(&mut self) -> u64 {
        let number = mix(self.0);
        self.0 = self.0.wrapping_add(STEP);
        number
    }

    /// Returns a number below `bound`, or 0 if `bound` is 0.
    pub fn below(&mut self, bound: u64) -> u64 {
        if bound == 0 { 0 } else { self.number() % bound }
    }

    /// Returns a number between the two, which are included.
    pub fn range(&mut self, least: u64, most: u64) -> u64 {
        least + self.below(most.saturating_sub(least).saturating_add(1))
    }

    /// Returns a length or position as [`range`](Self::range) does.
    pub fn count(&mut self, least: usize, most: usize) -> usize {
        let number = self.range(least as u64, most as u64);
        usize::try_from(number).unwrap_or(most)
    }

    /// Returns a time in nanoseconds as [`range`](Self::range) does.
    pub fn time(&mut self, least: i64, most: i64) -> i64 {
        let span = u64::try_from(most.saturating_sub(least)).unwrap_or(0);
        least.saturating_add(i64::try_from(self.below(span.saturating_add(1))).unwrap_or(0))
    }

    /// Returns true with a probability of `percent` in a hundred.
    pub fn percent(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }

    /// Returns any byte.
    pub fn byte(&mut self) -> u8 {
        u8::try_from(self.below(256)).unwrap_or(0)
    }

    /// Returns a position in a list of this length, or 0 if it is empty.
    pub fn index(&mut self, len: usize) -> usize {
        self.count(0, len.saturating_sub(1))
    }

    /// Returns one of these.
    ///
    /// # Panics
    /// If there are none.
    pub fn one_of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.index(list.len())]
    }
}

#[cfg(test)]
mod tests {
    use super::{Random, mix};

    #[test]
    fn the_numbers_are_those_of_splitmix64() {
        // The first three numbers of seed 0, as its authors and many libraries have them.
        let known = [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4, 0x06c4_5d18_8009_454f];
        let mut random = Random(0);
        assert_eq!([random.number(), random.number(), random.number()], known);
        assert_eq!(mix(0), known[0]);
    }

    #[test]
    fn choices_keep_within_their_bounds_and_reach_them() {
        let mut random = Random::new(1);
        let times: Vec<i64> = (0..200).map(|_| random.time(-2, 2)).collect();
        assert_eq!((times.iter().min(), times.iter().max()), (Some(&-2), Some(&2)));
        let counts: Vec<usize> = (0..200).map(|_| random.count(3, 5)).collect();
        assert_eq!((counts.iter().min(), counts.iter().max()), (Some(&3), Some(&5)));
        assert_eq!((random.below(0), random.index(0), random.index(1)), (0, 0, 0));
        assert_eq!((random.percent(0), random.percent(100)), (false, true));
        assert_eq!(random.time(i64::MAX, i64::MIN), i64::MAX);
    }
}
