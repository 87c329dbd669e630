// SPDX-License-Identifier: Apache-2.0
//! The newest records, for systems without files.

use lf_model::time::Instant;

use super::event::Event;
use super::header::RECORD_BYTES;
use super::record::Record;

/// A ring of the newest `N` records, and of those that all others depend on.
#[derive(Debug)]
pub struct Ring<const N: usize> {
    /// The records; zeros are none.
    records: [[u8; RECORD_BYTES]; N],
    /// The number of records so far.
    count: u64,
    /// The record of the program's start, which no ring is long enough for.
    start: Option<Record>,
}

impl<const N: usize> Ring<N> {
    /// Returns an empty ring. It takes no flash.
    #[expect(clippy::new_without_default, reason = "it is for statics, which cannot use Default")]
    pub const fn new() -> Self {
        Self { records: [[0; RECORD_BYTES]; N], count: 0, start: None }
    }

    /// Adds a record, which replaces the oldest one if the ring is full.
    pub fn push(&mut self, at: Instant, event: Event) {
        let record = Record { at, event };
        if let Event::Starts(..) = event {
            self.start = Some(record);
            return;
        }
        // The remainder is less than the length, which fits.
        if let Some(place) = usize::try_from(self.count % N.max(1) as u64).ok().and_then(|at| self.records.get_mut(at))
        {
            *place = record.to_bytes();
        }
        self.count += 1;
    }

    /// Returns the kept records, oldest first: the number of lost ones, the start, and the others.
    pub fn records(&self) -> impl Iterator<Item = Record> {
        let lost = self.count.saturating_sub(N as u64);
        let oldest = usize::try_from(self.count % N.max(1) as u64).unwrap_or(0);
        let (newer, older) = self.records.split_at(if lost > 0 { oldest.min(N) } else { 0 });
        let kept = older.iter().chain(newer).filter_map(|bytes| Record::from_bytes(bytes).ok());
        let first = kept.clone().next().map_or(Instant::NEVER, |record| record.at);
        let lost = (lost > 0).then_some(Record { at: first, event: Event::Lost(lost) });
        lost.into_iter().chain(self.start).chain(kept)
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    #[test]
    fn the_newest_are_kept_with_the_start_and_the_number_of_the_others() {
        let mut ring = Ring::<3>::new();
        ring.push(Instant::from_nanos(1), Event::Starts(Instant::from_nanos(5), false));
        let events =
            |ring: &Ring<3>| ring.records().map(|record| (record.at.as_nanos(), record.event)).collect::<Vec<_>>();
        let start = (1, Event::Starts(Instant::from_nanos(5), false));
        assert_eq!(events(&ring), [start]);
        (2..=4).for_each(|at| ring.push(Instant::from_nanos(at), Event::WaitEnds));
        assert_eq!(events(&ring), [start, (2, Event::WaitEnds), (3, Event::WaitEnds), (4, Event::WaitEnds)]);
        (5..=6).for_each(|at| ring.push(Instant::from_nanos(at), Event::WaitEnds));
        let (lost, kept) = ((4, Event::Lost(2)), [4, 5, 6].map(|at| (at, Event::WaitEnds)));
        assert_eq!(events(&ring), [&[lost, start], &kept[..]].concat());
    }
}
