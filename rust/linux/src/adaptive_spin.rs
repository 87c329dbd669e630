// SPDX-License-Identifier: Apache-2.0
//! Adaptive spin-then-park: the event loop polls for input for a short time before it sleeps.
//!
//! A sleeping thread is woken by the processor on which the sender runs. On a virtual machine, and wherever a processor
//! sleeps deeply, that takes several times as long as everything that an RTI does with a message. So the loop spins for
//! a short while before it sleeps, and around the time at which it expects something. A timer wakes a processor just as
//! late, so the loop also spins for the end of a long wait: the program's event then begins at its time, and not after
//! it. Where the caller expects nothing and input comes periodically, the loop expects the next period.
//!
//! The lateness of the last timers determines how long before a time the loop has to be awake: a few microseconds on
//! one computer, 100 µs and more on another.
//!
//! Spinning has to pay. Each miss makes the next spins rarer, down to one in 2⁶ waits, and one hit, or a wait that
//! would have been one, restores them. So a loop without input sleeps; a busy loop spins for at most [`SPIN_MAX`] at a
//! time; and one that is preempted stops at once.
//!
//! A thread that yields runs again only after every other runnable thread, which takes milliseconds; a sleeping one is
//! scheduled as soon as its event arrives. So after each preemption the loop only sleeps for [`PAUSE_PER_LOSS`] times
//! as long as it lost: where others want the processors, it soon never spins.

use std::time::{Duration, Instant};

/// The longest spin after input: the time of a few answers of another process.
const SPIN_MAX: Duration = Duration::from_micros(50);
/// The margin added to the lateness of timers, because it varies.
const LEAD_MIN: Duration = Duration::from_micros(20);
/// The longest lead before a timer.
const LEAD_MAX: Duration = Duration::from_micros(400);
/// Only a wait that is longer than this many leads ends with a spin, so that spinning never takes much of a processor.
const LEADS_PER_WAIT: u32 = 10;
/// The time after an expected time at which the loop gives up.
const WINDOW: Duration = Duration::from_micros(150);
/// A yield that takes longer than this was a preemption.
const PREEMPTED_MIN: Duration = Duration::from_micros(20);
/// The length of the pause after a preemption, in units of the lost time; so spinning loses at most half a percent of
/// the time.
const PAUSE_PER_LOSS: u32 = 200;
/// The maximum exponent of the backoff.
const BACKOFF_MAX: u32 = 6;

/// The exponential backoff of one kind of spin.
#[derive(Clone, Copy, Debug, Default)]
struct Backoff {
    /// The number of misses since the last hit.
    misses: u32,
    /// The number of waits to come without a spin.
    skipped: u32,
}

impl Backoff {
    /// Returns whether the coming wait has this spin.
    fn spins(self) -> bool {
        self.skipped == 0
    }

    /// Records a wait: `hit` says whether a spin found something, or would have.
    fn record(&mut self, hit: bool) {
        if hit {
            *self = Self::default();
        } else if self.skipped > 0 {
            self.skipped -= 1;
        } else {
            self.misses = (self.misses + 1).min(BACKOFF_MAX);
            self.skipped = (1 << self.misses) - 1;
        }
    }
}

/// The period of the input.
#[derive(Clone, Copy, Debug, Default)]
struct Period {
    last: Option<Instant>,
    interval: Option<Duration>,
    next: Option<Instant>,
}

impl Period {
    /// Records input that came after the loop has slept. If two intervals are equal, the next input is expected after
    /// the same interval.
    fn record(&mut self, now: Instant) {
        let interval = self.last.map(|last| now.duration_since(last));
        let is_steady = |(a, b): (Duration, Duration)| a.abs_diff(b) <= WINDOW;
        self.next = interval.zip(self.interval).filter(|both| is_steady(*both)).map(|(interval, _)| now + interval);
        (self.last, self.interval) = (Some(now), interval);
    }
}

/// Decides when the loop spins.
#[derive(Debug, Default)]
pub(crate) struct AdaptiveSpin {
    after: Backoff,
    around: Backoff,
    expected: Option<Instant>,
    period: Period,
    /// The average lateness of timers.
    lateness: Duration,
    /// The end of the pause after a preemption.
    paused_until: Option<Instant>,
}

/// The plan of one wait: when to spin, and when to sleep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    begin: Instant,
    /// Spin until this time first.
    pub(crate) first: Option<Instant>,
    /// Then sleep until the first of these times, and spin until the second.
    pub(crate) second: Option<(Instant, Instant)>,
    expected: Option<Instant>,
    lead: Duration,
}

impl AdaptiveSpin {
    /// Expects input at this time, during the next wait only.
    pub(crate) fn expect(&mut self, time: Option<Instant>) {
        self.expected = time;
    }

    /// Returns the plan for a wait from now until `end`.
    pub(crate) fn plan(&mut self, begin: Instant, end: Option<Instant>) -> Plan {
        let before_end = |time: Instant| end.map_or(time, |end| time.min(end));
        let lead = self.lead();
        let is_paused = self.paused_until.is_some_and(|until| begin < until);
        let is_ahead = |expected: &Instant| *expected > begin && end.is_none_or(|end| *expected < end);
        let last = self.period.next.filter(|next| next.duration_since(begin) >= LEADS_PER_WAIT * lead);
        let expected = self.expected.take().filter(is_ahead).or(last.filter(is_ahead));
        let around = expected.filter(|_| self.around.spins()).map(|expected| {
            let sleeps_until = expected.checked_sub(lead).unwrap_or(begin).max(begin);
            (sleeps_until, before_end(expected + WINDOW))
        });
        let is_long = |end: &Instant| end.duration_since(begin) >= LEADS_PER_WAIT * lead;
        let before = end.filter(is_long).and_then(|end| Some((end.checked_sub(lead)?, end)));
        let first = self.after.spins().then(|| before_end(begin + SPIN_MAX));
        Plan {
            begin,
            first: first.filter(|_| !is_paused),
            second: around.or(before).filter(|_| !is_paused),
            expected,
            lead,
        }
    }

    /// Returns how long before a time the loop has to be woken to be awake at that time.
    fn lead(&self) -> Duration {
        (self.lateness + self.lateness / 2 + LEAD_MIN).min(LEAD_MAX)
    }

    /// Records that a timer for `time` has woken the loop at `now`.
    pub(crate) fn record_lateness(&mut self, time: Instant, now: Instant) {
        self.lateness = (self.lateness * 7 + now.duration_since(time).min(LEAD_MAX)) / 8;
    }

    /// Records that a spin that ends at `now` has lost the processor for this long.
    pub(crate) fn record_preemption(&mut self, now: Instant, lost: Duration) {
        self.paused_until = Some(now + PAUSE_PER_LOSS * lost);
    }

    /// Records the end of a wait; `ready` says whether input ended it.
    pub(crate) fn record(&mut self, plan: &Plan, now: Instant, ready: bool) {
        if ready && now.duration_since(plan.begin) >= LEADS_PER_WAIT * plan.lead {
            self.period.record(now);
        }
        // Input that came while the loop slept had to wake it first.
        self.after.record(ready && now.duration_since(plan.begin) <= 2 * SPIN_MAX);
        // Earlier input is something else; the expected input may still come.
        if let Some(expected) = plan.expected
            && now + plan.lead >= expected
            && (ready || now >= expected + WINDOW)
        {
            self.around.record(ready && now <= expected + WINDOW);
        }
    }
}

/// The outcome of a spin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SpinOutcome {
    /// Whether it has found something.
    pub(crate) ready: bool,
    /// The time for which another thread had the processor, if that ended the spin.
    pub(crate) preempted: Option<Duration>,
}

/// Spins with `poll` until it finds something, or the time has come, or another thread takes the processor.
pub(crate) fn spin_until(end: Instant, mut poll: impl FnMut() -> bool) -> SpinOutcome {
    let mut now = Instant::now();
    loop {
        let ready = poll();
        if ready || now >= end {
            return SpinOutcome { ready, preempted: None };
        }
        std::thread::yield_now();
        let before = std::mem::replace(&mut now, Instant::now());
        let preempted = Some(now.duration_since(before)).filter(|time| *time > PREEMPTED_MIN);
        if preempted.is_some() {
            return SpinOutcome { ready: poll(), preempted };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes `count` waits that begin at `begin` and end after `waited`; returns how many of them spun first.
    fn looks(spin: &mut AdaptiveSpin, begin: Instant, count: usize, waited: Duration, ready: bool) -> usize {
        let mut looks = 0;
        for _ in 0..count {
            let plan = spin.plan(begin, None);
            looks += usize::from(plan.first.is_some());
            spin.record(&plan, begin + waited, ready);
        }
        looks
    }

    /// Without input, or with late input, a loop sleeps all the time but for one spin in 64 waits; with immediate
    /// answers, it spins in each.
    #[test]
    fn a_loop_looks_as_often_as_that_is_of_use() {
        let (mut spin, begin) = (AdaptiveSpin::default(), Instant::now());
        let late = Duration::from_millis(10);
        looks(&mut spin, begin, 200, late, true);
        assert_eq!(looks(&mut spin, begin, 640, late, true), 10);
        assert_eq!(looks(&mut spin, begin, 640, late, false), 10);
        // The first wait without a spin that would have been a hit restores it.
        assert!(looks(&mut spin, begin, 100, SPIN_MAX / 2, true) >= 99);
    }

    /// A wait for a time ends its spins at that time.
    #[test]
    fn no_look_goes_beyond_the_end_of_the_wait() {
        let (mut spin, begin) = (AdaptiveSpin::default(), Instant::now());
        let end = begin + SPIN_MAX / 5;
        spin.expect(Some(begin + SPIN_MAX / 10));
        let plan = spin.plan(begin, Some(end));
        assert_eq!(plan.first, Some(end));
        assert_eq!(plan.second, Some((begin, end)));
    }

    /// An expected time counts for one wait, and only if it lies within it.
    #[test]
    fn an_expected_time_counts_for_the_wait_in_which_it_lies() {
        let (mut spin, begin) = (AdaptiveSpin::default(), Instant::now());
        let (second, wake) = (Duration::from_secs(1), begin + Duration::from_millis(5));
        let expected = wake + LEAD_MIN;
        spin.expect(Some(expected));
        let plan = spin.plan(begin, Some(begin + second));
        assert_eq!(plan.second, Some((wake, expected + WINDOW)));
        assert_eq!(spin.plan(begin, None).second, None);
        let end = begin + LEAD_MIN;
        for gone in [begin, end] {
            spin.expect(Some(gone));
            assert_eq!(spin.plan(begin, Some(end)).second, None);
        }
    }

    /// Periodic input is expected, and other input is not.
    #[test]
    fn the_next_beat_is_expected() {
        let (mut spin, mut begin) = (AdaptiveSpin::default(), Instant::now());
        let period = Duration::from_millis(10);
        let mut wait = |waited| {
            let plan = spin.plan(begin, None);
            begin += waited;
            spin.record(&plan, begin, true);
            plan.second.map(|(_, until)| until.duration_since(begin) + waited)
        };
        assert_eq!([period; 5].map(&mut wait), [None, None, None, Some(period + WINDOW), Some(period + WINDOW)]);
        assert_eq!([2 * period, 4 * period, 8 * period].map(wait)[1..], [None, None]);
    }

    /// Input long before an expected time is something else, and does not count as a miss.
    #[test]
    fn early_input_does_not_count_against_an_expectation() {
        let (mut spin, begin) = (AdaptiveSpin::default(), Instant::now());
        for _ in 0..100 {
            spin.expect(Some(begin + Duration::from_millis(10)));
            let plan = spin.plan(begin, None);
            assert!(plan.second.is_some());
            spin.record(&plan, begin + Duration::from_millis(1), true);
        }
    }

    /// The loop is awake at the end of a long wait: as early as timers are late, and for at most a tenth of the time.
    #[test]
    fn a_long_wait_ends_with_a_look() {
        let (mut spin, begin) = (AdaptiveSpin::default(), Instant::now());
        let late = Duration::from_micros(100);
        for _ in 0..100 {
            spin.record_lateness(begin, begin + late);
        }
        let lead = spin.lead();
        assert!(lead > late && lead < 2 * late, "{lead:?}");
        let wake = begin + (LEADS_PER_WAIT - 1) * lead;
        assert_eq!(spin.plan(begin, Some(wake + lead)).second, Some((wake, wake + lead)));
        assert_eq!(spin.plan(begin, Some(wake)).second, None);
        spin.record_lateness(begin, begin + Duration::from_secs(1));
        assert!(spin.lead() <= LEAD_MAX);
    }

    /// Where nothing comes at the expected times, the loop sleeps through them, and where something begins to come at
    /// them, it is awake again.
    #[test]
    fn expectations_that_are_not_met_are_given_up_until_they_are() {
        let (mut spin, begin) = (AdaptiveSpin::default(), Instant::now());
        let expected = begin + Duration::from_millis(5);
        let mut looks = |count, end, ready| {
            let mut looks = 0;
            for _ in 0..count {
                spin.expect(Some(expected));
                let plan = spin.plan(begin, None);
                looks += usize::from(plan.second.is_some());
                spin.record(&plan, end, ready);
            }
            looks
        };
        looks(200, expected + 10 * WINDOW, true);
        assert_eq!(looks(640, expected + 10 * WINDOW, true), 10);
        assert!(looks(100, expected + WINDOW / 2, true) >= 99);
    }

    /// Where others want the processor, the loop sleeps for many times as long as they have had it, also before the end
    /// of a wait and around expected times. Then it spins again.
    #[test]
    fn a_loop_that_has_lost_its_processor_sleeps() {
        let (mut spin, begin) = (AdaptiveSpin::default(), Instant::now());
        let (second, lost) = (Duration::from_secs(1), Duration::from_millis(3));
        spin.record_preemption(begin, lost);
        let until = begin + PAUSE_PER_LOSS * lost;
        let mut looks = |begin| {
            spin.expect(Some(begin + second / 2));
            let plan = spin.plan(begin, Some(begin + second));
            let without_expectation = spin.plan(begin, Some(begin + second));
            [plan.first.is_some(), plan.second.is_some(), without_expectation.second.is_some()]
        };
        assert_eq!([begin, begin + lost].map(&mut looks), [[false; 3]; 2]);
        assert_eq!(looks(until), [true; 3]);
    }

    /// A spin ends with a hit, and at its end.
    #[test]
    fn a_look_ends_with_what_it_finds() {
        let begin = Instant::now();
        let mut count = 0;
        let found = spin_until(begin + Duration::from_secs(3600), || {
            count += 1;
            true
        });
        assert_eq!((found, count), (SpinOutcome { ready: true, preempted: None }, 1));
        assert!(!spin_until(begin, || false).ready);
    }
}
