// SPDX-License-Identifier: Apache-2.0
//! Counters of frequent events. Only some of them are logged, because a reader of a log would miss everything else
//! otherwise.

use core::fmt;

use lf_texts::say;

/// The number of times that something has happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Tally(u32);

impl Tally {
    /// A counter at 0.
    pub const NOTHING: Self = Self(0);

    /// Counts one more; returns the number so far.
    pub fn count(&mut self) -> Times {
        self.0 = self.0.saturating_add(1);
        Times(self.0)
    }

    /// Returns the number so far.
    pub fn times(self) -> Times {
        Times(self.0)
    }
}

/// The number of times that something has happened. Displays as ` (100 so far)` behind a sentence about the last time,
/// and as nothing behind one about the only time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Times(pub u32);

impl Times {
    /// Returns whether to log this time: the first, the tenth, the hundredth, and so on.
    pub fn is_logged(self) -> bool {
        self.0.checked_ilog10().is_some_and(|digits| self.0 == 10_u32.pow(digits))
    }
}

impl fmt::Display for Times {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 > 1 { say!(f, " ({} so far)", self.0) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn the_first_time_is_told_and_then_each_that_is_ten_times_as_many() {
        let mut tally = Tally::NOTHING;
        let told: std::vec::Vec<_> = (0..20_000).map(|_| tally.count()).filter(|times| times.is_logged()).collect();
        assert_eq!(told, [1, 10, 100, 1000, 10_000].map(Times));
        assert_eq!([told[0].to_string(), told[1].to_string()], ["", " (10 so far)"]);
        assert!(!Times(0).is_logged() && !Times(u32::MAX).is_logged());
    }
}
