// SPDX-License-Identifier: Apache-2.0
//! How federates leave, in order or not.
//!
//! Before the start, the id of whoever leaves is free again. After it, a federate that has left sends no more messages,
//! whyever it left: the others go on without it at once.

use lf_model::time::{Instant, Tag};
use lf_wire::{ADDRESS_PORT_UNKNOWN, Message};

use super::storage::{Membership, Phase};
use super::{AfterLoss, Cause, ConnectionId, Notice, Outlet, Rti, Slot, id};
use crate::Tally;

impl Rti<'_> {
    /// Nothing more will come on a connection. What has come and is not consumed is to be offered as before, since it
    /// was said while its sender was there; then [`handle_disconnect`](Self::handle_disconnect) is due.
    pub fn handle_end(&mut self, connection: ConnectionId) {
        if let Some(known) = self.connections.get_mut(connection.0) {
            known.ended = known.phase != Phase::Vacant;
        }
    }

    /// A connection has ended, and all that came on it and is whole has been consumed.
    pub fn handle_disconnect(&mut self, now: Instant, connection: ConnectionId, outlet: &mut impl Outlet) {
        if let Some(federate) = self.joined_on(connection) {
            self.release(connection);
            self.lose(federate, Cause::ConnectionLost, outlet);
            self.limit_start(now);
            return;
        }
        let Some(known) = self.connections.get(connection.0) else { return };
        if !matches!(known.phase, Phase::Vacant | Phase::Draining) {
            let federate = known.federate.map(crate::FederateId);
            let times = self.strangers.abandoned.count();
            outlet.notice(Notice::HandshakeAbandoned { federate, timed_out: false, times });
        }
        self.release(connection);
        self.limit_start(now);
    }

    /// Ends the federation: tells every federate that it has failed, and closes all connections.
    pub fn abort(&mut self, outlet: &mut impl Outlet) {
        self.aborted = true;
        for federate in 0..self.slots.len() {
            self.sum_up(federate, outlet);
        }
        for index in 0..self.connections.len() {
            let connection = ConnectionId(index);
            if self.connections[index].phase == Phase::Vacant {
                continue;
            }
            if self.joined_on(connection).is_some() {
                say_failed(connection, outlet);
            }
            outlet.close(connection);
            self.release(connection);
        }
        self.slots.fill(Slot { membership: Membership::Departed, ..Slot::default() });
    }

    /// A connection has been silent for too long.
    pub(super) fn lose_patience(&mut self, connection: ConnectionId, outlet: &mut impl Outlet) {
        let known = self.connections[connection.0];
        if let Some(federate) = self.joined_on(connection) {
            return self.expel(federate, Cause::NoClock, outlet);
        }
        if known.phase != Phase::Draining {
            let federate = known.federate.map(crate::FederateId);
            let times = self.strangers.abandoned.count();
            outlet.notice(Notice::HandshakeAbandoned { federate, timed_out: true, times });
        }
        outlet.close(connection);
        self.release(connection);
    }

    /// There is no memory for a message of so many bytes that came on a connection or was to go there. Its federate
    /// cannot go on without it.
    pub fn handle_no_memory(&mut self, connection: ConnectionId, bytes: usize, outlet: &mut impl Outlet) {
        if let Some(federate) = self.joined_on(connection) {
            return self.expel(federate, Cause::NoMemory { bytes }, outlet);
        }
        if self.connections.get(connection.0).is_some_and(|known| known.phase != Phase::Vacant) {
            self.lose_patience(connection, outlet);
        }
    }

    /// A federate leaves in order. Its connection is kept until it has read all and closes it.
    pub(super) fn on_resign(&mut self, now: Instant, federate: usize, outlet: &mut impl Outlet) {
        let Some(connection) = self.connection_of(federate) else { return };
        self.connections[connection.0].phase = Phase::Draining;
        self.set_deadline(connection, Some(now + self.config.connection_time_out));
        outlet.half_close(connection);
        outlet.notice(Notice::Resigned(id(federate)));
        self.depart(federate, outlet);
    }

    /// A federate says that it has failed.
    pub(super) fn on_failed(&mut self, federate: usize, outlet: &mut impl Outlet) {
        let Some(connection) = self.connection_of(federate) else { return };
        outlet.close(connection);
        self.release(connection);
        self.lose(federate, Cause::Failed, outlet);
    }

    /// The RTI cannot go on with a federate, and tells it so.
    pub(super) fn expel(&mut self, federate: usize, cause: Cause, outlet: &mut impl Outlet) {
        let Some(connection) = self.connection_of(federate) else { return };
        say_failed(connection, outlet);
        outlet.close(connection);
        self.release(connection);
        self.lose(federate, cause, outlet);
    }

    fn lose(&mut self, federate: usize, cause: Cause, outlet: &mut impl Outlet) {
        let started = self.start.is_some();
        outlet.notice(Notice::Lost { federate: id(federate), cause, started });
        if started {
            self.loss = self.loss.or(Some((id(federate), cause)));
        }
        if started && self.config.after_loss == AfterLoss::StopAll {
            // Without what its departure would allow the others: they could take it for an end in order.
            self.abort(outlet);
        } else {
            self.depart(federate, outlet);
        }
    }

    /// Tells how often a federate that says no more did what has been told now and then.
    fn sum_up(&mut self, federate: usize, outlet: &mut impl Outlet) {
        let Tallies { unknown, late, dropped } = core::mem::take(&mut self.slots[federate].tallies);
        let [unknown, late, dropped] = [unknown, late, dropped].map(Tally::times);
        if [unknown, late, dropped].iter().any(|times| times.0 > 1) {
            outlet.notice(Notice::Sum { federate: id(federate), unknown, late, dropped });
        }
    }

    fn depart(&mut self, federate: usize, outlet: &mut impl Outlet) {
        self.sum_up(federate, outlet);
        if self.start.is_none() {
            self.vacate(federate);
            return;
        }
        let slot = &mut self.slots[federate];
        slot.membership = Membership::Departed;
        slot.address = [0; 4];
        slot.port = ADDRESS_PORT_UNKNOWN;
        self.graph.set_next_event(federate, Tag::FOREVER);
        self.graph.cut_off(federate);
        self.advance_downstream(federate, outlet);
        self.grant_stop_if_agreed(outlet);
        self.note_idleness(Tag::FOREVER);
    }
}

/// How often a federate did what is told now and then.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Tallies {
    /// Bytes that begin no message.
    pub(super) unknown: Tally,
    /// Messages that came too late.
    pub(super) late: Tally,
    /// Messages for federates that have left.
    pub(super) dropped: Tally,
}

impl Tallies {
    pub(super) const NOTHING: Self = Self { unknown: Tally::NOTHING, late: Tally::NOTHING, dropped: Tally::NOTHING };
}

/// Tells a peer that it cannot go on. A peer that does not read will learn it from the end of the connection.
fn say_failed(connection: ConnectionId, outlet: &mut impl Outlet) {
    if outlet.room(connection) >= Message::Failed.encoded_len() {
        outlet.send(connection, &Message::Failed);
    }
}
