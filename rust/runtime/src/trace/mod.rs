// SPDX-License-Identifier: Apache-2.0
//! What a participant records of itself: tags, reactions, messages, grants and waits, in records of one size.
//!
//! The event loops tell [`Platform::trace`], which keeps [`Record`]s or nothing. Records have numbers in place of names;
//! the compiler's table has the names. Without the feature `traces` no event loop tells anything, and nothing of this is
//! linked.

mod record;
mod ring;

use lf_coordination::clock_sync::ClockCorrection;
use lf_coordination::from_wire;
#[cfg(feature = "traces")]
use lf_model::ReactionStep;
use lf_model::time::{Instant, Tag};
use lf_model::{InputId, Part, Tables};
use lf_wire::Message;

pub use record::{Damage, FORMAT, Header, MAGIC, RECORD_BYTES, Record, Role};
pub use ring::Ring;

use crate::federate::Reason;
use crate::platform::Platform;

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
}

/// A message as far as it is recorded.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Word {
    /// What it says.
    pub subject: Subject,
    /// The federate at the other end of the connection, or [`RTI`]. In records of an RTI, [`RTI`] is a federate that has
    /// not said which one it is.
    pub peer: u16,
    /// The federate for which a value is, and the number of its input; of others, zeros.
    pub to: (u16, u16),
    /// Its tag, if it has one.
    pub tag: Option<Tag>,
    /// Bytes on the wire; of a value that is being sent, how many it has itself.
    pub bytes: u32,
}

/// What a message says.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
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
    const ALL: [Self; 13] = [
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

impl Waits {
    /// What a federate waits for: for this reason, with the input that it is about if it is about one, or else until the
    /// time of its next tag. `is_timed`: only for a time.
    pub(crate) fn of(reason: Option<Reason>, input: Option<InputId>, next: Option<Tag>, is_timed: bool) -> Self {
        let patience = if is_timed { Patience::Limited } else { Patience::Endless };
        match (reason, next) {
            (Some(Reason::Grant(tag)), _) => Self::Grant(tag),
            (Some(Reason::Input(tag, _)), _) => Self::Input(tag, input.map_or(u16::MAX, |input| input.0), patience),
            (Some(Reason::Room(tag, peer)), _) => Self::Room(tag, peer.unwrap_or(RTI)),
            (Some(Reason::Rti | Reason::Answer(_) | Reason::Peer(..) | Reason::Others), _) => Self::Start,
            (None, Some(tag)) if is_timed => Self::Time(tag),
            (None, _) => Self::Anything,
        }
    }
}

/// Says whose records follow: a participant with these tables.
pub(crate) fn begin(platform: &mut impl Platform, role: Role, tables: Option<&Tables>) {
    if TRACES {
        let sizes = tables.map_or([0; 3], |tables| [tables.reactions.len(), tables.inputs.len(), tables.outputs.len()]);
        let sizes = sizes.map(|size| u16::try_from(size).unwrap_or(u16::MAX));
        platform.trace_begins(Header { role, sizes });
    }
}

/// Records what happens now.
#[inline]
pub(crate) fn note(platform: &mut impl Platform, event: Event) {
    if TRACES {
        let now = platform.now();
        platform.trace(now, event);
    }
}

/// Records a message that goes.
#[inline]
pub(crate) fn note_sent(platform: &mut impl Platform, message: &Message<'_>, peer: u16) {
    if TRACES && let Some(word) = Word::of(message, peer) {
        note(platform, Event::Sent(word));
    }
}

/// Records a message that has come.
#[inline]
pub(crate) fn note_received(platform: &mut impl Platform, message: &Message<'_>, peer: u16) {
    if TRACES && let Some(word) = Word::of(message, peer) {
        note(platform, Event::Received(word));
    }
}

/// What a reaction does, in the event loop (0) or in a worker.
#[cfg(feature = "traces")]
pub(crate) fn step_event(step: ReactionStep, worker: u16) -> Event {
    match step {
        ReactionStep::Begins(reaction, part) => Event::ReactionBegins(reaction.0, part, worker),
        ReactionStep::Ends(reaction) => Event::ReactionEnds(reaction.0, worker),
    }
}

/// Sets the correction of the platform's clock, and records what it shows from now on.
pub(crate) fn set_correction(platform: &mut impl Platform, correction: ClockCorrection) {
    platform.set_correction(correction);
    if TRACES {
        let now = platform.now();
        platform.trace(now, Event::Clock(correction.physical(now)));
    }
}
