// SPDX-License-Identifier: Apache-2.0
//! The messages of a trace, one line each, and the files that they are written into.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use lf_model::time::Instant;
use lf_wire::{Message, MessageType, Tag};

/// Which way a message goes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Direction {
    Received,
    Sent,
}

/// One message.
pub(super) struct TraceLine {
    /// The RTI's clock.
    pub(super) now: Instant,
    pub(super) direction: Direction,
    /// The federate at the other end, when it has said who it is.
    pub(super) federate: Option<u16>,
    pub(super) kind: MessageType,
    /// The message's tag; for a TIMESTAMP, its time.
    pub(super) tag: Option<Tag>,
    /// For whom it is.
    pub(super) to: Option<u16>,
    /// On the wire.
    pub(super) bytes: usize,
}

/// How a trace is written down. Times in lines are absolute; `start` is that of the federation.
pub(super) trait Format {
    fn begin(&mut self, file: &mut dyn Write, start: i64) -> io::Result<()>;
    fn line(&mut self, file: &mut dyn Write, line: &TraceLine, start: i64) -> io::Result<()>;
    fn end(&mut self, file: &mut dyn Write) -> io::Result<()>;
}

/// All messages, in the files.
#[derive(Default)]
pub(super) struct Table {
    files: Vec<TableFile>,
    start: Option<i64>,
    /// What came before the start was known: the messages of the handshakes.
    early: Vec<TraceLine>,
}

struct TableFile {
    file: BufWriter<File>,
    format: Box<dyn Format>,
    broken: bool,
}

impl Table {
    pub(super) fn add_file(&mut self, path: &Path, format: Box<dyn Format>) -> io::Result<()> {
        let file = BufWriter::new(File::create(path)?);
        self.files.push(TableFile { file, format, broken: false });
        Ok(())
    }

    pub(super) fn add(&mut self, now: Instant, direction: Direction, federate: Option<u16>, message: &Message<'_>) {
        let line = TraceLine {
            now,
            direction,
            federate,
            kind: message.message_type(),
            tag: tag_of(message),
            to: destination(message),
            bytes: message.encoded_len(),
        };
        if let (Direction::Sent, Message::Timestamp(start), None) = (direction, message, self.start) {
            self.set_start(*start);
        }
        match self.start {
            Some(start) => self.write(|file| file.format.line(&mut file.file, &line, start)),
            None => self.early.push(line),
        }
    }

    fn set_start(&mut self, start: i64) {
        self.start = Some(start);
        self.write(|file| file.format.begin(&mut file.file, start));
        for line in std::mem::take(&mut self.early) {
            self.write(|file| file.format.line(&mut file.file, &line, start));
        }
    }

    fn write(&mut self, write: impl Fn(&mut TableFile) -> io::Result<()>) {
        for file in self.files.iter_mut().filter(|file| !file.broken) {
            if let Err(error) = write(file) {
                log::error!("a trace ends here, because it cannot be written: {error}");
                file.broken = true;
            }
        }
    }
}

impl Drop for Table {
    fn drop(&mut self) {
        if self.start.is_none() {
            self.set_start(self.early.first().map_or(0, |first| first.now.as_nanos()));
        }
        self.write(|file| file.format.end(&mut file.file).and_then(|()| file.file.flush()));
    }
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
        Message::Timestamp(time) => Some(Tag::new(time, 0)),
        _ => None,
    }
}

fn destination(message: &Message<'_>) -> Option<u16> {
    match *message {
        Message::TaggedMessage { federate, .. } | Message::PortAbsent { federate, .. } => Some(federate),
        _ => None,
    }
}
