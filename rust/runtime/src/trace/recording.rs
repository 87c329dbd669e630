// SPDX-License-Identifier: Apache-2.0
//! The connection from event loops to a recorder. Without the feature `traces` it does nothing.

use core::fmt;
use core::marker::PhantomData;

#[cfg(feature = "traces")]
use lf_model::ReactionStep;
use lf_model::time::{Instant, Tag};
use lf_model::{Engine, InputId, Program, Tables};
use lf_wire::{Decoded, Limits, Message, decode};

use super::event::{Chunk, Event, RTI, TracedMessage, WaitLimit, Waits, payload};
use super::header::{Header, Role};
use crate::federate::Reason;
use crate::platform::Platform;

/// The longest recorded value of a physical action: it lies on the stack of the event loop meanwhile.
#[cfg(feature = "traces")]
const VALUE_BYTES_MAX: usize = if cfg!(target_pointer_width = "64") { 1 << 14 } else { 1 << 9 };

/// A consumer of a participant's events.
pub trait Recorder {
    /// Takes an event, at this time of the platform's clock.
    fn record(&mut self, at: Instant, event: Event);
}

/// An event loop's access to a [`Recorder`], if there is one, with values or without.
///
/// Without a recorder, an event costs one test of a pointer: no clock is read, no lock taken, no function called.
pub struct Recording<'a> {
    /// The recorder, and whether it takes values.
    #[cfg(feature = "traces")]
    to: Option<(&'a mut dyn Recorder, bool)>,
    lifetime: PhantomData<&'a mut ()>,
}

impl fmt::Debug for Recording<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Recording").finish_non_exhaustive()
    }
}

#[cfg(feature = "traces")]
impl<'a> Recording<'a> {
    /// Returns a recording to a recorder, with the values of messages and physical actions if it accepts `values`.
    pub fn new(recorder: &'a mut dyn Recorder, values: bool) -> Self {
        Self { to: Some((recorder, values)), lifetime: PhantomData }
    }
}

impl<'a> Recording<'a> {
    /// Returns the same for a part of its lifetime.
    #[cfg_attr(not(feature = "traces"), expect(clippy::unused_self, reason = "nothing is recorded"))]
    pub(crate) fn for_less<'b>(self) -> Recording<'b>
    where
        'a: 'b,
    {
        Recording {
            #[cfg(feature = "traces")]
            to: self.to.map(|(recorder, values)| (recorder as &mut dyn Recorder, values)),
            lifetime: PhantomData,
        }
    }
}

impl Recording<'_> {
    /// Returns the same for a while. Without the feature it takes no room in its owner, unlike a reference.
    #[inline]
    #[cfg_attr(not(feature = "traces"), expect(clippy::unused_self, reason = "nothing is recorded"))]
    pub(crate) fn reborrow(&mut self) -> Recording<'_> {
        Recording {
            #[cfg(feature = "traces")]
            to: self.to.as_mut().map(|(recorder, values)| (&mut **recorder as &mut dyn Recorder, *values)),
            lifetime: PhantomData,
        }
    }

    /// The recording without a recorder.
    pub const OFF: Self = Self {
        #[cfg(feature = "traces")]
        to: None,
        lifetime: PhantomData,
    };

    #[inline]
    #[cfg_attr(not(feature = "traces"), expect(clippy::unused_self, reason = "there is nobody"))]
    fn to(&mut self) -> Option<(&mut dyn Recorder, bool)> {
        #[cfg(feature = "traces")]
        return self.to.as_mut().map(|(recorder, values)| (&mut **recorder as &mut dyn Recorder, *values));
        #[cfg(not(feature = "traces"))]
        None
    }

    /// Returns whether there is a recorder.
    #[inline]
    pub(crate) fn is_on(&mut self) -> bool {
        self.to().is_some()
    }

    /// Returns whether values are recorded.
    #[inline]
    pub(crate) fn has_values(&mut self) -> bool {
        self.to().is_some_and(|(_, values)| values)
    }

    /// Records the header of a participant with these tables.
    pub(crate) fn begin(&mut self, platform: &mut impl Platform, role: Role, tables: Option<&Tables>) {
        let sizes = tables.map_or([0; 3], |tables| [tables.reactions.len(), tables.inputs.len(), tables.outputs.len()]);
        let sizes = sizes.map(|size| u16::try_from(size).unwrap_or(u16::MAX));
        self.note(platform, Event::Begins(Header { role, sizes }));
    }

    /// Records an event now.
    #[inline]
    pub(crate) fn note(&mut self, platform: &mut impl Platform, event: Event) {
        if let Some((recorder, _)) = self.to() {
            recorder.record(platform.now(), event);
        }
    }

    /// Records an event at this time of the platform's clock.
    #[inline]
    pub(crate) fn note_at(&mut self, at: Instant, event: Event) {
        if let Some((recorder, _)) = self.to() {
            recorder.record(at, event);
        }
    }

    /// Records the begin of the open tag, and with values its inputs from outside.
    #[inline]
    pub(crate) fn note_tag(&mut self, platform: &mut impl Platform, engine: &Engine<'_>, program: &mut dyn Program) {
        if !self.is_on() {
            return;
        }
        let now = platform.now();
        self.note_at(now, Event::TagBegins(engine.current_tag()));
        if self.has_values() {
            self.note_physical(now, engine, program);
        }
    }

    /// Records the inputs from outside at the open tag, with their values.
    #[cfg(feature = "traces")]
    #[inline(never)]
    fn note_physical(&mut self, at: Instant, engine: &Engine<'_>, program: &mut dyn Program) {
        let mut bytes = [0; VALUE_BYTES_MAX];
        engine.physical_events(program, &mut |trigger, encode| {
            self.note_at(at, Event::Physical(trigger));
            if let (Some(Ok(len)), Some((recorder, true))) = (encode(&mut bytes), self.to()) {
                record_value(recorder, at, bytes.get(..len).unwrap_or_default());
            }
        });
    }

    #[cfg(not(feature = "traces"))]
    #[expect(clippy::unused_self, reason = "nothing is recorded")]
    fn note_physical(&mut self, _: Instant, _: &Engine<'_>, _: &mut dyn Program) {}

    /// Records a sent message.
    #[inline]
    pub(crate) fn note_sent(&mut self, platform: &mut impl Platform, message: &Message<'_>, peer: u16) {
        if let Some((recorder, _)) = self.to() {
            recorder.record(platform.now(), Event::Sent(TracedMessage::of(message, peer)));
        }
    }

    /// Records a received message that is handled now.
    #[inline]
    pub(crate) fn note_received(&mut self, platform: &mut impl Platform, message: &Message<'_>, peer: u16) {
        if self.is_on() {
            let now = platform.now();
            self.note_received_at(now, message, peer);
        }
    }

    /// Records the message in these bytes, received at this time of the platform's clock, if they are one.
    pub(crate) fn note_bytes(&mut self, at: Instant, bytes: &[u8], peer: u16) {
        if let Ok(Decoded::Complete { message, .. }) = decode(bytes, &Limits::NONE) {
            self.note_received_at(at, &message, peer);
        }
    }

    /// Records a message received at this time of the platform's clock, with its value if values are recorded.
    pub(crate) fn note_received_at(&mut self, at: Instant, message: &Message<'_>, peer: u16) {
        let Some((recorder, values)) = self.to() else { return };
        recorder.record(at, Event::Received(TracedMessage::of(message, peer)));
        if let Some(value) = payload(message).filter(|_| values) {
            record_value(recorder, at, value);
        }
    }
}

fn record_value(recorder: &mut dyn Recorder, at: Instant, value: &[u8]) {
    Chunk::of(value).for_each(|chunk| recorder.record(at, Event::Data(chunk)));
}

/// Returns the event of a reaction, in the event loop (0) or in a worker.
#[cfg(feature = "traces")]
pub(crate) fn step_event(step: ReactionStep, worker: u16) -> Event {
    match step {
        ReactionStep::Begins(reaction, part) => Event::ReactionBegins(reaction.0, part, worker),
        ReactionStep::Ends(reaction) => Event::ReactionEnds(reaction.0, worker),
    }
}

/// Returns the reason of a federate's wait: `reason`, with its input if it has one, or else the time of its next tag.
/// `is_timed`: only for a time.
pub(crate) fn waits(reason: Option<Reason>, input: Option<InputId>, next: Option<Tag>, is_timed: bool) -> Waits {
    let limit = if is_timed { WaitLimit::Limited } else { WaitLimit::Endless };
    match (reason, next) {
        (Some(Reason::Grant(tag)), _) => Waits::Grant(tag),
        (Some(Reason::Input(tag, _)), _) => Waits::Input(tag, input.map_or(u16::MAX, |input| input.0), limit),
        (Some(Reason::Room(tag, peer)), _) => Waits::Room(tag, peer.unwrap_or(RTI)),
        (Some(Reason::Rti(..) | Reason::Id | Reason::Answer(_) | Reason::Peer(..) | Reason::Others), _) => Waits::Start,
        (None, Some(tag)) if is_timed => Waits::Time(tag),
        (None, _) => Waits::Anything,
    }
}
