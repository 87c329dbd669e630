// SPDX-License-Identifier: Apache-2.0
//! A file of what a participant records of itself: a header and records, as `lf_runtime::trace` has them.
//!
//! It has a limit. When it is full, it goes on at its beginning, in the place of the oldest records, with what all
//! others have to be read with: how many records are lost, the start, and what the federation's clock shows. A
//! [`Event::Seam`] follows the newest record then.

use std::fs::File;
use std::io::{Seek as _, SeekFrom, Write as _};
use std::path::Path;

use lf_model::Outside;
use lf_model::time::{Instant, Interval};
use lf_runtime::trace::{Event, Header, RECORD_BYTES, Record, Recorder};

use crate::clock::Clock;
use crate::outside::HostOutside;

/// How many bytes are written at once: whole records, so that a program that is killed leaves no part of one.
const CHUNK_BYTES: usize = 2048 * RECORD_BYTES;

/// Records that have not been written for so long are written at the next wait.
const FLUSH_AFTER: Interval = Interval::from_millis(200);

/// The limit of a file when nothing else is said, in MiB: some minutes of a busy federate.
pub const TRACE_MIB: u32 = 256;

/// How far a file goes back from behind a seam.
const SEAM_BYTES: i64 = 32;
const _: () = assert!(SEAM_BYTES.unsigned_abs() == RECORD_BYTES as u64, "a seam is a record");

/// A file that is as long as it has to be.
pub const TRACE_UNLIMITED: u32 = u32::MAX;

/// How many bytes of records a MiB of the limit stands for.
const MIB_BYTES: u64 = 1024 * 1024;

/// The file, until it cannot be written.
#[derive(Debug)]
pub(crate) struct TraceFile {
    file: Option<File>,
    /// What is to be written next.
    buffer: Vec<u8>,
    clock: Clock,
    flushed: Instant,
    /// How many records there may be in the file.
    capacity: u64,
    /// How many records there are since the header, or since the file has gone on there.
    count: u64,
    /// Whether a seam has to follow the newest record, because older ones are behind it.
    has_seam: bool,
    /// How many records were lost when the file went on at its beginning for the last time.
    lost: u64,
    /// How many records there were from there on that are behind the seam now.
    behind: u64,
    /// The start of the federation, if it is known.
    start: Option<Record>,
}

impl TraceFile {
    /// Makes an empty file with this limit in MiB.
    ///
    /// # Errors
    /// When it cannot be made.
    pub(crate) fn create(path: &Path, mib: u32) -> std::io::Result<Self> {
        let clock = HostOutside::of_program().clock();
        Ok(Self {
            file: Some(File::create(path)?),
            buffer: Vec::with_capacity(CHUNK_BYTES + RECORD_BYTES),
            clock,
            flushed: clock.now(),
            // The number of bytes of a record fits.
            capacity: u64::from(mib.max(1)) * MIB_BYTES / RECORD_BYTES as u64,
            count: 0,
            has_seam: false,
            lost: 0,
            behind: 0,
            start: None,
        })
    }

    /// Writes down whose records follow.
    fn begin(&mut self, header: Header) {
        self.buffer.extend(header.to_bytes());
        self.note_clock();
    }

    /// Room for the last clock and for the seam is left.
    fn push(&mut self, record: Record) {
        if self.count + 2 >= self.capacity {
            self.go_on_at_the_beginning(record.at);
        }
        self.append(record);
    }

    fn append(&mut self, record: Record) {
        self.buffer.extend(record.to_bytes());
        self.count += 1;
        if self.buffer.len() >= CHUNK_BYTES {
            self.flush();
        }
    }

    /// The oldest records make way for those that follow, which begin with what is known of the lost ones.
    fn go_on_at_the_beginning(&mut self, at: Instant) {
        if self.file.is_some() && self.behind == 0 {
            log::warn!("the trace is full, and its oldest records are dropped from here on; see --trace-limit");
        }
        // This takes the place of the seam: all that is in the file is in its order now.
        self.has_seam = false;
        self.append(self.clock_record());
        self.flush();
        self.use_file(|file| file.seek(SeekFrom::Start(RECORD_BYTES as u64)).map(drop));
        self.lost += core::mem::replace(&mut self.behind, self.count);
        (self.has_seam, self.count) = (true, 0);
        self.append(Record { at, event: Event::Lost(self.lost) });
        if let Some(start) = self.start {
            self.append(Record { at, ..start });
        }
        self.append(self.clock_record());
    }

    /// What the federation's clock shows.
    fn note_clock(&mut self) {
        let record = self.clock_record();
        self.push(record);
    }

    fn clock_record(&self) -> Record {
        let at = self.clock.now();
        Record { at, event: Event::Clock(HostOutside::of_program().physical_time()) }
    }

    fn flush(&mut self) {
        if self.has_seam {
            self.buffer.extend(Record { at: self.clock.now(), event: Event::Seam }.to_bytes());
        }
        let (mut buffer, has_seam) = (core::mem::take(&mut self.buffer), self.has_seam);
        self.use_file(|file| {
            file.write_all(&buffer)?;
            // What follows takes the place of the seam.
            if has_seam { file.seek(SeekFrom::Current(-SEAM_BYTES)).map(drop) } else { Ok(()) }
        });
        buffer.clear();
        self.buffer = buffer;
    }

    fn use_file(&mut self, write: impl FnOnce(&mut File) -> std::io::Result<()>) {
        if let Some(Err(error)) = self.file.as_mut().map(write) {
            log::error!("the trace ends here, because it cannot be written: {error}");
            self.file = None;
        }
    }
}

impl Recorder for TraceFile {
    /// Writes down what has happened, or keeps it to be written with what follows.
    fn record(&mut self, at: Instant, event: Event) {
        let record = Record { at, event };
        match event {
            Event::Begins(header) => return self.begin(header),
            Event::Starts(..) => self.start = Some(record),
            _ => {}
        }
        self.push(record);
        // A wait is when nobody else needs the time, and what may last if nothing comes any more.
        if matches!(event, Event::WaitBegins(_)) && at.since(self.flushed) > FLUSH_AFTER {
            self.flushed = at;
            self.flush();
        }
    }
}

/// Whatever ends the program, apart from a signal that kills it.
impl Drop for TraceFile {
    fn drop(&mut self) {
        self.note_clock();
        self.flush();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn records_of(mib: u32, count: i64) -> Vec<Record> {
        let folder = tempfile::tempdir().expect("there is room");
        let path = folder.path().join("x.lftrace");
        let mut file = TraceFile::create(&path, mib).expect("it can be made");
        file.begin(Header { role: lf_runtime::trace::Role::Rti, sizes: [0; 3] });
        file.record(Instant::from_nanos(0), Event::Starts(Instant::from_nanos(7), false));
        (1..=count).for_each(|at| file.record(Instant::from_nanos(at), Event::WaitEnds));
        drop(file);
        let bytes = std::fs::read(&path).expect("it is there");
        assert!(bytes.len() as u64 <= u64::from(mib) * MIB_BYTES + RECORD_BYTES as u64, "{}", bytes.len());
        let (blocks, rest) = bytes.as_chunks::<RECORD_BYTES>();
        assert!(rest.is_empty());
        blocks.iter().skip(1).map(|block| Record::from_bytes(block).expect("it is a record")).collect()
    }

    /// However many there are: all that is not said to be lost is there, in its order from the seam on, with the start
    /// and the clock.
    #[test]
    fn a_full_file_keeps_the_newest_records_and_says_how_many_are_lost() {
        let capacity = i64::try_from(MIB_BYTES / RECORD_BYTES as u64).expect("it fits");
        for count in [1, capacity - 5, capacity, capacity + 3000, 2 * capacity - 7, 3 * capacity + 17] {
            let records = records_of(1, count);
            let seams: Vec<_> = (0..records.len()).filter(|at| records[*at].event == Event::Seam).collect();
            assert!(seams.len() <= 1, "{count}: {seams:?}");
            let (newer, older) = records.split_at(seams.first().map_or(0, |seam| seam + 1));
            let in_order: Vec<_> = older.iter().chain(newer).collect();
            let kept: Vec<_> =
                in_order.iter().filter(|it| it.event == Event::WaitEnds).map(|it| it.at.as_nanos()).collect();
            let first = kept[0];
            assert_eq!(kept, (first..=count).collect::<Vec<_>>(), "{count}");
            assert!(in_order.iter().any(|it| matches!(it.event, Event::Starts(..))), "{count}");
            assert!(in_order.iter().any(|it| matches!(it.event, Event::Clock(_))), "{count}");
            assert_eq!(first > 1, seams.len() == 1, "{count}");
            // Half of the file at least is there.
            assert!(first == 1 || count - first >= capacity - 10, "{count}: from {first}");
            let lost = in_order.iter().find_map(|it| if let Event::Lost(lost) = it.event { Some(lost) } else { None });
            let told = lost
                .map_or(0, |lost| i64::try_from(lost).expect("it fits") + i64::try_from(newer.len()).expect("it fits"));
            // What begins a lap counts, too.
            assert!((0..20).contains(&(told - (first - 1))), "{count}: {told} told, and {first} is the first");
        }
    }
}
