// SPDX-License-Identifier: Apache-2.0
//! Estimates an offset from exchanges.
//!
//! An exchange tells the offset only up to half of its round trip, because the division of the round trip between there
//! and back is unknown. Queues, retransmissions and busy processors only ever make an exchange longer. So the fastest
//! exchanges are the true ones, and a mean over all of them would carry every disturbance into the clock. The estimator
//! keeps the [`KEPT`] fastest and takes the mean over those that are nearly as fast as the fastest one. However
//! disturbed the exchanges were, there is always an estimate, with a measure of its quality.

use core::fmt;

use lf_model::time::{Instant, Interval};

/// The number of exchanges to keep: the fastest so far.
const KEPT: usize = 4;

/// The four instants of one exchange.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Exchange {
    /// The time of sending T1, by the RTI's clock.
    pub t1: Instant,
    /// The time of receiving T1, by the federate's clock.
    pub t2: Instant,
    /// The time after writing T3, by the federate's clock.
    pub t3: Instant,
    /// The time of receiving T3, by the RTI's clock.
    pub t4: Instant,
}

impl Exchange {
    /// Returns the time that the messages took there and back: (T4 − T1) − (T3 − T2).
    ///
    /// Negative when a clock was set, or the federate was interrupted between writing T3 and reading its clock.
    pub fn round_trip(&self) -> Interval {
        Interval::from_nanos(self.at_rti().saturating_sub(self.at_federate()))
    }

    /// Returns the time by which the federate's clock is behind the RTI's, if there and back took equally long: ((T4 −
    /// T1) − (T3 − T2)) / 2 − (T2 − T1).
    pub fn offset(&self) -> Interval {
        let there = nanos(self.t2).saturating_sub(nanos(self.t1));
        Interval::from_nanos((self.round_trip().as_nanos() / 2).saturating_sub(there))
    }

    /// Returns the measure of disturbance in ns, less is better: (T4 − T1) + (T3 − T2).
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

/// The estimate from the exchanges so far.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Estimate {
    /// The offset to add to the federate's own clock.
    pub offset: Interval,
    /// The round trip of the fastest exchange; the offset is wrong by at most half of it.
    pub round_trip: Interval,
    /// The number of exchanges in the mean.
    pub used: u16,
    /// The number of exchanges.
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

/// Collects exchanges; see the module's description for the estimate from them.
#[derive(Clone, Debug, Default)]
pub struct Estimator {
    /// The fastest exchanges, the least disturbed first.
    kept: heapless::Vec<Exchange, KEPT>,
    seen: u16,
}

impl Estimator {
    /// Returns an estimator without exchanges.
    pub const fn new() -> Self {
        Self { kept: heapless::Vec::new(), seen: 0 }
    }

    /// Returns the number of exchanges.
    pub const fn seen(&self) -> u16 {
        self.seen
    }

    /// Records one exchange, in a bounded number of steps.
    pub fn record(&mut self, exchange: Exchange) {
        self.seen = self.seen.saturating_add(1);
        let place = self.kept.iter().take_while(|kept| kept.disturbance() <= exchange.disturbance()).count();
        if place == KEPT {
            return;
        }
        self.kept.truncate(KEPT - 1);
        // The vector now has a free entry, and `place` is at most its length.
        let _ = self.kept.insert(place, exchange);
    }

    /// Returns the estimate from all exchanges so far; `None` without any.
    pub fn estimate(&self) -> Option<Estimate> {
        let quickest = self.kept.first()?;
        // An exchange may take up to half as long again as the fastest: a mean over similar exchanges evens out the
        // clocks' steps.
        let limit = quickest.disturbance().saturating_add(quickest.disturbance() / 2);
        let mut deviations: i64 = 0;
        let mut used: u16 = 0;
        for exchange in self.kept.iter().take_while(|exchange| exchange.disturbance() <= limit) {
            // Relative to the first, because sums of offsets between a clock since boot and one since 1970 exceed 64
            // bits.
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
