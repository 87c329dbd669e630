// SPDX-License-Identifier: Apache-2.0
//! How a federate tells an RTI of this kind that it wants to stop in turn.
//!
//! The stock RTI grants a stop to all federates at once. But one that has been granted tags far ahead, because nobody
//! upstream had anything to do, then runs its last tag without what those upstream send at theirs. An RTI that knows
//! better takes back what it has granted of the stop tag and later ones, so that such a federate asks for that tag
//! again and gets it as any other. The stock federates do not know of that, and recordings of the stock RTI do not
//! show it; so it is done only for federates that ask for it, in a way that no other RTI notices: in the last digits
//! of the clock that they tell, less than a millisecond.
//!
//! What takes grants back is a PTAG of the stop tag just before `STOP_GRANTED`. The stock RTI never grants a tag
//! provisionally that it has granted before, so a federate can tell. It allows nothing, but says as ever that nothing
//! comes before that tag; and when the federate has done all that is before, it says so (LTC).

use lf_model::time::{Instant, Interval};

/// The digits count within so many nanoseconds.
const PERIOD_NS: i64 = 1_000_000;
/// What they are.
const DIGITS_NS: i64 = 424_243;

/// The earliest time from `clock` on that asks for a stop in turn.
pub fn ask(clock: Instant) -> Instant {
    clock + Interval((DIGITS_NS - clock.as_nanos().rem_euclid(PERIOD_NS)).rem_euclid(PERIOD_NS))
}

/// The earliest time from `clock` on that does not ask for it.
pub fn refrain(clock: Instant) -> Instant {
    if is_asked(clock) { clock + Interval(1) } else { clock }
}

/// Whether a federate that tells this clock asks for a stop in turn. One in a million of others does by chance,
/// and gets a PTAG too many.
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
            prop_assert!(!is_asked(refrain(Instant(clock))) && !is_asked(refrain(asking)));
        }
    }
}
