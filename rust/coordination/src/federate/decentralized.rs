// SPDX-License-Identifier: Apache-2.0
//! Decentralized coordination: how long a federate waits for its inputs.
//!
//! The RTI grants no tags. Messages of one federate come in order, so a message or an absence makes an input known up
//! to its tag. A tag begins when all inputs are known up to just before it, or when the wait for the others
//! (`@maxwait`) is over. Within the tag, reactions from the level of an input on wait until it is known at that tag
//! too, or until a second wait (`@absent_after`) is over: then the federate takes it as absent. A message that comes
//! later is tardy.
//!
//! The event loop handles messages that are incomplete or whose queue has no room. It also reads everything that has
//! come before it lets a time pass.

use lf_model::time::{Instant, Interval, Tag};

use super::awaited::Awaited;

/// The point at which reactions of the open tag have to wait.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Pause {
    /// Reactions below this level may run.
    pub level: u16,
    /// The physical time at which the first input counts as absent, by [`Awaited::assume_absent`]; FOREVER if only a
    /// message or an absence helps.
    pub until: Instant,
}

impl Awaited<'_> {
    /// Starts the federation at `start`. No input has a message before that and its connection's delay, which `delay`
    /// returns for a port.
    pub fn start(&mut self, start: Tag, delay: impl Fn(u16) -> Option<Interval>) {
        for (input, known) in self.inputs() {
            *known = (*known).max(start.delayed(delay(input.port)).before());
        }
    }

    /// Returns whether all inputs are known before this tag.
    pub fn knows_before(&self, tag: Tag) -> bool {
        self.known().all(|(_, known)| known >= tag.before())
    }

    /// Returns the physical time from which on a tag may begin: `since`, and later by the longest wait of the inputs
    /// that are not known before it. FOREVER if only a message or an absence helps.
    ///
    /// Waits count from `since`: the tag's time, or later if the federate could not begin the tag at its time.
    pub fn begin_time(&self, tag: Tag, since: Instant, max_wait: impl Fn(u16) -> Interval) -> Instant {
        let unknown = self.known().filter(|(_, known)| *known < tag.before());
        let wait = unknown.map(|(input, _)| max_wait(input.port)).max().unwrap_or(Interval::ZERO);
        wait_until(since, wait.max(Interval::ZERO))
    }

    /// Returns the point at which reactions of the open tag have to wait; `None` if all inputs are known. `wait_limit`
    /// returns how long to wait for a port within the tag.
    pub fn pause(&self, current: Tag, since: Instant, wait_limit: impl Fn(u16) -> Interval) -> Option<Pause> {
        let unknown = || self.known().filter(|(_, known)| *known < current).map(|(input, _)| input);
        let level = unknown().map(|input| input.level).min()?;
        let until = unknown().map(|input| wait_until(since, wait_limit(input.port))).min()?;
        Some(Pause { level, until })
    }

    /// Takes unknown inputs of the open tag as absent if their wait is over at `now` by the federation's clock.
    pub fn assume_absent(&mut self, current: Tag, since: Instant, now: Instant, wait_limit: impl Fn(u16) -> Interval) {
        for (input, known) in self.inputs() {
            if *known < current && wait_until(since, wait_limit(input.port)) <= now {
                *known = current;
            }
        }
    }
}

/// Adds a wait to a time. A wait of FOREVER does not end, not even at the end of time.
fn wait_until(time: Instant, wait: Interval) -> Instant {
    if wait == Interval::FOREVER { Instant::FOREVER } else { time + wait }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::super::AwaitedInput;
    use super::*;

    const START: Instant = Instant::from_nanos(1_000);

    /// An input as a table row: level, delay, maximum wait, absence after.
    type Row = (u16, Option<i64>, i64, i64);

    fn rows() -> impl Strategy<Value = Vec<Row>> {
        let wait = || prop_oneof![4 => 0..50i64, 1 => Just(i64::MAX)];
        prop::collection::vec((0..5u16, prop::option::of(0..20i64), wait(), 0..30i64), 0..5)
    }

    fn inputs(rows: &[Row]) -> Vec<AwaitedInput> {
        (0..).zip(rows).map(|(port, row)| AwaitedInput { port, level: row.0 }).collect()
    }

    fn tag(time: i64, microstep: u32) -> Tag {
        Tag::new(START + Interval::from_nanos(time), lf_model::time::Microstep(microstep))
    }

    #[test]
    fn the_start_begins_at_its_time_and_then_waits_for_inputs_without_delay() {
        let rows = [(3, None, i64::MAX, 0), (1, Some(10), 5, 0)];
        let (inputs, mut known) = (inputs(&rows), [Tag::NEVER; 2]);
        let mut awaited = Awaited::new(&inputs, &mut known).expect("there is memory");
        awaited.start(tag(0, 0), |port| rows[usize::from(port)].1.map(Interval::from_nanos));
        let (max_wait, wait_limit) = (
            |port| Interval::from_nanos(rows[usize::from(port)].2),
            |port| {
                Interval::from_nanos(rows[usize::from(port)].2)
                    .saturating_add(Interval::from_nanos(rows[usize::from(port)].3))
            },
        );
        assert_eq!(awaited.begin_time(tag(0, 0), tag(0, 0).time, max_wait), START);
        assert_eq!(
            awaited.pause(tag(0, 0), tag(0, 0).time, wait_limit),
            Some(Pause { level: 3, until: Instant::FOREVER })
        );
        awaited.learn(0, tag(0, 0));
        assert_eq!(awaited.pause(tag(0, 0), tag(0, 0).time, wait_limit), None);
        // The next microstep needs a message or an absence again; the other input is known for as long as its delay.
        assert_eq!(awaited.begin_time(tag(0, 1), tag(0, 1).time, max_wait), START);
        assert_eq!(awaited.pause(tag(0, 1), tag(0, 1).time, wait_limit).map(|pause| pause.level), Some(3));
        assert_eq!(awaited.begin_time(tag(2, 0), tag(2, 0).time, max_wait), Instant::FOREVER);
        assert!(awaited.knows_before(tag(0, 1)) && !awaited.knows_before(tag(2, 0)));
        awaited.learn(0, Tag::FOREVER);
        assert_eq!(awaited.begin_time(tag(10, 0), tag(10, 0).time, max_wait), START + Interval::from_nanos(10));
        assert_eq!(awaited.begin_time(tag(11, 0), tag(11, 0).time, max_wait), START + Interval::from_nanos(16));
    }

    proptest! {
        /// A tag never begins before its time, nor later than the longest wait after it. It begins at its time exactly
        /// if all inputs are known up to just before it, or the unknown ones have no wait.
        #[test]
        fn tags_begin_when_they_should(
            rows in rows(),
            words in prop::collection::vec((0..5u16, 0..60i64, 0..3u32), 0..12),
            at in 0..60i64,
            step in 0..3u32,
        ) {
            let (inputs, mut known) = (inputs(&rows), [Tag::NEVER; 5]);
            let mut awaited = Awaited::new(&inputs, &mut known).expect("there is memory");
            awaited.start(tag(0, 0), |port| rows[usize::from(port)].1.map(Interval::from_nanos));
            for (port, time, microstep) in &words {
                awaited.learn(*port, tag(*time, *microstep));
            }
            let at = tag(at, step);
            let begin = awaited.begin_time(at, at.time, |port| Interval::from_nanos(rows[usize::from(port)].2));
            let mut expected = at.time;
            for (port, row) in (0..).zip(&rows) {
                let first = tag(0, 0).delayed(row.1.map(Interval::from_nanos));
                let told = words.iter().filter(|word| word.0 == port).map(|word| tag(word.1, word.2));
                let is_known = at <= first || told.max().is_some_and(|told| told.next_microstep() >= at);
                if !is_known {
                    expected = expected.max(at.time.saturating_add(Interval::from_nanos(row.2)));
                }
            }
            prop_assert_eq!(begin, expected);
            prop_assert!(begin > at.time || awaited.knows_before(at) || rows.iter().any(|row| row.2 == 0));
        }

        /// Time alone lets every tag go on whose waits are finite, level by level, and an input that counts as absent
        /// is known for the next tag.
        #[test]
        fn time_lets_a_tag_go_on(rows in rows(), at in 0..60i64) {
            let (inputs, mut known) = (inputs(&rows), [Tag::NEVER; 5]);
            let mut awaited = Awaited::new(&inputs, &mut known).expect("there is memory");
            awaited.start(tag(0, 0), |port| rows[usize::from(port)].1.map(Interval::from_nanos));
            let wait_limit = |port| {
                let row = rows[usize::from(port)];
                Interval::from_nanos(row.2).saturating_add(Interval::from_nanos(row.3))
            };
            let current = tag(at, 0);
            let mut levels = Vec::new();
            while let Some(pause) = awaited.pause(current, current.time, wait_limit) {
                levels.push(pause.level);
                if pause.until == Instant::FOREVER {
                    prop_assert!(rows.iter().any(|row| row.2 == i64::MAX));
                    return Ok(());
                }
                awaited.assume_absent(current, current.time, pause.until - Interval::from_nanos(1), wait_limit);
                prop_assert_eq!(awaited.pause(current, current.time, wait_limit), Some(pause));
                awaited.assume_absent(current, current.time, pause.until, wait_limit);
            }
            prop_assert!(levels.is_sorted() && levels.len() <= rows.len());
            prop_assert!(awaited.knows_before(current.next_microstep()));
        }
    }
}
