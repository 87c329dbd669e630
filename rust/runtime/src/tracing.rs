// SPDX-License-Identifier: Apache-2.0
//! How event loops tell their platform what happens in them. Without the feature `traces` all of this does nothing.

use lf_coordination::clock_sync::ClockCorrection;
#[cfg(feature = "traces")]
use lf_model::ReactionStep;
use lf_model::time::Tag;
use lf_model::{InputId, Tables};
use lf_wire::Message;

use crate::federate::Reason;
use crate::platform::Platform;
use crate::trace::{Event, Header, Patience, RTI, Role, TRACES, Waits, Word};

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

/// What a federate waits for: for this reason, with the input that it is about if it is about one, or else until the
/// time of its next tag. `is_timed`: only for a time.
pub(crate) fn waits(reason: Option<Reason>, input: Option<InputId>, next: Option<Tag>, is_timed: bool) -> Waits {
    let patience = if is_timed { Patience::Limited } else { Patience::Endless };
    match (reason, next) {
        (Some(Reason::Grant(tag)), _) => Waits::Grant(tag),
        (Some(Reason::Input(tag, _)), _) => Waits::Input(tag, input.map_or(u16::MAX, |input| input.0), patience),
        (Some(Reason::Room(tag, peer)), _) => Waits::Room(tag, peer.unwrap_or(RTI)),
        (Some(Reason::Rti(..) | Reason::Id | Reason::Answer(_) | Reason::Peer(..) | Reason::Others), _) => Waits::Start,
        (None, Some(tag)) if is_timed => Waits::Time(tag),
        (None, _) => Waits::Anything,
    }
}
