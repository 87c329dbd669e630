// SPDX-License-Identifier: Apache-2.0
//! From exchanges to an offset.
//!
//! An exchange tells the offset only up to half of its round trip, for nobody knows how the round trip was divided
//! between there and back. Queues, retransmissions and busy processors only ever make an exchange longer. So the
//! quickest exchanges are the true ones, and a mean over all of them would carry every disturbance into the clock. The
//! estimator keeps the [`KEPT`] quickest and takes the mean over those that are nearly as quick as the very quickest.
//! However disturbed the exchanges were, there is always an estimate, and it says how good it is.

use core::fmt;

use lf_model::time::{Instant, Interval};

/// How many exchanges are kept: the quickest so far.
const KEPT: usize = 4;

/// The four instants of one exchange.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Exchange {
    /// When the RTI sent T1, by its clock.
    pub t1: Instant,
    /// When the federate received T1, by its own clock.
    pub t2: Instant,
    /// When the federate had written T3, by its own clock.
    pub t3: Instant,
    /// When the RTI received T3, by its clock.
    pub t4: Instant,
}

impl Exchange {
    /// How long the messages were on their way, there and back: (T4 − T1) − (T3 − T2).
    ///
    /// Negative when a clock was set, or the federate was interrupted between writing T3 and reading its clock.
    pub fn round_trip(&self) -> Interval {
        Interval::from_nanos(self.at_rti().saturating_sub(self.at_federate()))
    }

    /// How far the federate's clock is behind the RTI's, if there and back took equally long:
    /// ((T4 − T1) − (T3 − T2)) / 2 − (T2 − T1).
    pub fn offset(&self) -> Interval {
        let there = nanos(self.t2).saturating_sub(nanos(self.t1));
        Interval::from_nanos((self.round_trip().as_nanos() / 2).saturating_sub(there))
    }

    /// The measure of disturbance in ns, less is better: (T4 − T1) + (T3 − T2).
    ///
    /// The round trip would not do: an interruption between the writing of T3 and the reading of the clock makes it
    /// *shorter* and the offset wrong. Here every delay counts, wherever it happened. An exchange whose round trip is
    /// negative cannot be true and comes last.
    fn disturbance(&self) -> i64 {
        if self.round_trip().as_nanos() < 0 {
            return i64::MAX;
        }
        self.at_rti().saturating_add(self.at_federate())
    }

    fn at_rti(&self) -> i64 {
        nanos(self.t4).saturating_sub(nanos(self.t1))
    }

    fn at_federate(&self) -> i64 {
        nanos(self.t3).saturating_sub(nanos(self.t2))
    }
}

/// What the exchanges so far say.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Estimate {
    /// To be added to the federate's own clock.
    pub offset: Interval,
    /// The round trip of the quickest exchange; the offset is wrong by at most half of it.
    pub round_trip: Interval,
    /// How many exchanges the offset is the mean of.
    pub used: u16,
    /// How many exchanges there were.
    pub seen: u16,
}

impl fmt::Display for Estimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { offset, round_trip, used, seen } = self;
        write!(
            f,
            "own clock off by {} ns, round trip {} ns, from the best {used} of {seen} exchanges",
            -offset.as_nanos(),
            round_trip.as_nanos()
        )
    }
}

/// Collects exchanges; see the module's description for what it makes of them.
#[derive(Clone, Debug, Default)]
pub struct Estimator {
    /// The quickest exchanges, the least disturbed first.
    kept: heapless::Vec<Exchange, KEPT>,
    seen: u16,
}

impl Estimator {
    /// An estimator without exchanges.
    pub const fn new() -> Self {
        Self { kept: heapless::Vec::new(), seen: 0 }
    }

    /// How many exchanges there were.
    pub const fn seen(&self) -> u16 {
        self.seen
    }

    /// Takes one exchange into account. Takes a bounded number of steps.
    pub fn record(&mut self, exchange: Exchange) {
        self.seen = self.seen.saturating_add(1);
        let place = self.kept.iter().take_while(|kept| kept.disturbance() <= exchange.disturbance()).count();
        if place == KEPT {
            return;
        }
        self.kept.truncate(KEPT - 1);
        // The vector now has a free place, and `place` is at most its length.
        let _ = self.kept.insert(place, exchange);
    }

    /// The estimate from all exchanges so far; `None` while there were none.
    pub fn estimate(&self) -> Option<Estimate> {
        let quickest = self.kept.first()?;
        // Half as long again as the quickest is still taken: a mean over alike exchanges evens out the clocks' steps.
        let limit = quickest.disturbance().saturating_add(quickest.disturbance() / 2);
        let mut deviations: i64 = 0;
        let mut used: u16 = 0;
        for exchange in self.kept.iter().take_while(|exchange| exchange.disturbance() <= limit) {
            // Relative to the first, for offsets between a clock since boot and one since 1970 add up beyond 64 bits.
            let deviation = exchange.offset().as_nanos().saturating_sub(quickest.offset().as_nanos());
            deviations = deviations.saturating_add(deviation);
            used += 1;
        }
        let mean = deviations / i64::from(used.max(1));
        Some(Estimate {
            offset: Interval::from_nanos(quickest.offset().as_nanos().saturating_add(mean)),
            round_trip: quickest.round_trip(),
            used,
            seen: self.seen,
        })
    }
}

fn nanos(instant: Instant) -> i64 {
    instant.as_nanos()
}
