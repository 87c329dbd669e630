// SPDX-License-Identifier: Apache-2.0
//! The federate's side of our clock synchronization.

use lf_coordination::clock_sync::{ClockCorrection, Estimator, Exchange, Poll, Round, Tracker};
use lf_model::time::{Instant, Interval};

use super::{ATTENUATION, Algorithm, RoundTimes};

/// The estimators and the correction of our federate.
#[derive(Clone, Debug)]
pub struct Ours {
    poll: Poll,
    clock: ClockCorrection,
    tracker: Tracker,
}

impl Default for Ours {
    fn default() -> Self {
        Self { poll: Poll::NONE, clock: ClockCorrection::NONE, tracker: Tracker::new() }
    }
}

impl Ours {
    /// Returns the drift that the estimator found, in parts per billion.
    pub fn drift_ppb(&self) -> Option<i32> {
        self.tracker.line().map(|line| line.drift_ppb)
    }
}

impl Algorithm for Ours {
    fn begins(&mut self, now: i64) -> bool {
        self.poll.begin(Instant::from_nanos(now))
    }

    fn answered(&mut self, now: i64) {
        self.poll.answer(Instant::from_nanos(now));
    }

    fn initial(&mut self, exchanges: &[[i64; 5]]) {
        let mut estimator = Estimator::new();
        for [t1, t2, t3, t4, _] in exchanges.iter().map(|times| times.map(Instant::from_nanos)) {
            estimator.record(Exchange { t1, t2, t3, t4 });
        }
        if let Some(estimate) = estimator.estimate() {
            self.clock = ClockCorrection::with_offset(estimate.offset);
        }
    }

    fn round(&mut self, times: &RoundTimes) {
        let RoundTimes { t1, t2, t3, t4, r4, t5, r5 } = *times;
        let Some(r4) = r4 else { return };
        let exchange = Exchange {
            t1: Instant::from_nanos(t1),
            t2: Instant::from_nanos(t2),
            t3: Instant::from_nanos(t3),
            t4: Instant::from_nanos(t4),
        };
        let gap = r5.map(|r5| Interval::from_nanos(((r5 - r4) - (t5 - t4)).abs()));
        self.tracker.record(Round { exchange, gap });
        if let Some(line) = self.tracker.line() {
            self.clock.steer(Instant::from_nanos(r5.map_or(r4, |r5| r5.max(r4))), &line, ATTENUATION);
        }
    }

    fn physical(&self, own: i64) -> i64 {
        self.clock.physical(Instant::from_nanos(own)).as_nanos()
    }
}
