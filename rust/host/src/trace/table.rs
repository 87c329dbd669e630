// SPDX-License-Identifier: Apache-2.0
//! The file of a trace: comma-separated values, one message a line.
//!
//! | column | content |
//! |---|---|
//! | `physical_ns` | the RTI's clock in nanoseconds after the start of the federation; negative before it |
//! | `direction` | `received` or `sent`, by the RTI |
//! | `federate` | the federate at the other end; empty while it has not said who it is |
//! | `message` | the name of the message in the protocol |
//! | `tag_ns`, `microstep` | the message's tag, if it has one: nanoseconds after the start, or `NEVER`, `FOREVER` |
//! | `to` | the federate for which a message is |
//! | `bytes` | its length on the wire |
//!
//! If the federation never starts, the first line has the time zero.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use lf_model::time::Instant;
use lf_wire::Tag;
use lf_wire::june_2026::Message;

const COLUMNS: &str = "physical_ns,direction,federate,message,tag_ns,microstep,to,bytes";

/// Which way a message goes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Direction {
    Received,
    Sent,
}

/// One line, before its times can be given.
struct Line {
    now: Instant,
    direction: Direction,
    federate: Option<u16>,
    name: &'static str,
    tag: Option<Tag>,
    to: Option<u16>,
    bytes: usize,
}

/// The file.
pub(super) struct Table {
    file: BufWriter<File>,
    start: Option<i64>,
    /// What came before the start was known: the messages of the handshakes.
    early: Vec<Line>,
    broken: bool,
}

impl Table {
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        let mut file = BufWriter::new(File::create(path)?);
        writeln!(file, "{COLUMNS}")?;
        Ok(Self { file, start: None, early: Vec::new(), broken: false })
    }

    pub(super) fn add(&mut self, now: Instant, direction: Direction, federate: Option<u16>, message: &Message<'_>) {
        let line = Line {
            now,
            direction,
            federate,
            name: message.name(),
            tag: tag_of(message),
            to: destination(message),
            bytes: message.encoded_len(),
        };
        if let (Direction::Sent, Message::Timestamp(start), None) = (direction, message, self.start) {
            self.set_start(*start);
        }
        match self.start {
            Some(start) => self.write(&line, start),
            None => self.early.push(line),
        }
    }

    fn set_start(&mut self, start: i64) {
        self.start = Some(start);
        for line in std::mem::take(&mut self.early) {
            self.write(&line, start);
        }
    }

    fn write(&mut self, line: &Line, start: i64) {
        if self.broken {
            return;
        }
        if let Err(error) = write_line(&mut self.file, line, start) {
            log::error!("the trace ends here, because it cannot be written: {error}");
            self.broken = true;
        }
    }
}

impl Drop for Table {
    fn drop(&mut self) {
        if let Some(first) = self.early.first() {
            self.set_start(first.now.as_nanos());
        }
        if let Err(error) = self.file.flush()
            && !self.broken
        {
            log::error!("the end of the trace cannot be written: {error}");
        }
    }
}

fn write_line(file: &mut impl Write, line: &Line, start: i64) -> io::Result<()> {
    let direction = match line.direction {
        Direction::Received => "received",
        Direction::Sent => "sent",
    };
    let number = |number: Option<u16>| number.map_or_else(String::new, |number| number.to_string());
    let (tag, microstep) = match line.tag {
        None => (String::new(), String::new()),
        Some(Tag::NEVER) => ("NEVER".to_owned(), String::new()),
        Some(Tag::FOREVER) => ("FOREVER".to_owned(), String::new()),
        Some(Tag { time, microstep }) => (time.saturating_sub(start).to_string(), microstep.to_string()),
    };
    let physical = line.now.as_nanos().saturating_sub(start);
    let (federate, to, Line { name, bytes, .. }) = (number(line.federate), number(line.to), line);
    writeln!(file, "{physical},{direction},{federate},{name},{tag},{microstep},{to},{bytes}")
}

fn tag_of(message: &Message<'_>) -> Option<Tag> {
    match *message {
        Message::TaggedMessage { tag, .. }
        | Message::PortAbsent { tag, .. }
        | Message::NextEventTag(tag)
        | Message::TagGrant(tag)
        | Message::ProvisionalTagGrant(tag)
        | Message::LatestTagComplete(tag)
        | Message::DownstreamNextEventTag(tag)
        | Message::StopRequest(tag)
        | Message::StopReply(tag)
        | Message::StopGranted(tag) => Some(tag),
        _ => None,
    }
}

fn destination(message: &Message<'_>) -> Option<u16> {
    match *message {
        Message::TaggedMessage { federate, .. } | Message::PortAbsent { federate, .. } => Some(federate),
        _ => None,
    }
}
