// SPDX-License-Identifier: Apache-2.0
//! Writes the messages that an RTI has recorded, in LF's own format or as text.

mod csv;
mod lft;
mod line;

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

use lf_linux::runtime::trace::MessageType;

use super::read::Recorded;
use crate::failure::Failure;
use csv::Csv;
use lft::Lft;
use line::{Direction, Format, MessageLine};

/// A file to write messages into.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Table {
    /// The path; an existing file is replaced.
    pub(crate) file: PathBuf,
    /// The format.
    pub(crate) format: TableFormat,
}

/// The format of a file of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TableFormat {
    /// The binary format that LF's own tools read; `lft.rs` describes it.
    Lft,
    /// Comma-separated values; `csv.rs` describes them.
    Csv,
}

impl Table {
    /// Writes the messages of an RTI.
    ///
    /// # Errors
    /// When what was recorded cannot be read, or the file cannot be written.
    pub(crate) fn write(&self, rti: &Recorded) -> Result<(), Failure> {
        let wrong = |error: io::Error| Failure::message(format!("cannot write {}: {error}", self.file.display()));
        let mut file = BufWriter::new(File::create(&self.file).map_err(wrong)?);
        let mut format: Box<dyn Format> = match self.format {
            TableFormat::Lft => Box::new(Lft::default()),
            TableFormat::Csv => Box::new(Csv),
        };
        let mut lines = TableLines { file: &mut file, format: &mut *format, start: None, early: Vec::new() };
        let mut written = Ok(());
        rti.in_order(
            |record| record.at.as_nanos(),
            |at, event| {
                if let Some(line) = MessageLine::of(at, event).filter(|_| written.is_ok()) {
                    written = lines.add(line);
                }
            },
        )?;
        written.and_then(|()| lines.end()).and_then(|()| file.flush()).map_err(wrong)
    }
}

/// The lines of a file, with times relative to the start.
struct TableLines<'a> {
    file: &'a mut dyn Write,
    format: &'a mut dyn Format,
    start: Option<i64>,
    /// The messages before the start time is known: those of the handshakes.
    early: Vec<MessageLine>,
}

impl TableLines<'_> {
    fn add(&mut self, line: MessageLine) -> io::Result<()> {
        if let (Direction::Sent, MessageType::Timestamp, Some(tag), None) =
            (line.direction, line.kind, line.tag, self.start)
        {
            self.begin(tag.time.as_nanos())?;
        }
        if let Some(start) = self.start {
            return self.format.line(self.file, &line, start);
        }
        self.early.push(line);
        Ok(())
    }

    fn begin(&mut self, start: i64) -> io::Result<()> {
        self.start = Some(start);
        self.format.begin(self.file, start)?;
        std::mem::take(&mut self.early).iter().try_for_each(|line| self.format.line(self.file, line, start))
    }

    fn end(mut self) -> io::Result<()> {
        if self.start.is_none() {
            self.begin(self.early.first().map_or(0, |first| first.now.as_nanos()))?;
        }
        self.format.end(self.file)
    }
}
