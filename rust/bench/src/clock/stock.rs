// SPDX-License-Identifier: Apache-2.0
//! A model of the stock federate's clock synchronization, by its documented rules.
//!
//! The error of an exchange, with the correction so far, is ((T4 − T1) − (T3 − T2)) / 2 − (T2 − T1). Before the start,
//! the mean of k errors becomes the correction. Afterwards the federate divides each error by the attenuation, and adds
//! the mean over k rounds to the correction at once. A round does not count if the gap between T4 and the coded probe
//! changed by 100 µs on the way. The federate discards the k exchanges if the standard deviation of their round trips
//! is 100 µs or more.

use super::{ATTENUATION, Algorithm, RoundTimes, TRIALS};

const GUARD_BAND_NS: i64 = 100_000;
/// The time that the stock RTI waits for an answer.
const TIME_OUT_NS: i64 = 1_000_000_000;

/// The state of the stock federate's clock synchronization.
#[derive(Clone, Debug, Default)]
pub struct Stock {
    /// The earliest time at which the RTI begins the next round.
    next_round: i64,
    offset: i64,
    history: i64,
    round_trips: Vec<i64>,
}

impl Stock {
    fn exchange(&mut self, [t1, t2, t3, t4]: [i64; 4], attenuation: i64) {
        let count = i64::try_from(TRIALS).unwrap_or(1);
        let round_trip = (t4 - t1) - (t3 - t2);
        let error = round_trip / 2 - (t2 + self.offset - t1);
        self.round_trips.push(round_trip);
        self.history += error / attenuation / count;
        if self.round_trips.len() == TRIALS {
            if self.deviation_ns() < GUARD_BAND_NS {
                self.offset += self.history;
            }
            self.history = 0;
            self.round_trips.clear();
        }
    }

    fn deviation_ns(&self) -> i64 {
        let count = i64::try_from(self.round_trips.len()).unwrap_or(1).max(1);
        let mean = self.round_trips.iter().sum::<i64>() / count;
        let variance = self.round_trips.iter().map(|value| (value - mean).pow(2)).sum::<i64>() / count;
        i64::try_from(variance.unsigned_abs().isqrt()).unwrap_or(i64::MAX)
    }
}

impl Algorithm for Stock {
    fn begins(&mut self, now: i64) -> bool {
        let begins = now >= self.next_round;
        if begins {
            self.next_round = now + TIME_OUT_NS;
        }
        begins
    }

    fn answered(&mut self, now: i64) {
        self.next_round = now;
    }

    fn initial(&mut self, exchanges: &[[i64; 5]]) {
        for [t1, t2, t3, t4, _] in exchanges {
            self.exchange([*t1, *t2, *t3, *t4], 1);
        }
    }

    fn round(&mut self, times: &RoundTimes) {
        let RoundTimes { t1, t2, t3, t4, r4, t5, r5 } = *times;
        let (Some(r4), Some(r5)) = (r4, r5) else { return };
        if ((r5 - r4) - (t5 - t4)).abs() < GUARD_BAND_NS {
            self.exchange([t1, t2, t3, t4], ATTENUATION.into());
        }
    }

    fn physical(&self, own: i64) -> i64 {
        own + self.offset
    }
}
