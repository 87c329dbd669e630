// SPDX-License-Identifier: Apache-2.0
//! Transient federates: they come and go while the federation runs, and one instance can take the place of another.
//!
//! A transient federate is *absent* until it has sent its clock, and again when it has left. No path leads through an
//! absent one, it holds nobody up, and messages to it are dropped. When its clock comes, the RTI chooses its *effective
//! start*: the first tag of this life, after everything that it did before, after every message that it has missed, and
//! after every tag that was granted downstream of it, because what it sends must not come into the past of others.
//! Delays of connections are not taken into account, which is late but safe. From then on it counts with its effective
//! start as its next event.
//!
//! **Grants.** The farther the federates downstream are ahead, the later one can join. So while it is absent, they are
//! granted no tag before the RTI's clock has reached its time, and FOREVER never: what they need is granted instead.
//! The grants are computed from state, so one that waits for the clock is simply computed again.
//!
//! **Hot swap.** A second instance with the id of a running one makes its handshake, and then the first one is told to
//! stop. The RTI does not read on from the second one until the first one has left, which it has to do in time.
//!
//! The federation lasts as long as its persistent federates. When these have left, nobody can join any more.

use lf_model::time::{Instant, Tag};
use lf_wire::{Message, MessageType, RejectCode};

use super::barrier;
use super::config::{Config, SetupError};
use super::delay::earliest_after;
use super::grants::Grant;
use super::handshake::Entry;
use super::log_event::{Cause, RtiEvent, Violation};
use super::machine::Rti;
use super::members::Members;
use super::outlet::{ConnectionId, Outlet, Verdict};
use super::sending::Sending;
use super::stop::Stop;
use super::storage::{Membership, Phase, Slot, extended, id};
use super::tag_state::TagState;
use super::tags::Tags;
use crate::Deadline;
use crate::tag::to_wire;

/// What the RTI knows of a federate that comes and goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Life {
    /// Whether the federate is transient. From the start on this is true for all that have not started then.
    pub(super) is_transient: bool,
    /// Whether its connections are known. They are the same in each of its lives.
    pub(super) has_neighbors: bool,
    /// The first tag of its current life.
    begin: Tag,
    /// The latest tag that it has completed in an earlier life, or of a message that was sent to it.
    past: Tag,
}

impl Life {
    /// The state of an id that no federate has had.
    pub(super) const NONE: Self =
        Self { is_transient: false, has_neighbors: false, begin: Tag::NEVER, past: Tag::NEVER };

    /// Records that a federate takes this id.
    pub(super) fn join(&mut self, is_transient: bool) {
        self.is_transient = is_transient;
    }

    /// Returns whether a message with this tag lies before the effective start.
    pub(super) fn misses(&self, tag: Tag) -> bool {
        tag < self.begin
    }

    /// Records a tag of the past: the next life begins after it.
    pub(super) fn record(&mut self, tag: Tag) {
        self.past = self.past.max(tag);
    }
}

impl Slot {
    /// Forgets everything that belongs to the life of a transient federate in the running federation.
    pub(super) fn end_life(&mut self) {
        let life = Life { begin: Tag::NEVER, ..self.life };
        *self = Self { membership: Membership::Departed, life, ..Self::EMPTY };
    }
}

/// What a federate is to be told because of transient federates. A range has the first and the last id of federates
/// about which there may be something to tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Notices {
    /// Federates upstream that have come.
    upstream_came: Option<(u16, u16)>,
    /// Federates that have left, of those for which the receiver is registered.
    outbound_left: Option<(u16, u16)>,
    /// The same of those that have come.
    outbound_came: Option<(u16, u16)>,
    /// Whether the federate has to stop alone.
    stop: bool,
}

impl Notices {
    /// Nothing to tell.
    pub(super) const NONE: Self = Self { upstream_came: None, outbound_left: None, outbound_came: None, stop: false };
}

/// The limit of grants downstream of absent federates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Horizon {
    /// The RTI's clock.
    now: Instant,
    /// The time at which the first of the grants that wait for the clock can be made.
    due: Option<Instant>,
    /// Whether transient federates may still join.
    is_open: bool,
}

impl Default for Horizon {
    fn default() -> Self {
        Self { now: Instant::NEVER, due: None, is_open: false }
    }
}

impl Horizon {
    pub(super) fn set_now(&mut self, now: Instant) {
        self.now = self.now.max(now);
    }

    pub(super) fn deadline(&self) -> Deadline {
        self.due.into()
    }

    /// Returns whether grants that have waited for the clock can be made.
    pub(super) fn take_due(&mut self) -> bool {
        self.due.take_if(|due| *due <= self.now).is_some()
    }

    fn has_reached(&self, tag: Tag) -> bool {
        tag.time <= self.now
    }

    fn wait_for(&mut self, tag: Tag) {
        self.due = Some(self.due.map_or(tag.time, |due| due.min(tag.time)));
    }
}

/// Whether federates may join.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Admission {
    /// As if there were no transient federates: it has not started, or expects none.
    Usual,
    /// Transient federates may join the running federation.
    Open,
    /// The federation runs, but nobody may join any more.
    Over,
}

impl Admission {
    pub(super) fn of(config: &Config<'_>, tags: &Tags<'_>, stop: &Stop) -> Self {
        match (config.transients() > 0 && tags.start.is_some(), tags.horizon.is_open && stop.granted().is_none()) {
            (false, _) => Self::Usual,
            (true, true) => Self::Open,
            (true, false) => Self::Over,
        }
    }

    /// Returns how a peer can have an id while the federation runs, or why it cannot; `None` before that.
    pub(super) fn entry(
        self,
        members: &Members<'_>,
        federate: u16,
        is_transient: bool,
    ) -> Option<Result<Entry, (RejectCode, Option<Violation>)>> {
        if self == Self::Usual {
            return None;
        }
        let slot = &members.slots[usize::from(federate)];
        let takes = is_transient && slot.is_transient();
        let in_use = Err((RejectCode::IdInUse, None));
        Some(match slot.membership {
            Membership::Departed if takes && self == Self::Open => Ok(Entry::Vacant),
            Membership::Departed if is_transient && !slot.is_transient() => {
                Err((RejectCode::IdInUse, Some(Violation::HasLeft)))
            }
            Membership::Free | Membership::Departed => Err((RejectCode::JoinsTooLate, None)),
            Membership::Joined(_) if takes && self == Self::Open => {
                let claims = members.connections.iter().filter(|other| other.federate == Some(federate));
                let is_alone = claims.filter(|other| other.phase != Phase::Draining).count() == 1;
                if is_alone && slot.clock.is_some() { Ok(Entry::Successor) } else { in_use }
            }
            Membership::Joined(_) | Membership::Joining(_) => in_use,
        })
    }
}

impl Config<'_> {
    /// Returns the storage for registrations, cleared, if it suffices for the transient federates among `federates`.
    pub(super) fn check_transients<'s>(
        &self,
        federates: usize,
        registrations: &'s mut [bool],
    ) -> Result<&'s mut [bool], SetupError> {
        if self.transients() == 0 {
            return Ok(&mut []);
        }
        if self.transients() >= federates {
            return Err(SetupError::Transients { transients: self.transients, federates });
        }
        let (needed, found) = (federates.saturating_mul(federates), registrations.len());
        let Some(registrations) = registrations.get_mut(..needed) else {
            return Err(SetupError::Storage { part: "registrations", needed, found });
        };
        registrations.fill(false);
        Ok(registrations)
    }
}

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

    /// Records that a federate wants to be informed about another one, if that is transient.
    pub(super) fn register(&mut self, federate: usize, other: u16, is_transient: bool) {
        let place = federate * self.slots.len() + usize::from(other);
        if is_transient && let Some(registered) = self.registrations.get_mut(place) {
            *registered = true;
        }
    }

    fn is_registered(&self, federate: usize, other: usize) -> bool {
        self.registrations.get(federate * self.slots.len() + other) == Some(&true)
    }

    fn forget_registrations(&mut self, federate: usize) {
        let count = self.slots.len();
        if let Some(own) = self.registrations.get_mut(federate * count..(federate + 1) * count) {
            own.fill(false);
        }
    }
}

impl Tags<'_> {
    /// Returns whether a transient federate is absent that may still join.
    pub(super) fn expects_transients(&self) -> bool {
        self.horizon.is_open && (0..self.federates()).any(|federate| self.graph.is_absent(federate))
    }

    /// Makes a federate absent from the start on.
    fn be_absent(&mut self, federate: usize) {
        self.state_mut(federate).departed = true;
        self.graph.nodes[federate].next_event = Tag::FOREVER;
    }

    /// Returns the first tag of a federate whose clock shows this time, or FOREVER if there is none.
    fn effective_start(&self, federate: usize, clock: Instant, past: Tag) -> Tag {
        let earliest = Tag::at(clock.max(self.start.unwrap_or(clock)));
        let row = self.graph.nodes[federate].outgoing;
        let downstream = (0..row.len).map(|index| self.graph.other_end(row, index));
        let granted = downstream.filter(|other| *other != federate && !self.state(*other).departed);
        let granted = granted.map(|other| self.state(other).reach());
        let before = granted.chain([past]);
        before.filter(|tag| *tag != Tag::NEVER).map(earliest_after).fold(earliest, Tag::max)
    }

    /// Begins the life of a federate at its effective start.
    fn begin_life(&mut self, federate: usize, begin: Tag) {
        let node = &mut self.graph.nodes[federate];
        node.tags = TagState::EMPTY;
        node.next_event = begin;
        self.graph.find_paths();
    }

    /// Limits a grant while transient federates upstream may join: see the module.
    pub(super) fn limited_grant(&mut self, federate: usize, grant: Grant) -> Option<Grant> {
        if !self.horizon.is_open {
            return Some(grant);
        }
        let row = self.graph.nodes[federate].incoming;
        let upstream = (0..row.len).map(|index| self.graph.other_end(row, index)).filter(|other| *other != federate);
        let (mut may_join, mut is_absent) = (false, false);
        for other in upstream {
            may_join |= self.graph.nodes[other].is_transient;
            is_absent |= self.graph.is_absent(other);
        }
        let waits = |horizon: &Horizon, tag: Tag| is_absent && !horizon.has_reached(tag);
        match grant {
            _ if !may_join => Some(grant),
            Grant::Provisional(tag) if waits(&self.horizon, tag) => {
                self.horizon.wait_for(tag);
                None
            }
            Grant::Provisional(_) => Some(grant),
            Grant::Final(tag) if tag != Tag::FOREVER && !waits(&self.horizon, tag) => Some(grant),
            Grant::Final(tag) => {
                let demanded = self.demand(federate).unwrap_or(Tag::NEVER);
                let TagState { granted, provisional, .. } = *self.state(federate);
                let mut best = None;
                for needed in [self.graph.next_event(federate), demanded, provisional] {
                    if needed > tag || needed <= granted || needed < provisional || !needed.is_finite() {
                        continue;
                    }
                    if waits(&self.horizon, needed) {
                        self.horizon.wait_for(needed);
                    } else {
                        best = best.max(Some(needed));
                    }
                }
                best.map(Grant::Final)
            }
        }
    }
}

impl<O: Outlet> Sending<'_, '_, O> {
    /// Returns whether a message with this tag is lost for its destination, because that does not take part then.
    pub(super) fn misses(&self, to: u16, tag: Tag) -> bool {
        let Some(slot) = self.members.slots.get(usize::from(to)) else { return false };
        slot.is_transient() && (self.members.running(to.into()).is_none() || slot.life.misses(tag))
    }

    /// Drops such a message.
    pub(super) fn drop_missed(&mut self, from: usize, to: u16, tag: Tag) {
        self.members.slots[usize::from(to)].life.record(tag);
        let times = self.members.slots[from].tallies.dropped.count();
        self.outlet.log(RtiEvent::Missed { from: id(from), to: to.into(), times });
    }

    /// Returns whether to tell a federate that one directly upstream of it has left, also if that has come back since.
    pub(super) fn has_left(&self, federate: usize, other: u16) -> bool {
        let came = self.members.slots[federate].pending.notices.upstream_came;
        let has_returned = came.is_some_and(|(first, last)| (first..=last).contains(&other));
        self.tags.is_upstream(federate, other.into()) && (has_returned || self.tags.state(other.into()).departed)
    }

    /// Sends a transient federate its effective start, and before it who is upstream of it. Returns false if there is
    /// not room for all of it.
    pub(super) fn send_before_start(&mut self, federate: usize, connection: ConnectionId) -> bool {
        let slot = &self.members.slots[federate];
        if !slot.is_transient() || !slot.pending.start {
            return true;
        }
        if !self.send_arrivals(federate, connection) {
            return false;
        }
        let start = self.tags.start.unwrap_or_default().as_nanos();
        let message = Message::EffectiveStart { start, tag: to_wire(self.members.slots[federate].life.begin) };
        let sent = self.send_with_room(connection, &message);
        self.members.slots[federate].pending.start = !sent;
        sent
    }

    /// Sends a federate what it is to be told because of transient federates. Returns false if there is not room for
    /// all of it.
    pub(super) fn send_notices(&mut self, federate: usize, connection: ConnectionId) -> bool {
        if !self.send_arrivals(federate, connection) {
            return false;
        }
        while let Some((first, last)) = self.members.slots[federate].pending.notices.outbound_left {
            let came = self.members.slots[federate].pending.notices.outbound_came;
            let has_returned = came.is_some_and(|(first_came, last_came)| (first_came..=last_came).contains(&first));
            let is_told = self.members.is_registered(federate, first.into())
                && (has_returned || self.members.running(first.into()).is_none());
            if is_told && !self.send_with_room(connection, &Message::OutboundDisconnected { federate: first }) {
                return false;
            }
            self.members.slots[federate].pending.notices.outbound_left = rest(first, last);
        }
        while let Some((first, last)) = self.members.slots[federate].pending.notices.outbound_came {
            let is_told = self.members.is_registered(federate, first.into())
                && self.members.slots[usize::from(first)].is_transient()
                && self.members.running(first.into()).is_some();
            if is_told && !self.send_with_room(connection, &Message::OutboundConnected { federate: first }) {
                return false;
            }
            self.members.slots[federate].pending.notices.outbound_came = rest(first, last);
        }
        if self.members.slots[federate].pending.notices.stop {
            let sent = self.send_with_room(connection, &Message::Stop);
            self.members.slots[federate].pending.notices.stop = !sent;
            return sent;
        }
        true
    }

    /// Advances the federates downstream of one that has just come, where they wait for a grant: those that have waited
    /// for the clock need not, up to its effective start.
    fn advance_waiting_downstream(&mut self, federate: usize) {
        let row = self.tags.graph.nodes[federate].outgoing;
        for index in 0..row.len {
            let other = self.tags.graph.other_end(row, index);
            if other != federate && self.tags.awaited(other).is_some() {
                self.advance(other);
            }
        }
    }

    /// Sends a federate which transient federates directly upstream of it have come since the last time.
    fn send_arrivals(&mut self, federate: usize, connection: ConnectionId) -> bool {
        while let Some((first, last)) = self.members.slots[federate].pending.notices.upstream_came {
            let is_told = self.members.slots[usize::from(first)].is_transient()
                && self.members.running(first.into()).is_some()
                && self.tags.is_upstream(federate, first.into());
            if is_told && !self.send_with_room(connection, &Message::UpstreamConnected { federate: first }) {
                return false;
            }
            self.members.slots[federate].pending.notices.upstream_came = rest(first, last);
        }
        true
    }

    fn send_with_room(&mut self, connection: ConnectionId, message: &Message<'_>) -> bool {
        let has_room = self.outlet.room(connection) >= message.encoded_len();
        if has_room {
            self.outlet.send(connection, message);
        }
        has_room
    }

    /// Tells those directly downstream of a transient federate, and those who are registered, that it has come or left.
    fn announce(&mut self, other: usize, has_come: bool, stop_tag: Tag) {
        let number = id(other).0;
        for federate in (0..self.members.slots.len()).filter(|federate| *federate != other) {
            if self.members.running(federate).is_none() {
                continue;
            }
            let is_registered = self.members.is_registered(federate, other);
            let is_downstream = self.tags.is_upstream(federate, other);
            let pending = &mut self.members.slots[federate].pending;
            let notices = &mut pending.notices;
            match has_come {
                true if is_downstream => notices.upstream_came = Some(extended(notices.upstream_came, number)),
                false if is_downstream => pending.record_departure(number),
                _ => {}
            }
            let notices = &mut pending.notices;
            match has_come {
                true if is_registered => notices.outbound_came = Some(extended(notices.outbound_came, number)),
                false if is_registered => notices.outbound_left = Some(extended(notices.outbound_left, number)),
                _ => {}
            }
            self.flush(federate, stop_tag);
        }
    }
}

/// Returns what is left of a range without its first id.
fn rest(first: u16, last: u16) -> Option<(u16, u16)> {
    (first < last).then(|| (first + 1, last))
}

impl Rti<'_> {
    /// Begins the federation without those that have not sent their clocks: they are transient, and absent.
    pub(super) fn await_transients(&mut self, start: Instant, outlet: &mut impl Outlet) {
        self.tags.horizon.is_open = self.config.transients() > 0;
        for federate in 0..self.members.slots.len() {
            let slot = &mut self.members.slots[federate];
            let takes_part = matches!(slot.membership, Membership::Joined(_)) && slot.clock.is_some();
            let is_surplus = !takes_part && !slot.is_transient();
            slot.life.is_transient |= !takes_part;
            self.tags.graph.nodes[federate].is_transient = slot.life.is_transient;
            if takes_part {
                slot.life.begin = Tag::at(start);
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
                None => slot.end_life(),
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
    pub(super) fn begin_life(
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
        let begin = self.tags.effective_start(federate, clock, slot.life.past);
        if !self.tags.horizon.is_open || self.stop.granted().is_some() || !begin.is_finite() {
            self.refuse_late(federate, connection, outlet);
            return Ok(());
        }
        barrier::take_clock(slot, now, clock)?;
        slot.life.begin = begin;
        slot.pending.start = true;
        slot.pending.stop_request = self.stop.is_requested();
        outlet.log(RtiEvent::Begins { federate: id(federate), tag: begin });
        self.tags.begin_life(federate, begin);
        self.tags.record_next_event(begin);
        self.rounds.resume();
        for index in 0..self.tags.graph.upstreams(federate) {
            let (from, _) = self.tags.graph.upstream(federate, index);
            let came = &mut self.members.slots[federate].pending.notices.upstream_came;
            *came = Some(extended(*came, id(from).0));
        }
        let stop_tag = self.stop.tag();
        let mut sending = self.sending(outlet);
        sending.announce(federate, true, stop_tag);
        sending.flush(federate, stop_tag);
        sending.advance_waiting_downstream(federate);
        Ok(())
    }

    /// Refuses a federate that comes when nobody can join any more.
    fn refuse_late(&mut self, federate: usize, connection: ConnectionId, outlet: &mut impl Outlet) {
        let code = RejectCode::JoinsTooLate;
        if outlet.room(connection) >= Message::Reject(code).encoded_len() {
            outlet.send(connection, &Message::Reject(code));
        }
        let (federate_id, times) = (Some(id(federate)), self.strangers.rejected.count());
        outlet.log(RtiEvent::Rejected { code, federate: federate_id, federation_id: None, violation: None, times });
        self.close(connection, outlet);
        self.members.slots[federate].end_life();
    }

    /// Handles that a transient federate leaves out of order. The federation has not failed if its connection has just
    /// ended, or if it has not taken part.
    pub(super) fn lose_transient(&mut self, federate: usize, cause: Cause, outlet: &mut impl Outlet) {
        let started = self.tags.start.is_some() && self.members.slots[federate].clock.is_some();
        outlet.log(RtiEvent::Lost { federate: id(federate), cause, started });
        if started && !matches!(cause, Cause::ConnectionLost | Cause::NoStopReply) {
            self.end.loss = self.end.loss.or(Some((id(federate), cause)));
        }
        self.depart(federate, outlet);
    }

    /// Handles that a transient federate has left the running federation.
    pub(super) fn depart_transient(&mut self, federate: usize, outlet: &mut impl Outlet) {
        let took_part = self.members.slots[federate].clock.is_some();
        self.members.slots[federate].end_life();
        self.members.forget_registrations(federate);
        if took_part {
            self.members.slots[federate].life.record(self.tags.state(federate).completed);
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

    /// Tells the federate whose place the one on this connection takes to stop, once that has completed its handshake.
    pub(super) fn replace(&mut self, connection: ConnectionId, outlet: &mut impl Outlet) {
        if let Some(federate) = self.replaced_by(connection) {
            outlet.log(RtiEvent::Replaced(id(federate)));
            self.members.slots[federate].pending.notices.stop = true;
            let stop_tag = self.stop.tag();
            self.sending(outlet).flush(federate, stop_tag);
        }
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
