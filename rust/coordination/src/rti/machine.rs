// SPDX-License-Identifier: Apache-2.0
//! An RTI as a whole: receives the calls of its owner and passes them to the parts. Departures of federates concern all
//! parts, so they are handled here.
//!
//! Each part has a state of its own; a part that needs another one receives it as an argument. `input` handles the
//! messages of federates, `timing` the deadlines.
//!
//! Federates leave in order or not. Before the start, the id of a federate that leaves is free again. After it, a
//! federate that has left sends no more messages, for whatever reason it left: the others go on without it at once.

use lf_derive::outlined;
use lf_model::time::{Instant, Tag};
use lf_wire::{ADDRESS_PORT_UNKNOWN, Limits, Message, message_bytes_max};

#[cfg(feature = "transients")]
use super::admission::Admission;
use super::barrier::{self, Barrier};
use super::clock_sync::Rounds;
use super::config::{AfterLoss, Config, SetupError};
use super::exchange::Exchanges;
use super::graph::Graph;
use super::handshake::Handshake;
use super::log_event::{Cause, RtiEvent, Violation};
use super::members::Members;
use super::outcome::{End, Status};
use super::outlet::{ConnectionId, Outlet, Verdict};
use super::sending::Sending;
use super::stop::Stop;
use super::storage::{Connection, Membership, Phase, RtiStorage, Slot, Tallies, id};
use super::strangers::{self, Strangers};
use super::tags::Tags;
use super::watch::Watch;
use crate::auth::Nonce;
use crate::{FederateId, IpAddress, Tally};

/// The RTI of one federation.
pub struct Rti<'s> {
    pub(super) config: Config<'s>,
    pub(super) limits: Limits,
    pub(super) members: Members<'s>,
    pub(super) tags: Tags<'s>,
    pub(super) stop: Stop,
    pub(super) barrier: Barrier,
    pub(super) exchanges: Exchanges,
    pub(super) rounds: Rounds,
    pub(super) strangers: Strangers,
    pub(super) watch: Watch,
    pub(super) end: End,
    /// The number of tags with messages before a receiver at which those of senders that are further are held.
    pub(super) window: u16,
}

impl<'s> Rti<'s> {
    /// Returns an RTI for as many federates as the storage has slots.
    ///
    /// # Errors
    /// The error of the configuration or of the storage, in a sentence.
    pub fn new(config: Config<'s>, storage: RtiStorage<'s>) -> Result<Self, SetupError> {
        config.check()?;
        storage.check()?;
        let RtiStorage { slots, nodes, connections, paths, upstream, in_transit, .. } = storage;
        let count = slots.len();
        #[cfg(feature = "transients")]
        let registrations = config.check_transients(count, storage.registrations)?;
        slots.fill(Slot::default());
        connections.fill(Connection::default());
        let members = Members::new(slots, connections);
        #[cfg(feature = "transients")]
        let members = members.with_registrations(registrations);
        // Storage may be larger than needed; the graph relies on the number of nodes.
        let graph = Graph::new(&mut nodes[..count], upstream, paths, config.dnet);
        Ok(Self {
            limits: config.limits(count),
            config,
            members,
            tags: Tags::new(graph, in_transit),
            stop: Stop::default(),
            barrier: Barrier::default(),
            exchanges: Exchanges::default(),
            rounds: Rounds::default(),
            strangers: Strangers::default(),
            watch: Watch::default(),
            end: End::default(),
            window: config.window,
        })
    }

    /// Returns whether the federation is over, and how it ended.
    #[outlined]
    pub fn status(&self) -> Status {
        self.end.status(self.members.all_departed(), self.barrier.outcome())
    }

    /// Returns the start time, once all federates but the transient ones have joined and sent their clocks.
    pub fn start_time(&self) -> Option<Instant> {
        self.tags.start
    }

    /// Returns the tag at which all stop, once they have agreed on it.
    #[outlined]
    pub fn stop_tag(&self) -> Option<Tag> {
        self.stop.granted()
    }

    /// Returns the length of the longest message that is accepted: the buffers of every connection have to hold it, for
    /// input and for output.
    pub fn message_bytes_max(&self) -> usize {
        message_bytes_max(&self.limits)
    }

    /// Returns the federate that has joined over this connection and is still there.
    pub fn federate_on(&self, connection: ConnectionId) -> Option<FederateId> {
        self.members.joined_on(connection).map(id)
    }

    /// Handles a new connection of a peer with this address. A number beyond the storage, or one that is in use, is
    /// closed.
    ///
    /// With [`Config::authentication`], `nonce` has to be unpredictable and new for each connection; otherwise it is
    /// not used.
    pub fn handle_connect(
        &mut self,
        now: Instant,
        connection: ConnectionId,
        address: IpAddress,
        nonce: Nonce,
        outlet: &mut impl Outlet,
    ) {
        if self.end.aborted || !self.handshake().begin(now, connection, address, nonce) {
            outlet.close(connection);
        }
    }

    /// Closes the connection that makes way for a new one when all are in use: the oldest one that has not sent an id.
    /// Ignore what its peer still sends. Returns `None` if there is no such connection.
    ///
    /// Looks at every connection once.
    pub fn evict(&mut self, outlet: &mut impl Outlet) -> Option<ConnectionId> {
        let connection = strangers::oldest(&self.members)?;
        outlet.log(RtiEvent::Evicted(self.strangers.evicted.count()));
        self.close(connection, outlet);
        Some(connection)
    }

    /// Returns whether [`evict`](Self::evict) finds a connection.
    pub fn can_evict(&self) -> bool {
        strangers::oldest(&self.members).is_some()
    }

    /// Handles the input of a connection in its handshake.
    pub(super) fn handle_handshake(
        &mut self,
        now: Instant,
        connection: ConnectionId,
        bytes: &[u8],
        outlet: &mut impl Outlet,
    ) -> Verdict {
        let verdict = self.handshake().handle_input(now, connection, bytes, outlet);
        if verdict == Verdict::Closed {
            self.close(connection, outlet);
        }
        #[cfg(feature = "transients")]
        self.replace(connection, outlet);
        verdict
    }

    fn handshake(&mut self) -> Handshake<'_, 's> {
        #[cfg(feature = "transients")]
        let admission = Admission::of(&self.config, &self.tags, &self.stop);
        Handshake {
            config: &self.config,
            limits: &self.limits,
            members: &mut self.members,
            graph: &mut self.tags.graph,
            exchanges: &mut self.exchanges,
            strangers: &mut self.strangers,
            barrier: &mut self.barrier,
            #[cfg(feature = "transients")]
            admission,
        }
    }

    /// Records the time of the RTI's clock: some grants wait for it while transient federates are absent.
    pub(super) fn set_now(&mut self, now: Instant) {
        #[cfg(feature = "transients")]
        self.tags.horizon.set_now(now);
        #[cfg(not(feature = "transients"))]
        let _ = now;
    }

    pub(super) fn sending<'r, O>(&'r mut self, outlet: &'r mut O) -> Sending<'r, 's, O> {
        Sending { members: &mut self.members, tags: &mut self.tags, outlet }
    }

    /// Handles that there is more room on a connection. Sends what was put off for its federate.
    pub fn handle_writable(&mut self, now: Instant, connection: ConnectionId, outlet: &mut impl Outlet) {
        self.set_now(now);
        self.exchanges.retry(&mut self.members, connection);
        if let Some(federate) = self.members.joined_on(connection) {
            let stop_tag = self.stop.tag();
            self.sending(outlet).flush(federate, stop_tag);
        }
    }

    /// Handles a federate's clock. When all federates have sent theirs, the federation starts.
    pub(super) fn take_clock(
        &mut self,
        now: Instant,
        federate: usize,
        clock: Instant,
        outlet: &mut impl Outlet,
    ) -> Result<(), Violation> {
        barrier::take_clock(&mut self.members.slots[federate], now, clock)?;
        let optional = self.config.transients();
        let Some(latest) = barrier::latest_clock(self.members.slots, optional) else { return Ok(()) };
        let start = barrier::start_time(latest, self.config.start_time_multiple);
        #[cfg(feature = "transients")]
        self.await_transients(start, outlet);
        self.watch = Watch::default();
        self.tags.begin(start);
        outlet.log(RtiEvent::Started(start));
        if let Some((ahead, violation)) = barrier::check_clocks(self.members.slots) {
            self.members.report_suspected(ahead, violation, outlet);
        }
        let stop_tag = self.stop.tag();
        self.sending(outlet).broadcast(stop_tag, |_| true, |pending| pending.start = true);
        #[cfg(feature = "transients")]
        self.announce_first(outlet);
        Ok(())
    }

    /// Sets the time within which those that have left before the start may come back. Call it after everything that
    /// can make a federate leave.
    pub(super) fn limit_start(&mut self, now: Instant) {
        let waits = self.tags.start.is_none() && !self.end.aborted;
        self.barrier.limit(self.config.start_barrier_time_out.filter(|_| waits).map(|time_out| now + time_out));
    }

    /// Handles that nothing more will come on a connection. Offer the bytes that have come and are not consumed as
    /// before, since they were sent while the sender was there; then call
    /// [`handle_disconnect`](Self::handle_disconnect).
    pub fn handle_end(&mut self, connection: ConnectionId) {
        if let Some(known) = self.members.connections.get_mut(connection.0) {
            known.ended = known.phase != Phase::Vacant;
        }
    }

    /// Handles the end of a connection whose complete messages have all been consumed.
    pub fn handle_disconnect(&mut self, now: Instant, connection: ConnectionId, outlet: &mut impl Outlet) {
        self.set_now(now);
        if let Some(federate) = self.members.joined_on(connection) {
            self.release(connection);
            self.lose(federate, Cause::ConnectionLost, outlet);
        } else {
            self.log_abandoned(connection, false, outlet);
            self.release(connection);
        }
        self.limit_start(now);
    }

    /// Ends the federation: sends every federate FAILED, and closes all connections.
    pub fn abort(&mut self, outlet: &mut impl Outlet) {
        self.end.aborted = true;
        for federate in 0..self.members.slots.len() {
            self.sum_up(federate, outlet);
        }
        for index in 0..self.members.connections.len() {
            let connection = ConnectionId(index);
            if self.members.phase(connection) == Phase::Vacant {
                continue;
            }
            if self.members.joined_on(connection).is_some() {
                send_failed(connection, outlet);
            }
            self.close(connection, outlet);
        }
        self.members.slots.fill(Slot { membership: Membership::Departed, ..Slot::default() });
        self.tags.depart_all();
    }

    /// Handles that there is no memory for a message of this many bytes that came on a connection or was to go there.
    /// Its federate cannot go on without it.
    pub fn handle_no_memory(&mut self, connection: ConnectionId, bytes: usize, outlet: &mut impl Outlet) {
        if let Some(federate) = self.members.joined_on(connection) {
            self.expel(federate, Cause::NoMemory { bytes }, outlet);
        } else if self.members.phase(connection) != Phase::Vacant {
            self.time_out(connection, outlet);
        }
    }

    /// Handles that a connection has been silent for too long.
    pub(super) fn time_out(&mut self, connection: ConnectionId, outlet: &mut impl Outlet) {
        if let Some(federate) = self.members.joined_on(connection) {
            return self.expel(federate, Cause::NoClock, outlet);
        }
        #[cfg(feature = "transients")]
        if let Some(replaced) = self.replaced_by(connection) {
            return self.expel(replaced, Cause::NoStopReply, outlet);
        }
        self.log_abandoned(connection, true, outlet);
        self.close(connection, outlet);
    }

    /// Logs that a connection ends before its handshake is complete, if that is so.
    fn log_abandoned(&mut self, connection: ConnectionId, timed_out: bool, outlet: &mut impl Outlet) {
        if !matches!(self.members.phase(connection), Phase::Vacant | Phase::Draining) {
            let federate = self.members.connections[connection.0].federate.map(FederateId);
            let times = self.strangers.abandoned.count();
            outlet.log(RtiEvent::HandshakeAbandoned { federate, timed_out, times });
        }
    }

    pub(super) fn close(&mut self, connection: ConnectionId, outlet: &mut impl Outlet) {
        outlet.close(connection);
        self.release(connection);
    }

    /// Releases a connection. Its id is free if it had not completed its handshake.
    fn release(&mut self, connection: ConnectionId) {
        if connection.0 >= self.members.connections.len() {
            return;
        }
        self.exchanges.leave(&self.members, connection);
        if let Some(federate) = self.members.release(connection) {
            #[cfg(feature = "transients")]
            if self.tags.start.is_some() {
                return self.members.slots[federate].end_incarnation();
            }
            self.barrier.vacate(&mut self.members.slots[federate]);
        }
    }

    /// Handles that a federate leaves in order. Its connection is kept until it has read everything and closes it.
    pub(super) fn resign(&mut self, now: Instant, federate: usize, outlet: &mut impl Outlet) {
        let Some(connection) = self.members.connection_of(federate) else { return };
        self.members.connections[connection.0].phase = Phase::Draining;
        self.members.set_deadline(connection, Some(now + self.config.connection_time_out));
        outlet.half_close(connection);
        outlet.log(RtiEvent::Resigned(id(federate)));
        self.depart(federate, outlet);
    }

    /// Expels a federate that the RTI cannot go on with, and sends it FAILED unless it has sent that itself.
    pub(super) fn expel(&mut self, federate: usize, cause: Cause, outlet: &mut impl Outlet) {
        let Some(connection) = self.members.connection_of(federate) else { return };
        if cause != Cause::Failed {
            send_failed(connection, outlet);
        }
        self.close(connection, outlet);
        self.lose(federate, cause, outlet);
    }

    fn lose(&mut self, federate: usize, cause: Cause, outlet: &mut impl Outlet) {
        #[cfg(feature = "transients")]
        if self.members.slots[federate].is_transient() {
            return self.lose_transient(federate, cause, outlet);
        }
        let started = self.tags.start.is_some();
        outlet.log(RtiEvent::Lost { federate: id(federate), cause, started });
        if started {
            self.end.loss = self.end.loss.or(Some((id(federate), cause)));
        }
        if started && self.config.after_loss == AfterLoss::StopAll {
            // The others must not learn what its departure would allow: they could take it for an end in order.
            self.abort(outlet);
        } else {
            self.depart(federate, outlet);
        }
    }

    /// Logs the totals of a federate that sends no more, for events that are logged only now and then.
    fn sum_up(&mut self, federate: usize, outlet: &mut impl Outlet) {
        let Tallies { unknown, late, dropped } = core::mem::take(&mut self.members.slots[federate].tallies);
        let [unknown, late, dropped] = [unknown, late, dropped].map(Tally::times);
        if [unknown, late, dropped].iter().any(|times| times.0 > 1) {
            outlet.log(RtiEvent::Sum { federate: id(federate), unknown, late, dropped });
        }
    }

    pub(super) fn depart(&mut self, federate: usize, outlet: &mut impl Outlet) {
        self.sum_up(federate, outlet);
        #[cfg(feature = "transients")]
        if self.tags.start.is_some() && self.members.slots[federate].is_transient() {
            return self.depart_transient(federate, outlet);
        }
        let slot = &mut self.members.slots[federate];
        if self.tags.start.is_none() {
            self.barrier.vacate(slot);
            return;
        }
        slot.membership = Membership::Departed;
        slot.address = IpAddress::UNSPECIFIED;
        slot.port = ADDRESS_PORT_UNKNOWN;
        let is_awaited = self.tags.depart(federate);
        let stop_tag = self.stop.tag();
        let mut sending = Sending { members: &mut self.members, tags: &mut self.tags, outlet };
        if is_awaited {
            sending.announce_departure(federate, stop_tag);
        }
        sending.advance_downstream(federate);
        self.stop.grant_if_agreed(&mut sending);
        self.tags.record_next_event(Tag::FOREVER);
        #[cfg(feature = "transients")]
        self.expect_nobody_if_alone(outlet);
    }
}

/// Sends FAILED to a peer. A peer that does not read will learn it from the end of the connection.
fn send_failed(connection: ConnectionId, outlet: &mut impl Outlet) {
    if outlet.room(connection) >= Message::Failed.encoded_len() {
        outlet.send(connection, &Message::Failed);
    }
}
