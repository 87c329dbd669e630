// SPDX-License-Identifier: Apache-2.0
//! A file of what a participant records of itself: a header and records, as `lf_runtime::trace` has them.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use lf_model::Outside;
use lf_model::time::{Instant, Interval};
use lf_runtime::trace::{Event, Header, RECORD_BYTES, Record};

use crate::clock::Clock;
use crate::outside::HostOutside;

/// How many bytes are written at once: whole records, so that a program that is killed leaves no part of one.
const CHUNK_BYTES: usize = 2048 * RECORD_BYTES;

/// Records that have not been written for so long are written at the next wait.
const FLUSH_AFTER: Interval = Interval::from_millis(200);

/// The file, until it cannot be written.
#[derive(Debug)]
pub(crate) struct TraceFile {
    file: Option<BufWriter<File>>,
    clock: Clock,
    flushed: Instant,
}

impl TraceFile {
    /// Makes a file, in which nothing is yet.
    ///
    /// # Errors
    /// When it cannot be made.
    pub(crate) fn create(path: &Path) -> std::io::Result<Self> {
        let clock = HostOutside::of_program().clock();
        let file = BufWriter::with_capacity(CHUNK_BYTES, File::create(path)?);
        Ok(Self { file: Some(file), clock, flushed: clock.now() })
    }

    /// Writes down whose records follow.
    pub(crate) fn begin(&mut self, header: Header) {
        self.use_file(|file| file.write_all(&header.to_bytes()));
        self.note_clock();
    }

    /// Writes down what has happened at this time, or keeps it to be written with what follows.
    pub(crate) fn note(&mut self, at: Instant, event: Event) {
        self.write(Record { at, event });
        // A wait is when nobody else needs the time, and what may last if nothing comes any more.
        if matches!(event, Event::WaitBegins(_)) && at.since(self.flushed) > FLUSH_AFTER {
            self.flushed = at;
            self.use_file(Write::flush);
        }
    }

    fn write(&mut self, record: Record) {
        self.use_file(|file| file.write_all(&record.to_bytes()));
    }

    /// What the federation's clock shows.
    fn note_clock(&mut self) {
        let at = self.clock.now();
        let event = Event::Clock(HostOutside::of_program().physical_time());
        self.write(Record { at, event });
    }

    fn use_file(&mut self, write: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>) {
        if let Some(Err(error)) = self.file.as_mut().map(write) {
            log::error!("the trace ends here, because it cannot be written: {error}");
            self.file = None;
        }
    }
}

/// Whatever ends the program, apart from a signal that kills it.
impl Drop for TraceFile {
    fn drop(&mut self) {
        self.note_clock();
        self.use_file(Write::flush);
    }
}
