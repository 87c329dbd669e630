// SPDX-License-Identifier: Apache-2.0
//! Transient federates: they come and go while the federation runs, and one instance can take the place of another.
//!
//! A transient federate is *absent* until it has sent its clock, and again when it has left. No path leads through an
//! absent one, it holds nobody up, and messages to it are dropped. When its clock comes, the RTI chooses its *effective
//! start*: the first tag of this incarnation, after everything that it did before, after every message that it has
//! missed, and after every tag that was granted downstream of it, because what it sends must not come into the past of
//! others. Delays of connections are not taken into account, which is late but safe. From then on it counts with its
//! effective start as its next event.
//!
//! **Grants.** The farther the federates downstream are ahead, the later one can join. So while it is absent, they are
//! granted no tag before the RTI's clock has reached its time, and FOREVER never: what they need is granted instead.
//! The grants are computed from state, so one that waits for the clock is simply computed again.
//!
//! **Hot swap.** A second instance with the id of a running one makes its handshake, and then the first one is told to
//! stop. The RTI does not read on from the second one until the first one has left, which it has to do in time. What
//! the first one hands over before it leaves, the RTI passes on to the second one at once.
//!
//! The federation lasts as long as its persistent federates. When these have left, nobody can join any more.

use lf_model::time::{Instant, Tag};
use lf_wire::{Message, MessageType, RejectCode};

use super::barrier;
use super::log_event::{Cause, RtiEvent, Violation};
use super::machine::Rti;
use super::members::Members;
use super::outlet::{ConnectionId, Outlet, Verdict};
use super::sending::{Sending, Step};
use super::storage::{Membership, Phase, Slot, extended, id};
use crate::FederateId;

impl Members<'_> {
    /// Returns whether a connection is that of a federate that takes the place of another one.
    pub(super) fn is_successor(&self, connection: ConnectionId) -> bool {
        let claimed = self.connections[connection.0].federate.map(usize::from);
        let holder = claimed.and_then(|federate| self.connection_of(federate));
        holder.is_some_and(|holder| holder != connection)
    }

    /// Returns the connection of the federate that waits to take the place of this one.
    fn successor(&self, federate: usize) -> Option<ConnectionId> {
        let waits = |phase: Phase, claimed: Option<u16>| {
            phase == Phase::Successor && claimed.map(usize::from) == Some(federate)
        };
        self.connections.iter().position(|known| waits(known.phase, known.federate)).map(ConnectionId)
    }
}

impl Rti<'_> {
    /// Begins the federation without those that have not sent their clocks: they are transient, and absent.
    pub(super) fn await_transients(&mut self, start: Instant, outlet: &mut impl Outlet) {
        self.tags.horizon.is_open = self.config.transients() > 0;
        for federate in 0..self.members.slots.len() {
            let slot = &mut self.members.slots[federate];
            let takes_part = matches!(slot.membership, Membership::Joined(_)) && slot.clock.is_some();
            let is_surplus = !takes_part && !slot.is_transient();
            slot.incarnation.is_transient |= !takes_part;
            self.tags.graph.nodes[federate].is_transient = slot.incarnation.is_transient;
            if takes_part {
                slot.incarnation.begin = Tag::at(start);
                continue;
            }
            let connection = match slot.membership {
                Membership::Joining(connection) | Membership::Joined(connection) => Some(connection),
                Membership::Free | Membership::Departed => None,
            };
            match connection {
                // There are more persistent federates than the RTI was told.
                Some(connection) if is_surplus => self.refuse_late(federate, connection, outlet),
                Some(_) => {}
                None => slot.end_incarnation(),
            }
            self.tags.be_absent(federate);
        }
    }

    /// Tells all which transient federates upstream of them take part from the start on.
    pub(super) fn announce_first(&mut self, outlet: &mut impl Outlet) {
        let stop_tag = self.stop.tag();
        for federate in 0..self.members.slots.len() {
            if self.members.slots[federate].is_transient() && self.members.running(federate).is_some() {
                self.sending(outlet).announce(federate, true, stop_tag);
            }
        }
    }

    /// Handles the clock of a transient federate that joins the running federation.
    pub(super) fn begin_incarnation(
        &mut self,
        now: Instant,
        federate: usize,
        clock: Instant,
        outlet: &mut impl Outlet,
    ) -> Result<(), Violation> {
        let Some(connection) = self.members.connection_of(federate) else { return Ok(()) };
        let slot = &mut self.members.slots[federate];
        if !slot.is_transient() {
            return Err(Violation::Unexpected(MessageType::Timestamp));
        }
        let begin = self.tags.effective_start(federate, clock, slot.incarnation.past);
        if !self.tags.horizon.is_open || self.stop.granted().is_some() || !begin.is_finite() {
            self.refuse_late(federate, connection, outlet);
            return Ok(());
        }
        barrier::take_clock(slot, now, clock)?;
        (slot.incarnation.begin, slot.incarnation.sent) = (begin, Tag::NEVER);
        slot.pending.start = true;
        slot.pending.stop_request = self.stop.is_requested();
        outlet.log(RtiEvent::Begins { federate: id(federate), tag: begin });
        self.tags.begin_incarnation(federate, begin);
        self.tags.record_next_event(begin);
        self.agree_on_window();
        self.rounds.resume();
        for index in 0..self.tags.graph.upstreams(federate) {
            let (from, _) = self.tags.graph.upstream(federate, index);
            let came = &mut self.members.slots[federate].pending.notifications.upstream_came;
            *came = Some(extended(*came, id(from).0));
        }
        let stop_tag = self.stop.tag();
        let mut sending = self.sending(outlet);
        sending.announce(federate, true, stop_tag);
        sending.flush(federate, stop_tag);
        sending.advance_waiting_downstream(federate);
        Ok(())
    }

    /// Returns whether a federate has left that does not come back. One that sends to it directly cannot join any more:
    /// it would ask for its address without end.
    pub(super) fn has_gone(&self, federate: u16) -> bool {
        let slot = self.members.slots.get(usize::from(federate));
        self.tags.start.is_some()
            && slot.is_some_and(|slot| slot.membership == Membership::Departed && !slot.is_transient())
    }

    /// Refuses a federate that comes when nobody can join any more.
    pub(super) fn refuse_late(&mut self, federate: usize, connection: ConnectionId, outlet: &mut impl Outlet) {
        let code = RejectCode::JoinsTooLate;
        if outlet.room(connection) >= Message::Reject(code).encoded_len() {
            outlet.send(connection, &Message::Reject(code));
        }
        let (federate_id, times) = (Some(id(federate)), self.strangers.rejected.count());
        outlet.log(RtiEvent::Rejected { code, federate: federate_id, federation_id: None, violation: None, times });
        self.close(connection, outlet);
        self.members.slots[federate].end_incarnation();
    }

    /// Handles that a transient federate leaves out of order. The federation has not failed if its connection has just
    /// ended, or if it has not taken part.
    pub(super) fn lose_transient(&mut self, federate: usize, cause: Cause, outlet: &mut impl Outlet) {
        let started = self.tags.start.is_some() && self.members.slots[federate].clock.is_some();
        outlet.log(RtiEvent::Lost { federate: id(federate), cause, started });
        if started && !matches!(cause, Cause::ConnectionLost | Cause::NoStopReply) {
            self.end.loss = self.end.loss.or(Some((id(federate), cause)));
        }
        // It may have sent messages of a tag that it has not completed, or not reported.
        let incarnation = &mut self.members.slots[federate].incarnation;
        incarnation.record(incarnation.sent);
        self.depart(federate, outlet);
    }

    /// Handles that a transient federate has left the running federation.
    pub(super) fn depart_transient(&mut self, federate: usize, outlet: &mut impl Outlet) {
        let took_part = self.members.slots[federate].clock.is_some();
        self.members.slots[federate].end_incarnation();
        self.members.forget_registrations(federate);
        if took_part {
            self.members.slots[federate].incarnation.record(self.tags.state(federate).completed);
            self.tags.depart(federate);
            let stop_tag = self.stop.tag();
            let mut sending = Sending { members: &mut self.members, tags: &mut self.tags, outlet };
            sending.announce(federate, false, stop_tag);
            sending.advance_downstream(federate);
            self.stop.grant_if_agreed(&mut sending);
            self.tags.record_next_event(Tag::FOREVER);
        }
        self.succeed(federate, outlet);
    }

    /// Lets the second instance of a federate that has left take its place.
    fn succeed(&mut self, federate: usize, outlet: &mut impl Outlet) {
        let Some(connection) = self.members.successor(federate) else { return };
        let known = &mut self.members.connections[connection.0];
        known.phase = Phase::Joined;
        let slot = &mut self.members.slots[federate];
        slot.membership = Membership::Joined(connection);
        (slot.address, slot.udp_port) = (known.address, known.udp_port);
        let until = self.tags.horizon.now + self.config.clock_time_out;
        self.members.set_deadline(connection, Some(until));
        outlet.log(RtiEvent::Joined(id(federate)));
    }

    /// Passes a state that a federate hands over to the instance that waits to take its place; without one, it is
    /// dropped.
    pub(super) fn hand_over(&self, federate: usize, state: &Message<'_>, outlet: &mut impl Outlet) -> Step {
        let Some(successor) = self.members.successor(federate) else { return Step::Done };
        if outlet.room(successor) < state.encoded_len() {
            return Step::NoRoom(successor);
        }
        outlet.send(successor, state);
        Step::Done
    }

    /// Tells the federate whose place the one on this connection takes to stop, once that has completed its handshake.
    pub(super) fn replace(&mut self, connection: ConnectionId, outlet: &mut impl Outlet) {
        if let Some(federate) = self.replaced_by(connection) {
            outlet.log(RtiEvent::Replaced(id(federate)));
            self.members.slots[federate].pending.notifications.stop = true;
            let stop_tag = self.stop.tag();
            self.sending(outlet).flush(federate, stop_tag);
        }
    }

    /// Tells a transient federate to leave: it stops one microstep after its current tag, as one whose place another
    /// instance takes. Returns `false`, and does nothing, if no transient federate with this id takes part.
    pub fn dismiss(&mut self, federate: FederateId, outlet: &mut impl Outlet) -> bool {
        let index = usize::from(federate.0);
        let takes_part = |slot: &Slot| slot.is_transient() && slot.clock.is_some();
        let is_there = self.tags.start.is_some() && self.members.slots.get(index).is_some_and(takes_part);
        if is_there && self.members.running(index).is_some() {
            self.members.slots[index].pending.notifications.stop = true;
            let stop_tag = self.stop.tag();
            self.sending(outlet).flush(index, stop_tag);
            return true;
        }
        false
    }

    /// Returns the federate whose place the one on this connection waits to take.
    pub(super) fn replaced_by(&self, connection: ConnectionId) -> Option<usize> {
        let is_successor = self.members.phase(connection) == Phase::Successor;
        self.members.connections.get(connection.0)?.federate.filter(|_| is_successor).map(usize::from)
    }

    /// Holds back what the successor of a federate sends until that has left.
    pub(super) fn hold_successor(&self, federate: usize) -> Verdict {
        self.members.connection_of(federate).map_or(Verdict::Closed, Verdict::Held)
    }

    /// Closes the federation to those that are absent when no persistent federate is left.
    pub(super) fn expect_nobody_if_alone(&mut self, outlet: &mut impl Outlet) {
        let stays = |federate| self.members.running(federate).is_some() && !self.members.slots[federate].is_transient();
        if self.tags.horizon.is_open && !(0..self.members.slots.len()).any(stays) {
            self.tags.horizon.is_open = false;
            self.advance_all(outlet);
            self.tags.record_next_event(Tag::FOREVER);
        }
    }

    /// Grants each federate what it can be granted.
    pub(super) fn advance_all(&mut self, outlet: &mut impl Outlet) {
        for federate in 0..self.members.slots.len() {
            self.sending(outlet).advance(federate);
        }
    }
}
