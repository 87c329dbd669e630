// SPDX-License-Identifier: Apache-2.0
//! Stopping together: one federate asks, the others answer with the earliest tag that is possible for them, and the RTI
//! grants the latest of these to all. A federate that has left counts as agreed.
//!
//! **Ordered stop.** The stock RTI grants a stop to all federates at once. But a federate that has been granted tags
//! far ahead, because no federate upstream had an event, then runs its last tag without the messages of those upstream
//! at theirs. This RTI therefore revokes what it has granted of the stop tag and later ones, so that such a federate
//! asks for that tag again and is granted it like any other. The stock federates do not know this; so the RTI does it
//! only for federates that ask for it, in a way that makes no difference to a stock RTI: as the first advertisement of
//! their address they send the port that stands for no port, which is every RTI's assumption anyway.
//!
//! A PTAG of the stop tag just before `STOP_GRANTED` revokes the grants. The stock RTI never grants a tag provisionally
//! that it has granted before, so a federate can tell the difference. The PTAG allows nothing, but still says that
//! nothing comes before that tag; and when the federate has done everything before it, it answers with an LTC.

use lf_derive::outlined;
use lf_model::time::{Instant, Tag};

use super::log_event::RtiEvent;
use super::outlet::Outlet;
use super::sending::Sending;
use super::storage::{Slot, id};

/// The state of the agreement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Stop {
    /// The latest tag that a federate has named.
    tag: Tag,
    /// The time by which all have to answer, while the request is open.
    deadline: Option<Instant>,
    requested: bool,
    granted: bool,
}

impl Default for Stop {
    fn default() -> Self {
        Self { tag: Tag::NEVER, deadline: None, requested: false, granted: false }
    }
}

impl Stop {
    pub(super) fn tag(&self) -> Tag {
        self.tag
    }

    pub(super) fn granted(&self) -> Option<Tag> {
        self.granted.then_some(self.tag)
    }

    pub(super) fn is_requested(&self) -> bool {
        self.requested
    }

    pub(super) fn deadline(&self) -> Option<Instant> {
        self.deadline
    }

    /// Returns whether a stop waits for the answer of a federate.
    #[outlined]
    pub(super) fn awaits(&self, slot: &Slot) -> bool {
        self.requested && !self.granted && !slot.stop_agreed
    }

    /// Handles a federate's request to stop. Only the first request is passed on; a later one is the sender's
    /// agreement. All have to answer by `deadline`.
    pub(super) fn request(
        &mut self,
        deadline: Instant,
        federate: usize,
        tag: Tag,
        sending: &mut Sending<'_, '_, impl Outlet>,
    ) {
        if sending.members.slots[federate].stop_agreed {
            return;
        }
        let is_first = !core::mem::replace(&mut self.requested, true);
        if is_first {
            sending.outlet.log(RtiEvent::StopRequested(id(federate)));
        }
        self.reply(federate, tag, sending);
        if is_first && !self.granted {
            self.deadline = Some(deadline);
            sending.broadcast(self.tag, |slot| !slot.stop_agreed, |pending| pending.stop_request = true);
        }
    }

    /// Handles the earliest tag at which a federate can stop.
    pub(super) fn reply(&mut self, federate: usize, tag: Tag, sending: &mut Sending<'_, '_, impl Outlet>) {
        let slot = &mut sending.members.slots[federate];
        slot.stop_agreed = true;
        // A federate that has asked itself need not be asked any more.
        slot.pending.stop_request = false;
        if !self.granted {
            self.tag = self.tag.max(tag);
        }
        self.grant_if_agreed(sending);
    }

    /// Grants the stop once all that are left have agreed. No federate's next event is after it then.
    pub(super) fn grant_if_agreed(&mut self, sending: &mut Sending<'_, '_, impl Outlet>) {
        let members = &sending.members;
        let is_missing = |index: usize| members.running(index).is_some() && !members.slots[index].stop_agreed;
        if !self.requested || self.granted || (0..members.slots.len()).any(is_missing) {
            return;
        }
        self.granted = true;
        self.deadline = None;
        let tag = self.tag;
        sending.tags.stop(tag);
        sending.outlet.log(RtiEvent::StopGranted(tag));
        for federate in 0..sending.members.slots.len() {
            // A federate that has been granted the stop tag before it was one asks for it again.
            if asks_again(federate, sending) && sending.tags.state_mut(federate).revoke(tag) {
                sending.members.slots[federate].pending.revoked = true;
            }
        }
        sending.broadcast(tag, |_| true, |pending| pending.stop_granted = true);
        for federate in 0..sending.members.slots.len() {
            // What it has announced need not be announced again.
            if asks_again(federate, sending) {
                sending.advance(federate);
            }
        }
    }

    /// Returns the next event of a federate, limited to the stop tag while it has not left: it may have announced a
    /// later one before it knew of the stop, and then still has messages to send at its last tag.
    ///
    /// The stock RTI accepts later announcements unchanged, and so does this one for federates that rely on it.
    pub(super) fn limit(&self, slot: &Slot, next_event: Tag) -> Tag {
        match self.granted() {
            Some(tag) if slot.ordered_stop => next_event.min(tag),
            _ => next_event,
        }
    }
}

/// Returns whether a federate asks for the stop tag again, as for any other tag.
fn asks_again(federate: usize, sending: &Sending<'_, '_, impl Outlet>) -> bool {
    sending.members.slots[federate].ordered_stop && sending.tags.graph.upstreams(federate) > 0
}
