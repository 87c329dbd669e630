// SPDX-License-Identifier: Apache-2.0
//! When the event loop looks for input instead of sleeping.
//!
//! A thread that sleeps is woken by the processor on which the sender runs; on a virtual machine, and wherever a
//! processor sleeps deeply, that takes several times as long as all that an RTI does with a message. So the loop looks
//! for a short while before it sleeps, and around the time at which it was told to expect something. A timer wakes a
//! processor just as late, so the loop also looks for the rest of a wait, if that is long: the program's event begins
//! at its time then, and not after it. Where nobody tells it what to expect, and what comes has a rhythm, it expects
//! the next beat.
//!
//! How long before a time it has to be up for that is what the last timers have taught: a few microseconds on one
//! computer, 100 µs and more on another.
//!
//! Looking has to pay. Each look in vain makes the next ones rarer, down to one in 2⁶ waits, and one that found
//! something, or would have, brings them back. So a loop to which nothing comes sleeps; one that is busy looks for no
//! more than [`SPAN`] at a time; and one whose processor is wanted by somebody else gives it up at once.
//!
//! Who gives a processor up while he is awake has it back when all others have had their turns, which are of
//! milliseconds; who sleeps has it when something comes. So after each such loss the loop only sleeps for
//! [`WAITS_PER_LOSS`] times as long as the loss was: where the processors are wanted, it soon never looks.

use std::time::{Duration, Instant};

/// How long a look after something has come takes at most: the time of a few answers of another process.
const SPAN: Duration = Duration::from_micros(50);
/// What is added to how late timers are, for they are not always as late.
const LEAD_MIN: Duration = Duration::from_micros(20);
/// No timer is waited for longer than this.
const LEAD_MAX: Duration = Duration::from_micros(400);
/// Only a wait that is longer than so many leads ends with a look, so that looking never takes much of a processor.
const LEADS_PER_WAIT: u32 = 10;
/// How long after an expected time it gives up.
const WINDOW: Duration = Duration::from_micros(150);
/// A yield that takes longer than this was somebody else's turn on the processor.
const CROWDED: Duration = Duration::from_micros(20);
/// How many times as long as such a turn there is no look; so looking loses half a percent of the time at most.
const WAITS_PER_LOSS: u32 = 200;
/// After so many looks in vain they do not become rarer.
const IN_VAIN_MAX: u32 = 6;

/// What one kind of look has been good for.
#[derive(Clone, Copy, Debug, Default)]
struct Worth {
    /// Looks in vain since one that was not.
    in_vain: u32,
    /// So many waits are to come without a look.
    skipped: u32,
}

impl Worth {
    /// Whether the coming wait has this look.
    fn looks(self) -> bool {
        self.skipped == 0
    }

    /// A wait is over: `paid` says whether a look found something, or would have.
    fn learn(&mut self, paid: bool) {
        if paid {
            *self = Self::default();
        } else if self.skipped > 0 {
            self.skipped -= 1;
        } else {
            self.in_vain = (self.in_vain + 1).min(IN_VAIN_MAX);
            self.skipped = (1 << self.in_vain) - 1;
        }
    }
}

/// The rhythm in which input comes.
#[derive(Clone, Copy, Debug, Default)]
struct Rhythm {
    beat: Option<Instant>,
    interval: Option<Duration>,
    next: Option<Instant>,
}

impl Rhythm {
    /// Input has come after the loop has slept: if it comes as long after the last one as that came after the one
    /// before, the next one will.
    fn learn(&mut self, now: Instant) {
        let interval = self.beat.map(|beat| now.duration_since(beat));
        let is_steady = |(a, b): (Duration, Duration)| a.abs_diff(b) <= WINDOW;
        self.next = interval.zip(self.interval).filter(|both| is_steady(*both)).map(|(interval, _)| now + interval);
        (self.beat, self.interval) = (Some(now), interval);
    }
}

/// Decides when the loop looks.
#[derive(Debug, Default)]
pub(crate) struct Attention {
    after: Worth,
    around: Worth,
    expected: Option<Instant>,
    rhythm: Rhythm,
    /// How late timers are, on average.
    lateness: Duration,
    /// Before this time there is no look: others want the processor.
    crowded_until: Option<Instant>,
}

/// One wait: when to look, and when to sleep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    begin: Instant,
    /// Looks until this time, first of all.
    pub(crate) first: Option<Instant>,
    /// Then sleeps until the first of these times, and looks until the second.
    pub(crate) second: Option<(Instant, Instant)>,
    expected: Option<Instant>,
    lead: Duration,
}

impl Attention {
    /// Something is likely to come at this time; counts for one wait.
    pub(crate) fn expect(&mut self, time: Option<Instant>) {
        self.expected = time;
    }

    /// How to wait from now until `end`.
    pub(crate) fn plan(&mut self, begin: Instant, end: Option<Instant>) -> Plan {
        let before_end = |time: Instant| end.map_or(time, |end| time.min(end));
        let lead = self.lead();
        let is_crowded = self.crowded_until.is_some_and(|until| begin < until);
        let is_ahead = |expected: &Instant| *expected > begin && end.is_none_or(|end| *expected < end);
        let beat = self.rhythm.next.filter(|next| next.duration_since(begin) >= LEADS_PER_WAIT * lead);
        let expected = self.expected.take().filter(is_ahead).or(beat.filter(is_ahead));
        let around = expected.filter(|_| self.around.looks()).map(|expected| {
            let sleeps_until = expected.checked_sub(lead).unwrap_or(begin).max(begin);
            (sleeps_until, before_end(expected + WINDOW))
        });
        let is_long = |end: &Instant| end.duration_since(begin) >= LEADS_PER_WAIT * lead;
        let before = end.filter(is_long).and_then(|end| Some((end.checked_sub(lead)?, end)));
        let first = self.after.looks().then(|| before_end(begin + SPAN));
        Plan {
            begin,
            first: first.filter(|_| !is_crowded),
            second: around.or(before).filter(|_| !is_crowded),
            expected,
            lead,
        }
    }

    /// How long before a time the loop has to be woken to be awake at that time.
    fn lead(&self) -> Duration {
        (self.lateness + self.lateness / 2 + LEAD_MIN).min(LEAD_MAX)
    }

    /// A timer for this time has woken the loop now.
    pub(crate) fn learn_lateness(&mut self, time: Instant, now: Instant) {
        self.lateness = (self.lateness * 7 + now.duration_since(time).min(LEAD_MAX)) / 8;
    }

    /// A look that ends now has lost the processor for so long.
    pub(crate) fn learn_loss(&mut self, now: Instant, lost: Duration) {
        self.crowded_until = Some(now + WAITS_PER_LOSS * lost);
    }

    /// The wait is over, at this time; `came`: because something has come.
    pub(crate) fn learn(&mut self, plan: &Plan, now: Instant, came: bool) {
        if came && now.duration_since(plan.begin) >= LEADS_PER_WAIT * plan.lead {
            self.rhythm.learn(now);
        }
        // What came while the loop slept has had to wake it first.
        self.after.learn(came && now.duration_since(plan.begin) <= 2 * SPAN);
        // What comes before is something else; what is expected may still come.
        if let Some(expected) = plan.expected
            && now + plan.lead >= expected
            && (came || now >= expected + WINDOW)
        {
            self.around.learn(came && now <= expected + WINDOW);
        }
    }
}

/// How a look has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Looked {
    /// It has found something.
    pub(crate) came: bool,
    /// For how long somebody else had the processor, if it ended for that.
    pub(crate) lost: Option<Duration>,
}

/// Looks with `look` until it finds something, or the time has come, or somebody else wants the processor.
pub(crate) fn look_until(end: Instant, mut look: impl FnMut() -> bool) -> Looked {
    let mut now = Instant::now();
    loop {
        let came = look();
        if came || now >= end {
            return Looked { came, lost: None };
        }
        std::thread::yield_now();
        let before = std::mem::replace(&mut now, Instant::now());
        let lost = Some(now.duration_since(before)).filter(|lost| *lost > CROWDED);
        if lost.is_some() {
            return Looked { came: look(), lost };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Waits that begin at `begin`, each of which ends as `ends` says: how many of them looked first.
    fn looks(attention: &mut Attention, begin: Instant, count: usize, waited: Duration, came: bool) -> usize {
        let mut looks = 0;
        for _ in 0..count {
            let plan = attention.plan(begin, None);
            looks += usize::from(plan.first.is_some());
            attention.learn(&plan, begin + waited, came);
        }
        looks
    }

    /// Where nothing comes, or late, a loop sleeps all the time but for one look in 64 waits; where answers come at
    /// once, it looks in each.
    #[test]
    fn a_loop_looks_as_often_as_that_is_of_use() {
        let (mut attention, begin) = (Attention::default(), Instant::now());
        let late = Duration::from_millis(10);
        looks(&mut attention, begin, 200, late, true);
        assert_eq!(looks(&mut attention, begin, 640, late, true), 10);
        assert_eq!(looks(&mut attention, begin, 640, late, false), 10);
        // The first wait without a look in which it would have been of use brings it back.
        assert!(looks(&mut attention, begin, 100, SPAN / 2, true) >= 99);
    }

    /// A wait for a time ends its looks at that time.
    #[test]
    fn no_look_goes_beyond_the_end_of_the_wait() {
        let (mut attention, begin) = (Attention::default(), Instant::now());
        let end = begin + SPAN / 5;
        attention.expect(Some(begin + SPAN / 10));
        let plan = attention.plan(begin, Some(end));
        assert_eq!(plan.first, Some(end));
        assert_eq!(plan.second, Some((begin, end)));
    }

    /// What is expected counts for one wait, and only if it is to come in it.
    #[test]
    fn an_expected_time_counts_for_the_wait_in_which_it_lies() {
        let (mut attention, begin) = (Attention::default(), Instant::now());
        let (second, wake) = (Duration::from_secs(1), begin + Duration::from_millis(5));
        let expected = wake + LEAD_MIN;
        attention.expect(Some(expected));
        let plan = attention.plan(begin, Some(begin + second));
        assert_eq!(plan.second, Some((wake, expected + WINDOW)));
        assert_eq!(attention.plan(begin, None).second, None);
        let end = begin + LEAD_MIN;
        for gone in [begin, end] {
            attention.expect(Some(gone));
            assert_eq!(attention.plan(begin, Some(end)).second, None);
        }
    }

    /// What comes in a rhythm is expected, and what does not is not.
    #[test]
    fn the_next_beat_is_expected() {
        let (mut attention, mut begin) = (Attention::default(), Instant::now());
        let period = Duration::from_millis(10);
        let mut wait = |waited| {
            let plan = attention.plan(begin, None);
            begin += waited;
            attention.learn(&plan, begin, true);
            plan.second.map(|(_, until)| until.duration_since(begin) + waited)
        };
        assert_eq!([period; 5].map(&mut wait), [None, None, None, Some(period + WINDOW), Some(period + WINDOW)]);
        assert_eq!([2 * period, 4 * period, 8 * period].map(wait)[1..], [None, None]);
    }

    /// What comes long before what is expected is something else, and says nothing of it.
    #[test]
    fn early_input_does_not_count_against_an_expectation() {
        let (mut attention, begin) = (Attention::default(), Instant::now());
        for _ in 0..100 {
            attention.expect(Some(begin + Duration::from_millis(10)));
            let plan = attention.plan(begin, None);
            assert!(plan.second.is_some());
            attention.learn(&plan, begin + Duration::from_millis(1), true);
        }
    }

    /// The end of a long wait is met awake: as early as timers are late, and in a tenth of the time at most.
    #[test]
    fn a_long_wait_ends_with_a_look() {
        let (mut attention, begin) = (Attention::default(), Instant::now());
        let late = Duration::from_micros(100);
        for _ in 0..100 {
            attention.learn_lateness(begin, begin + late);
        }
        let lead = attention.lead();
        assert!(lead > late && lead < 2 * late, "{lead:?}");
        let wake = begin + (LEADS_PER_WAIT - 1) * lead;
        assert_eq!(attention.plan(begin, Some(wake + lead)).second, Some((wake, wake + lead)));
        assert_eq!(attention.plan(begin, Some(wake)).second, None);
        attention.learn_lateness(begin, begin + Duration::from_secs(1));
        assert!(attention.lead() <= LEAD_MAX);
    }

    /// Where nothing comes at the expected times, the loop sleeps through them, and where something begins to come at
    /// them, it is awake again.
    #[test]
    fn expectations_that_are_not_met_are_given_up_until_they_are() {
        let (mut attention, begin) = (Attention::default(), Instant::now());
        let expected = begin + Duration::from_millis(5);
        let mut looks = |count, end, came| {
            let mut looks = 0;
            for _ in 0..count {
                attention.expect(Some(expected));
                let plan = attention.plan(begin, None);
                looks += usize::from(plan.second.is_some());
                attention.learn(&plan, end, came);
            }
            looks
        };
        looks(200, expected + 10 * WINDOW, true);
        assert_eq!(looks(640, expected + 10 * WINDOW, true), 10);
        assert!(looks(100, expected + WINDOW / 2, true) >= 99);
    }

    /// Where others want the processor, the loop sleeps for many times as long as they have had it; so it does before
    /// the end of a wait and around expected times. Then it looks again.
    #[test]
    fn a_loop_that_has_lost_its_processor_sleeps() {
        let (mut attention, begin) = (Attention::default(), Instant::now());
        let (second, lost) = (Duration::from_secs(1), Duration::from_millis(3));
        attention.learn_loss(begin, lost);
        let until = begin + WAITS_PER_LOSS * lost;
        let mut looks = |begin| {
            attention.expect(Some(begin + second / 2));
            let plan = attention.plan(begin, Some(begin + second));
            let without_expectation = attention.plan(begin, Some(begin + second));
            [plan.first.is_some(), plan.second.is_some(), without_expectation.second.is_some()]
        };
        assert_eq!([begin, begin + lost].map(&mut looks), [[false; 3]; 2]);
        assert_eq!(looks(until), [true; 3]);
    }

    /// A look ends with what it finds, and at its end.
    #[test]
    fn a_look_ends_with_what_it_finds() {
        let begin = Instant::now();
        let mut count = 0;
        let found = look_until(begin + Duration::from_secs(3600), || {
            count += 1;
            true
        });
        assert_eq!((found, count), (Looked { came: true, lost: None }, 1));
        assert!(!look_until(begin, || false).came);
    }
}
