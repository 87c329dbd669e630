// SPDX-License-Identifier: Apache-2.0
//! Stopping together: one federate asks, the others answer with the earliest tag that is possible for them, and the
//! latest of these is granted to all. A federate that has left counts as agreed.
//!
//! **In turn.** The stock RTI grants a stop to all federates at once. But one that has been granted tags far ahead,
//! because nobody upstream had anything to do, then runs its last tag without what those upstream send at theirs. An
//! RTI that knows better takes back what it has granted of the stop tag and later ones, so that such a federate asks
//! for that tag again and gets it as any other. The stock federates do not know of that; so it is done only for
//! federates that ask for it, in a way that makes no difference to a stock RTI: before anything else about their
//! address they advertise the port that means that there is none, which is what every RTI takes it to be anyhow.
//!
//! What takes grants back is a PTAG of the stop tag just before `STOP_GRANTED`. The stock RTI never grants a tag
//! provisionally that it has granted before, so a federate can tell. It allows nothing, but says as ever that nothing
//! comes before that tag; and when the federate has done all that is before, it says so (LTC).

use lf_model::time::{Instant, Tag};

use super::notice::Notice;
use super::outlet::Outlet;
use super::sending::Sending;
use super::storage::{Membership, Slot, id};

/// What the federates have agreed on so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Stop {
    /// The latest tag that anybody has named.
    tag: Tag,
    /// When all have to have answered, while somebody has been asked and nothing is granted.
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

    /// Whether a stop waits for the answer of a federate.
    #[cfg_attr(target_pointer_width = "32", inline(never))]
    pub(super) fn awaits(&self, slot: &Slot) -> bool {
        self.requested && !self.granted && !slot.stop_agreed
    }

    /// A federate asks to stop. Only the first request is passed on; the others' federates have agreed by theirs. All
    /// have to have answered at `deadline`.
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
            sending.outlet.notice(Notice::StopRequested(id(federate)));
        }
        self.reply(federate, tag, sending);
        if is_first && !self.granted {
            self.deadline = Some(deadline);
            sending.broadcast(self.tag, |slot| !slot.stop_agreed, |pending| pending.stop_request = true);
        }
    }

    /// A federate names the earliest tag at which it can stop.
    pub(super) fn reply(&mut self, federate: usize, tag: Tag, sending: &mut Sending<'_, '_, impl Outlet>) {
        let slot = &mut sending.members.slots[federate];
        slot.stop_agreed = true;
        // Whoever has asked itself need not be asked any more.
        slot.pending.stop_request = false;
        if !self.granted {
            self.tag = self.tag.max(tag);
        }
        self.grant_if_agreed(sending);
    }

    /// Grants the stop once all that are left have agreed. No federate's next event is after it then.
    pub(super) fn grant_if_agreed(&mut self, sending: &mut Sending<'_, '_, impl Outlet>) {
        let missing = |slot: &Slot| slot.membership != Membership::Departed && !slot.stop_agreed;
        if !self.requested || self.granted || sending.members.slots.iter().any(missing) {
            return;
        }
        self.granted = true;
        self.deadline = None;
        let tag = self.tag;
        sending.tags.stop(tag);
        sending.outlet.notice(Notice::StopGranted(tag));
        for federate in 0..sending.members.slots.len() {
            // One that has been granted the stop tag before it was one asks for it again.
            if asks_again(federate, sending) && sending.tags.state_mut(federate).take_back(tag) {
                sending.members.slots[federate].pending.taken_back = true;
            }
        }
        sending.broadcast(tag, |_| true, |pending| pending.stop_granted = true);
        for federate in 0..sending.members.slots.len() {
            // What it has told need not be told again.
            if asks_again(federate, sending) {
                sending.advance(federate);
            }
        }
    }

    /// The next event of a federate, which is no later than the stop tag as long as it has not left: it may have told
    /// a later one before it knew of the stop, and then still has something to say at its last tag.
    ///
    /// The stock RTI takes what is told after the stop as it is, and so do we for federates that count on that.
    pub(super) fn limit(&self, slot: &Slot, next_event: Tag) -> Tag {
        match self.granted() {
            Some(tag) if slot.stops_in_turn => next_event.min(tag),
            _ => next_event,
        }
    }

    /// Nobody waits any longer for those that have not answered.
    pub(super) fn give_up(&mut self) {
        self.deadline = None;
    }
}

/// Whether a federate asks for the stop tag in its turn, as for any other.
fn asks_again(federate: usize, sending: &Sending<'_, '_, impl Outlet>) -> bool {
    sending.members.slots[federate].stops_in_turn && sending.tags.graph.upstreams(federate) > 0
}
