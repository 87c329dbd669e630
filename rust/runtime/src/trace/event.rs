// SPDX-License-Identifier: Apache-2.0
//! What happens in a participant, as it is recorded.

use lf_coordination::from_wire;
use lf_model::time::{Instant, Tag};
use lf_model::{Part, TriggerId};
use lf_wire::{Message, MessageType};

use super::header::Header;

/// How a record names the RTI, where it names a federate otherwise.
pub const RTI: u16 = u16::MAX;

/// What happens in a participant.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Event {
    /// The recording begins: whose it is. It comes before all others.
    Begins(Header),
    /// From here on the own clock shows this physical time of the federation when this happens.
    Clock(Instant),
    /// The first tag is at this time; whether the program does not wait for the time of its tags.
    Starts(Instant, bool),
    /// With decentralized coordination: the tag that begins next could begin at this time, as far as that depends on
    /// clocks.
    Due(Instant),
    /// A tag begins.
    TagBegins(Tag),
    /// A tag is complete.
    TagEnds(Tag),
    /// What comes from outside at the tag that has just begun: a physical action, or a physical connection within the
    /// federate, by its number in the program's tables. Recorded with values only; the value follows, if it has one.
    Physical(TriggerId),
    /// A reaction begins, by its number in the program's tables, in the event loop or in a worker, which counts from 1.
    ReactionBegins(u16, Part, u16),
    /// The same reaction ends.
    ReactionEnds(u16, u16),
    /// A message goes into the send buffer.
    Sent(Word),
    /// A message has come, and waits for room in the queue of its input. It may be told more than once.
    Held(Word),
    /// A message has come and is handled. With values, its value follows.
    Received(Word),
    /// A part of the value of what was recorded before.
    Data(Chunk),
    /// The event loop begins to wait.
    WaitBegins(Waits),
    /// The event loop goes on.
    WaitEnds,
    /// The participant ends; whether by an error.
    Ends(bool),
    /// So many records were lost here, because there was no room for more.
    Lost(u64),
    /// In a file that goes on at its beginning when it is full: the newest record is before this, the oldest behind.
    Seam,
}

/// A message as far as it is recorded.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Word {
    /// Its type.
    pub kind: MessageType,
    /// The federate at the other end of the connection, or [`RTI`]. In records of an RTI, [`RTI`] is a federate that
    /// has not said which one it is.
    pub peer: u16,
    /// The federate for which a value is, and the number of its input; of others, zeros.
    pub to: (u16, u16),
    /// Its tag, if it has one; of a TIMESTAMP, its time.
    pub tag: Option<Tag>,
    /// Bytes on the wire; of a value that is being sent, how many it has itself.
    pub bytes: u32,
}

impl Word {
    /// Returns what is recorded of a message.
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

/// How many bytes of a value a record holds.
pub const CHUNK_BYTES: usize = 22;

/// A part of a value: the records of one value follow the record of the event that it came with.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Chunk {
    bytes: [u8; CHUNK_BYTES],
    len: u8,
    /// Whether the value ends with it.
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

    /// Returns the parts of a value, of which there is one at least.
    pub(super) fn of(value: &[u8]) -> impl Iterator<Item = Self> {
        let parts = value.len().div_ceil(CHUNK_BYTES).max(1);
        (1..=parts).map(move |part| {
            let begin = (part - 1) * CHUNK_BYTES;
            let end = value.len().min(part * CHUNK_BYTES);
            Self::new(value.get(begin..end).unwrap_or_default(), part == parts)
        })
    }
}

/// What an event loop waits for.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Waits {
    /// Anything that comes: there is no event.
    Anything,
    /// The time of this tag.
    Time(Tag),
    /// An RTI that takes the connection, its answers, other federates that take connections, and the start.
    Start,
    /// Others that take the last words.
    End,
    /// A grant for this tag.
    Grant(Tag),
    /// What comes at this tag at an input, by its place in the tables; for ever, or for as long as the program says.
    Input(Tag, u16, Patience),
    /// Room for what is sent at this tag, at a federate or at [`RTI`].
    Room(Tag, u16),
}

/// How long an input is waited for.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Patience {
    /// Until it is known what comes.
    Endless,
    /// At most for a time, such as `@maxwait` says.
    Limited,
}
