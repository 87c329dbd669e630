// SPDX-License-Identifier: Apache-2.0
//! How a federate tells an RTI of this kind that it wants to stop in turn.
//!
//! The stock RTI grants a stop to all federates at once. But one that has been granted tags far ahead, because nobody
//! upstream had anything to do, then runs its last tag without what those upstream send at theirs. An RTI that knows
//! better grants the stop to such a federate when those upstream have come to their last tag. The stock federates do
//! not count on that, and recordings of the stock RTI do not show it; so it is done only for federates that ask for it,
//! in a way that no other RTI notices: in the last digits of the clock that they tell, less than a millisecond.

use lf_model::time::{Instant, Interval};

/// The digits count within so many nanoseconds.
const PERIOD_NS: i64 = 1_000_000;
/// What they are.
const DIGITS_NS: i64 = 424_243;

/// The earliest time from `clock` on that asks for a stop in turn.
pub fn ask(clock: Instant) -> Instant {
    clock + Interval((DIGITS_NS - clock.as_nanos().rem_euclid(PERIOD_NS)).rem_euclid(PERIOD_NS))
}

/// Whether a federate that tells this clock asks for a stop in turn. One in a million does by chance, and stops a
/// little later.
pub fn is_asked(clock: Instant) -> bool {
    clock.as_nanos().rem_euclid(PERIOD_NS) == DIGITS_NS
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_clock_that_asks_is_at_most_a_millisecond_ahead(clock in i64::MIN / 2..i64::MAX / 2) {
            let asking = ask(Instant(clock));
            prop_assert!(is_asked(asking));
            prop_assert!((0..PERIOD_NS).contains(&asking.since(Instant(clock)).as_nanos()));
        }
    }
}
