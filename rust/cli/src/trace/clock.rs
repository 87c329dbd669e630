// SPDX-License-Identifier: Apache-2.0
//! Converts times of a participant's clock to times of the federation.

use lf_linux::runtime::trace::{Event, Record};

/// Corrections that change faster than one part in this number are steps: slewing is always slower.
const STEP: i64 = 10;

/// The maximum number of stored corrections, in 1 MiB. Of more, every second one is dropped: between its neighbors a
/// clock drifts evenly, so the error is small.
const POINTS_MAX: usize = 64 * 1024;

/// The corrections of a participant's clock, with their times.
#[derive(Debug, Default)]
pub(crate) struct Clock {
    /// Times of the participant's clock and their corrections, in order.
    points: Vec<(i64, i64)>,
}

impl Clock {
    /// Handles the next record, which may be a correction. The correction before the last step was not known yet, so
    /// the one after the step counts for it too.
    pub(crate) fn take(&mut self, record: &Record) {
        let Event::Clock(time) = record.event else { return };
        let (at, offset) = (record.at.as_nanos(), time.as_nanos().saturating_sub(record.at.as_nanos()));
        let is_step = |&(last, before): &(i64, i64)| (offset - before).abs() > (at - last).max(1_000_000) / STEP;
        if self.points.last().is_some_and(is_step) {
            self.points.clear();
        }
        if self.points.len() == POINTS_MAX {
            let mut index = 0;
            self.points.retain(|_| {
                index += 1;
                index % 2 == 1
            });
        }
        self.points.push((at, offset));
    }

    /// Returns the federation's time at a time of the participant's clock.
    pub(crate) fn time(&self, at: i64) -> i64 {
        let next = self.points.partition_point(|(point, _)| *point <= at);
        let before = next.checked_sub(1).and_then(|index| self.points.get(index));
        let offset = match (before, self.points.get(next)) {
            (Some((begin, from)), Some((end, to))) => {
                let part = i128::from(to - from) * i128::from(at - begin) / i128::from((end - begin).max(1));
                from + i64::try_from(part).unwrap_or(0)
            }
            (Some((_, offset)), None) | (None, Some((_, offset))) => *offset,
            (None, None) => 0,
        };
        at.saturating_add(offset)
    }
}

#[cfg(test)]
mod tests {
    use lf_linux::model::time::Instant;

    use super::*;

    #[test]
    fn a_step_counts_from_the_beginning_and_what_follows_in_between() {
        let record = |at, time| Record { at: Instant::from_nanos(at), event: Event::Clock(Instant::from_nanos(time)) };
        let second = 1_000_000_000;
        let mut clock = Clock::default();
        for record in [record(0, 0), record(100, 5 * second + 100), record(second, 6 * second + 1_000)] {
            clock.take(&record);
        }
        assert_eq!(clock.time(0), 5 * second);
        assert_eq!(clock.time(second), 6 * second + 1_000);
        assert_eq!(clock.time(second / 2), 5 * second + second / 2 + 499);
        assert_eq!(clock.time(2 * second), 7 * second + 1_000);
        assert_eq!(Clock::default().time(7), 7);
    }

    /// A long recording has any number of corrections, and its memory has a limit.
    #[test]
    fn corrections_without_end_take_limited_memory_and_keep_their_course() {
        let mut clock = Clock::default();
        let drift = |at: i64| at + at / 10_000;
        let count = 5 * i64::try_from(POINTS_MAX).expect("it is small");
        for at in (0..count).map(|number| number * 1_000_000) {
            clock.take(&Record { at: Instant::from_nanos(at), event: Event::Clock(Instant::from_nanos(drift(at))) });
            assert!(clock.points.len() <= POINTS_MAX);
        }
        for at in [0, 1_000_500, count * 500_000, (count - 1) * 1_000_000] {
            assert!((clock.time(at) - drift(at)).abs() <= 1, "{at}");
        }
    }
}
