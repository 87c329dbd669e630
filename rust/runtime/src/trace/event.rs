// SPDX-License-Identifier: Apache-2.0
//! The recorded events of a participant.

use lf_coordination::from_wire;
use lf_model::time::{Instant, Tag};
use lf_model::{Part, TriggerId};
use lf_wire::{Message, MessageType};

use super::header::Header;

/// The value for the RTI in the place of a federate's id.
pub const RTI: u16 = u16::MAX;

/// An event of a participant.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Event {
    /// The recording of this participant begins. It comes before all others.
    Begins(Header),
    /// The participant's clock shows this physical time of the federation at the time of this record, and from here on.
    Clock(Instant),
    /// The time of the first tag; whether the program does not wait for the time of its tags.
    Starts(Instant, bool),
    /// With decentralized coordination: the next tag could begin at this time, as far as that depends on clocks.
    Due(Instant),
    /// A tag begins.
    TagBegins(Tag),
    /// A tag is complete.
    TagEnds(Tag),
    /// The input from outside at the tag that has just begun: a physical action, or a physical connection within the
    /// federate, by its number in the program's tables. Recorded with values only; the value follows, if it has one.
    Physical(TriggerId),
    /// A reaction begins, by its number in the program's tables, in the event loop or in a worker, which counts from 1.
    ReactionBegins(u16, Part, u16),
    /// The same reaction ends.
    ReactionEnds(u16, u16),
    /// A message goes into the send buffer.
    Sent(TracedMessage),
    /// A message has arrived, and waits for room in the queue of its input. It may be recorded more than once.
    Held(TracedMessage),
    /// A message has arrived and is handled. With values, its value follows.
    Received(TracedMessage),
    /// A part of the value of the previous event.
    Data(Chunk),
    /// The event loop begins to wait.
    WaitBegins(Waits),
    /// The event loop continues.
    WaitEnds,
    /// The participant ends; whether by an error.
    Ends(bool),
    /// This number of records was lost here, because there was no room for more.
    Lost(u64),
    /// The seam in a file that wraps around: the newest record is before it, the oldest behind.
    Seam,
}

/// The recorded part of a message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct TracedMessage {
    /// Its type.
    pub kind: MessageType,
    /// The federate at the other end of the connection, or [`RTI`]. In records of an RTI, [`RTI`] is a federate that
    /// has not sent its id.
    pub peer: u16,
    /// The federate that receives a value, and the number of its input; zeros in other messages.
    pub to: (u16, u16),
    /// Its tag, if it has one; of a TIMESTAMP, its time.
    pub tag: Option<Tag>,
    /// Bytes on the wire; of a value that is being sent, its own length.
    pub bytes: u32,
}

impl TracedMessage {
    /// Returns the recorded part of a message.
    pub fn of(message: &Message<'_>, peer: u16) -> Self {
        let (tag, to) = match *message {
            Message::TaggedMessage { port, federate, tag, .. }
            | Message::P2pTaggedMessage { port, federate, tag, .. }
            | Message::PortAbsent { port, federate, tag } => (Some(tag), (federate, port)),
            Message::P2pMessage { port, federate, .. } => (None, (federate, port)),
            Message::NextEventTag(tag)
            | Message::LatestTagComplete(tag)
            | Message::TagGrant(tag)
            | Message::ProvisionalTagGrant(tag)
            | Message::DownstreamNextEventTag(tag)
            | Message::StopRequest(tag)
            | Message::StopReply(tag)
            | Message::StopGranted(tag) => (Some(tag), (0, 0)),
            Message::Timestamp(time) => (Some(lf_wire::Tag::new(time, 0)), (0, 0)),
            _ => (None, (0, 0)),
        };
        let bytes = u32::try_from(message.encoded_len()).unwrap_or(u32::MAX);
        Self { kind: message.message_type(), peer, to, tag: tag.map(from_wire), bytes }
    }

    /// Returns whether it is a value for an input.
    pub const fn is_value(&self) -> bool {
        matches!(self.kind, MessageType::TaggedMessage | MessageType::P2pTaggedMessage | MessageType::P2pMessage)
    }
}

/// Returns the value that a message carries.
pub(super) fn payload<'a>(message: &Message<'a>) -> Option<&'a [u8]> {
    match *message {
        Message::TaggedMessage { payload, .. }
        | Message::P2pTaggedMessage { payload, .. }
        | Message::P2pMessage { payload, .. } => Some(payload),
        _ => None,
    }
}

/// Returns whether messages of a type have a tag, or a time.
pub(super) const fn has_tag(kind: MessageType) -> bool {
    matches!(
        kind,
        MessageType::TaggedMessage
            | MessageType::P2pTaggedMessage
            | MessageType::PortAbsent
            | MessageType::NextEventTag
            | MessageType::LatestTagComplete
            | MessageType::TagGrant
            | MessageType::ProvisionalTagGrant
            | MessageType::DownstreamNextEventTag
            | MessageType::StopRequest
            | MessageType::StopReply
            | MessageType::StopGranted
            | MessageType::Timestamp
    )
}

/// The number of bytes of a value in a record.
pub const CHUNK_BYTES: usize = 22;

/// A part of a value: the records of a value follow the record of its event.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Chunk {
    bytes: [u8; CHUNK_BYTES],
    len: u8,
    /// Whether it is the last part.
    pub is_last: bool,
}

impl Chunk {
    /// Returns a part of a value, at most [`CHUNK_BYTES`] of it.
    pub(super) fn new(part: &[u8], is_last: bool) -> Self {
        let mut bytes = [0; CHUNK_BYTES];
        let mut len = 0;
        for (place, byte) in bytes.iter_mut().zip(part) {
            *place = *byte;
            len += 1;
        }
        Self { bytes, len, is_last }
    }

    /// Returns its bytes.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.len.into()).unwrap_or(&self.bytes)
    }

    /// Returns the parts of a value, at least one.
    pub(super) fn of(value: &[u8]) -> impl Iterator<Item = Self> {
        let parts = value.len().div_ceil(CHUNK_BYTES).max(1);
        (1..=parts).map(move |part| {
            let begin = (part - 1) * CHUNK_BYTES;
            let end = value.len().min(part * CHUNK_BYTES);
            Self::new(value.get(begin..end).unwrap_or_default(), part == parts)
        })
    }
}

/// The reason why an event loop waits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Waits {
    /// No event is pending; any input ends the wait.
    Anything,
    /// The time of this tag.
    Time(Tag),
    /// An RTI that accepts the connection, its answers, other federates that accept connections, and the start.
    Start,
    /// Peers that accept the last messages.
    End,
    /// A grant for this tag.
    Grant(Tag),
    /// An input at this tag, by its index in the tables, and the limit of the wait.
    Input(Tag, u16, WaitLimit),
    /// Room for a message of this tag, at a federate or at [`RTI`].
    Room(Tag, u16),
}

/// The limit of a wait for an input.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum WaitLimit {
    /// Until the status of the input is known.
    Endless,
    /// At most for a time, such as `@maxwait`.
    Limited,
}
