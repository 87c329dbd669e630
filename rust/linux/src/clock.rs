// SPDX-License-Identifier: Apache-2.0
//! Linux's clocks as the platform clock.

use lf_model::time::Instant;
use rustix::time::{ClockId, clock_gettime};

/// A clock that counts nanoseconds since 1970 and never runs backwards.
///
/// The wall clock may be set while a program runs; so it is read once, and the monotonic clock counts from there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    /// Wall-clock time minus monotonic time, in nanoseconds.
    offset: i64,
}

impl Clock {
    /// The number of readings of the two clocks side by side; the closest pair counts.
    const READINGS: usize = 8;

    /// Reads the wall clock.
    pub(crate) fn new() -> Self {
        let reading = || {
            let before = nanoseconds(ClockId::Monotonic);
            let wall = nanoseconds(ClockId::Realtime);
            let after = nanoseconds(ClockId::Monotonic);
            (after - before, wall - (before + (after - before) / 2))
        };
        let (_, offset) = (1..Self::READINGS).map(|_| reading()).fold(reading(), Ord::min);
        Self { offset }
    }

    /// Returns the time now.
    pub(crate) fn now(self) -> Instant {
        self.at(nanoseconds(ClockId::Monotonic))
    }

    /// Returns the time at which the system's monotonic clock showed this number of nanoseconds.
    pub(crate) fn at(self, monotonic: i64) -> Instant {
        Instant::from_nanos(monotonic.saturating_add(self.offset))
    }
}

impl Default for Clock {
    fn default() -> Self {
        Self::new()
    }
}

fn nanoseconds(clock: ClockId) -> i64 {
    let time = clock_gettime(clock);
    time.tv_sec.saturating_mul(1_000_000_000).saturating_add(time.tv_nsec)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every reading is at least the one before it, and within the era of the wall clock.
    #[test]
    fn clock_does_not_run_backwards_and_counts_from_1970() {
        let clock = Clock::new();
        let mut last = clock.now();
        for _ in 0..10_000 {
            let next = clock.now();
            assert!(next >= last);
            last = next;
        }
        let wall = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).expect("after 1970");
        let difference = i128::from(last.as_nanos()) - i128::try_from(wall.as_nanos()).expect("fits");
        assert!(difference.abs() < 60_000_000_000, "the clocks differ by {difference} ns");
    }
}
