// SPDX-License-Identifier: Apache-2.0
//! A file of a participant's events: a header and records, as `lf_runtime::trace` defines them.
//!
//! The file has a limit. When it is full, it wraps around: newer records replace the oldest ones, after the records
//! that all others depend on: the number of lost records, the start, and the current correction of the clock. An
//! [`Event::Seam`] follows the newest record then.

use std::fs::File;
use std::io::{Seek as _, SeekFrom, Write as _};
use std::path::Path;

use lf_model::Outside;
use lf_model::time::{Instant, Interval};
use lf_runtime::trace::{Event, Header, RECORD_BYTES, Record, Recorder};

use crate::clock::Clock;
use crate::outside::HostOutside;

/// The number of bytes in one write: whole records, so that a killed program leaves no partial one.
const CHUNK_BYTES: usize = 2048 * RECORD_BYTES;

/// The next wait writes records that have not been written for this time.
const FLUSH_AFTER: Interval = Interval::from_millis(200);

/// The default limit of a file, in MiB: some minutes of a busy federate.
pub const TRACE_MIB: u32 = 256;

/// The distance from behind a seam back to its beginning.
const SEAM_BYTES: i64 = 32;
const _: () = assert!(SEAM_BYTES.unsigned_abs() == RECORD_BYTES as u64, "a seam is a record");

/// The limit of a file that may grow without end.
pub const TRACE_UNLIMITED: u32 = u32::MAX;

/// The number of bytes of records per MiB of the limit.
const MIB_BYTES: u64 = 1024 * 1024;

/// The file, until it cannot be written.
#[derive(Debug)]
pub(crate) struct TraceFile {
    file: Option<File>,
    /// The bytes to write next.
    buffer: Vec<u8>,
    clock: Clock,
    flushed: Instant,
    /// The maximum number of records in the file.
    capacity: u64,
    /// The number of records since the header, or since the file last wrapped around.
    count: u64,
    /// Whether a seam has to follow the newest record, because older ones are behind it.
    has_seam: bool,
    /// The number of records that were lost when the file last wrapped around.
    lost: u64,
    /// The number of records from there on that are behind the seam now.
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
            // The size of a record fits.
            capacity: u64::from(mib.max(1)) * MIB_BYTES / RECORD_BYTES as u64,
            count: 0,
            has_seam: false,
            lost: 0,
            behind: 0,
            start: None,
        })
    }

    /// Writes the header of the records that follow.
    fn begin(&mut self, header: Header) {
        self.buffer.extend(header.to_bytes());
        self.note_clock();
    }

    /// Adds a record, and leaves room for the last correction of the clock and for the seam.
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

    /// Wraps around: new records replace the oldest ones, beginning with the state that the lost ones established.
    fn go_on_at_the_beginning(&mut self, at: Instant) {
        if self.file.is_some() && self.behind == 0 {
            log::warn!("the trace is full, and its oldest records are dropped from here on; see --trace-limit");
        }
        // This replaces the seam: the whole file is in order now.
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

    /// Records the current correction of the federation's clock.
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
            // The next records replace the seam.
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
    /// Writes an event, or buffers it for a later write.
    fn record(&mut self, at: Instant, event: Event) {
        let record = Record { at, event };
        match event {
            Event::Begins(header) => return self.begin(header),
            Event::Starts(..) => self.start = Some(record),
            _ => {}
        }
        self.push(record);
        // During a wait no other work needs the time, and the wait may be long.
        if matches!(event, Event::WaitBegins(_)) && at.since(self.flushed) > FLUSH_AFTER {
            self.flushed = at;
            self.flush();
        }
    }
}

/// Flushes the file at any end of the program, except for a signal that kills it.
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

    /// Whatever the number of records, the file has all that it does not report as lost, in order from the seam on,
    /// with the start and the clock.
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
            // At least half of the file remains.
            assert!(first == 1 || count - first >= capacity - 10, "{count}: from {first}");
            let lost = in_order.iter().find_map(|it| if let Event::Lost(lost) = it.event { Some(lost) } else { None });
            let told = lost
                .map_or(0, |lost| i64::try_from(lost).expect("it fits") + i64::try_from(newer.len()).expect("it fits"));
            // The records at the beginning of a lap count, too.
            assert!((0..20).contains(&(told - (first - 1))), "{count}: {told} told, and {first} is the first");
        }
    }
}
