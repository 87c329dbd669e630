// SPDX-License-Identifier: Apache-2.0
//! Linux's clocks as the platform clock.

use std::sync::atomic::{AtomicI64, Ordering};

use lf_model::time::Instant;
use rustix::time::{ClockId, clock_gettime};

/// The beginning of virtual time: 1 January 2000, in nanoseconds.
pub(crate) const VIRTUAL_START: i64 = 946_684_800_000_000_000;

/// A clock that counts nanoseconds since 1970 and never runs backwards.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Clock {
    /// The system's monotonic clock.
    ///
    /// The wall clock may be set while a program runs; so it is read once, and the monotonic clock counts from there.
    System {
        /// Wall-clock time minus monotonic time, in nanoseconds.
        offset: i64,
    },
    /// A clock that stands still until the program has nothing to do, and then shows the time that it waits for.
    Virtual(&'static AtomicI64),
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
        Self::System { offset }
    }

    /// Returns the virtual clock, which begins at the same time in each run.
    pub(crate) fn of_virtual_time() -> Self {
        static TIME: AtomicI64 = AtomicI64::new(VIRTUAL_START);
        Self::Virtual(&TIME)
    }

    /// Returns the time now.
    pub(crate) fn now(self) -> Instant {
        self.at(nanoseconds(ClockId::Monotonic))
    }

    /// Returns the time at which the system's monotonic clock showed this number of nanoseconds; of a virtual clock,
    /// the time now.
    pub(crate) fn at(self, monotonic: i64) -> Instant {
        match self {
            Self::System { offset } => Instant::from_nanos(monotonic.saturating_add(offset)),
            Self::Virtual(time) => Instant::from_nanos(time.load(Ordering::Relaxed)),
        }
    }

    /// Returns whether this is a virtual clock.
    pub(crate) fn is_virtual(self) -> bool {
        matches!(self, Self::Virtual(_))
    }

    /// Makes a virtual clock show a later time; others go by themselves.
    pub(crate) fn skip_to(self, time: Instant) {
        if let Self::Virtual(now) = self {
            now.fetch_max(time.as_nanos(), Ordering::Relaxed);
        }
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

    #[test]
    fn virtual_time_passes_only_when_it_is_waited_for() {
        let clock = Clock::of_virtual_time();
        let start = clock.now();
        assert_eq!(clock.now(), start);
        let later = Instant::from_nanos(start.as_nanos() + 1_000_000_000);
        clock.skip_to(later);
        assert_eq!(clock.now(), later);
        clock.skip_to(start);
        assert_eq!(clock.now(), later, "it does not run backwards");
    }

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
