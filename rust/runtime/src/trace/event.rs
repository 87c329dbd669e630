// SPDX-License-Identifier: Apache-2.0
//! What happens in a participant, as it is recorded.

use lf_coordination::from_wire;
use lf_model::Part;
use lf_model::time::{Instant, Tag};
use lf_wire::Message;

/// Whether event loops tell what happens in them.
pub const TRACES: bool = cfg!(feature = "traces");

/// How a record names the RTI, where it names a federate otherwise.
pub const RTI: u16 = u16::MAX;

/// What happens in a participant.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Event {
    /// From here on the own clock shows this physical time of the federation when this happens.
    Clock(Instant),
    /// The first tag is at this time; whether the program does not wait for the time of its tags.
    Starts(Instant, bool),
    /// A tag begins.
    TagBegins(Tag),
    /// A tag is complete.
    TagEnds(Tag),
    /// A reaction begins, by its number in the program's tables, in the event loop or in a worker, which counts from 1.
    ReactionBegins(u16, Part, u16),
    /// The same reaction ends.
    ReactionEnds(u16, u16),
    /// A message goes into the send buffer.
    Sent(Word),
    /// A message has come and is handled.
    Received(Word),
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
    /// What it says.
    pub subject: Subject,
    /// The federate at the other end of the connection, or [`RTI`]. In records of an RTI, [`RTI`] is a federate that
    /// has not said which one it is.
    pub peer: u16,
    /// The federate for which a value is, and the number of its input; of others, zeros.
    pub to: (u16, u16),
    /// Its tag, if it has one.
    pub tag: Option<Tag>,
    /// Bytes on the wire; of a value that is being sent, how many it has itself.
    pub bytes: u32,
}

/// What a message says.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[repr(u8)]
pub enum Subject {
    /// A value.
    Value,
    /// There is no value.
    Absent,
    /// The next event of a federate.
    NextEvent,
    /// A federate has completed a tag.
    Complete,
    /// A grant.
    Grant,
    /// A provisional grant.
    ProvisionalGrant,
    /// Next events of others, which nobody need be told of.
    DownstreamNextEvent,
    /// The time of a federate, or the start of the federation.
    Time,
    /// A federate asks to stop, or is asked.
    StopRequest,
    /// A federate says when it can stop.
    StopReply,
    /// The tag at which all stop.
    StopGranted,
    /// A federate leaves.
    Resign,
    /// A participant ends by an error.
    Failed,
}

impl Subject {
    /// All, in the order of their numbers.
    pub(super) const ALL: [Self; 13] = [
        Self::Value,
        Self::Absent,
        Self::NextEvent,
        Self::Complete,
        Self::Grant,
        Self::ProvisionalGrant,
        Self::DownstreamNextEvent,
        Self::Time,
        Self::StopRequest,
        Self::StopReply,
        Self::StopGranted,
        Self::Resign,
        Self::Failed,
    ];

    /// For people, as LF's own tools say it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Value => "message",
            Self::Absent => "absent",
            Self::NextEvent => "NET",
            Self::Complete => "LTC",
            Self::Grant => "TAG",
            Self::ProvisionalGrant => "PTAG",
            Self::DownstreamNextEvent => "DNET",
            Self::Time => "start time",
            Self::StopRequest => "stop request",
            Self::StopReply => "stop reply",
            Self::StopGranted => "stop granted",
            Self::Resign => "resign",
            Self::Failed => "failed",
        }
    }
}

impl Word {
    /// A message, unless it is one of the handshake or of clock synchronization.
    pub fn of(message: &Message<'_>, peer: u16) -> Option<Self> {
        let (subject, tag, to) = match *message {
            Message::TaggedMessage { port, federate, tag, .. }
            | Message::P2pTaggedMessage { port, federate, tag, .. } => (Subject::Value, Some(tag), (federate, port)),
            Message::P2pMessage { port, federate, .. } => (Subject::Value, None, (federate, port)),
            Message::PortAbsent { port, federate, tag } => (Subject::Absent, Some(tag), (federate, port)),
            Message::NextEventTag(tag) => (Subject::NextEvent, Some(tag), (0, 0)),
            Message::LatestTagComplete(tag) => (Subject::Complete, Some(tag), (0, 0)),
            Message::TagGrant(tag) => (Subject::Grant, Some(tag), (0, 0)),
            Message::ProvisionalTagGrant(tag) => (Subject::ProvisionalGrant, Some(tag), (0, 0)),
            Message::DownstreamNextEventTag(tag) => (Subject::DownstreamNextEvent, Some(tag), (0, 0)),
            Message::Timestamp(time) => (Subject::Time, Some(lf_wire::Tag::new(time, 0)), (0, 0)),
            Message::StopRequest(tag) => (Subject::StopRequest, Some(tag), (0, 0)),
            Message::StopReply(tag) => (Subject::StopReply, Some(tag), (0, 0)),
            Message::StopGranted(tag) => (Subject::StopGranted, Some(tag), (0, 0)),
            Message::Resign => (Subject::Resign, None, (0, 0)),
            Message::Failed => (Subject::Failed, None, (0, 0)),
            _ => return None,
        };
        let bytes = u32::try_from(message.encoded_len()).unwrap_or(u32::MAX);
        Some(Self { subject, peer, to, tag: tag.map(from_wire), bytes })
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
