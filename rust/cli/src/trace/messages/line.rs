// SPDX-License-Identifier: Apache-2.0
//! One message of a table, and the formats of tables.

use std::io::{self, Write};

use lf_linux::model::time::{Instant, Tag};
use lf_linux::runtime::trace::{Event, MessageType, RTI, TracedMessage};

/// The direction of a message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Direction {
    Received,
    Sent,
}

/// One message.
pub(super) struct MessageLine {
    /// The time of the RTI's clock.
    pub(super) now: Instant,
    pub(super) direction: Direction,
    /// The federate at the other end, if it has sent its id.
    pub(super) federate: Option<u16>,
    pub(super) kind: MessageType,
    /// The message's tag; for a TIMESTAMP, its time.
    pub(super) tag: Option<Tag>,
    /// The federate for which it is.
    pub(super) to: Option<u16>,
    /// The length on the wire.
    pub(super) bytes: u32,
}

impl MessageLine {
    /// Returns the line of a message; `None` for other events.
    pub(super) fn of(at: i64, event: Event) -> Option<Self> {
        let (direction, message) = match event {
            Event::Received(message) => (Direction::Received, message),
            Event::Sent(message) => (Direction::Sent, message),
            _ => return None,
        };
        let TracedMessage { kind, peer, to: (to, _), tag, bytes } = message;
        let has_receiver = message.is_value() || kind == MessageType::PortAbsent;
        Some(Self {
            now: Instant::from_nanos(at),
            direction,
            federate: Some(peer).filter(|peer| *peer != RTI),
            kind,
            tag,
            to: Some(to).filter(|_| has_receiver),
            bytes,
        })
    }
}

/// A format of messages. Times in lines are absolute; `start` is that of the federation.
pub(super) trait Format {
    fn begin(&mut self, file: &mut dyn Write, start: i64) -> io::Result<()>;
    fn line(&mut self, file: &mut dyn Write, line: &MessageLine, start: i64) -> io::Result<()>;
    fn end(&mut self, file: &mut dyn Write) -> io::Result<()>;
}
