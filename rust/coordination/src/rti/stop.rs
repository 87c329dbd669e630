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

use super::storage::Membership;
use super::{Cause, Notice, Outlet, Rti, id};

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
}

impl Rti<'_> {
    /// A federate asks to stop. Only the first request is passed on; the others' federates have agreed by theirs.
    pub(super) fn on_stop_request(&mut self, now: Instant, federate: usize, tag: Tag, outlet: &mut impl Outlet) {
        if self.slots[federate].stop_agreed {
            return;
        }
        self.agree_to_stop(federate, tag);
        if !self.stop.requested {
            self.stop.requested = true;
            outlet.notice(Notice::StopRequested(id(federate)));
            self.grant_stop_if_agreed(outlet);
            if !self.stop.granted {
                self.stop.deadline = Some(now + self.config.stop_reply_time_out);
                self.broadcast(|slot| !slot.stop_agreed, |pending| pending.stop_request = true, outlet);
            }
            return;
        }
        self.grant_stop_if_agreed(outlet);
    }

    /// A federate answers a stop request.
    pub(super) fn on_stop_reply(&mut self, federate: usize, tag: Tag, outlet: &mut impl Outlet) {
        self.agree_to_stop(federate, tag);
        self.grant_stop_if_agreed(outlet);
    }

    /// Whether a stop waits for the answer of this federate.
    pub(super) fn awaits_stop_tag(&self, federate: usize) -> bool {
        self.stop.requested && !self.stop.granted && !self.slots[federate].stop_agreed
    }

    fn agree_to_stop(&mut self, federate: usize, tag: Tag) {
        let slot = &mut self.slots[federate];
        slot.stop_agreed = true;
        // Whoever has asked itself need not be asked any more.
        slot.pending.stop_request = false;
        if !self.stop.granted {
            self.stop.tag = self.stop.tag.max(tag);
        }
    }

    /// Grants the stop once all that are left have agreed. No federate's next event is after it then.
    pub(super) fn grant_stop_if_agreed(&mut self, outlet: &mut impl Outlet) {
        let missing = |slot: &super::Slot| slot.membership != Membership::Departed && !slot.stop_agreed;
        if !self.stop.requested || self.stop.granted || self.slots.iter().any(missing) {
            return;
        }
        self.stop.granted = true;
        self.stop.deadline = None;
        let tag = self.stop.tag;
        let slots = &self.slots;
        self.graph.change_next_events(|federate, next_event| match slots[federate].membership {
            Membership::Departed => next_event,
            _ => next_event.min(tag),
        });
        outlet.notice(Notice::StopGranted(tag));
        for federate in 0..self.slots.len() {
            self.take_back_grants(federate, tag);
        }
        self.broadcast(|_| true, |pending| pending.stop_granted = true, outlet);
        for federate in 0..self.slots.len() {
            // What it has told need not be told again.
            if self.stops_in_turn(federate) {
                self.advance(federate, outlet);
            }
        }
    }

    /// A federate that has been granted the stop tag before it was one, and wants to stop in turn, asks for it again.
    fn take_back_grants(&mut self, federate: usize, tag: Tag) {
        let asks_again = self.stops_in_turn(federate);
        let slot = &mut self.slots[federate];
        if asks_again && slot.granted.max(slot.provisional.before()) >= tag {
            slot.granted = slot.granted.min(tag.before());
            slot.provisional = slot.provisional.min(tag.before());
            slot.pending.taken_back = true;
        }
    }

    fn stops_in_turn(&self, federate: usize) -> bool {
        self.slots[federate].stops_in_turn && self.graph.upstreams(federate) > 0
    }

    /// The next event of a federate, which is no later than the stop tag as long as it has not left: it may have told
    /// a later one before it knew of the stop, and then still has something to say at its last tag.
    ///
    /// The stock RTI takes what is told after the stop as it is, and so do we for federates that count on that.
    pub(super) fn not_after_stop(&self, federate: usize, next_event: Tag) -> Tag {
        match self.stop.granted() {
            Some(tag) if self.slots[federate].stops_in_turn => next_event.min(tag),
            _ => next_event,
        }
    }

    /// Nobody waits any longer for those that have not answered.
    pub(super) fn give_up_stop_replies(&mut self, outlet: &mut impl Outlet) {
        self.stop.deadline = None;
        for federate in 0..self.slots.len() {
            if !self.slots[federate].stop_agreed && self.connection_of(federate).is_some() {
                self.expel(federate, Cause::NoStopReply, outlet);
            }
        }
    }
}
