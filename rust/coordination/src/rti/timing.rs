// SPDX-License-Identifier: Apache-2.0
//! What an RTI does at its time: it gives up, tells who waits, and tells its clock.

use lf_model::time::{Instant, Interval};

use super::clock_sync::Datagram;
use super::config::ClockSync;
use super::machine::Rti;
use super::notice::Cause;
use super::outlet::{ConnectionId, Outlet};
use super::storage::id;
use crate::{Deadline, Endpoint, FederateId};

impl Rti<'_> {
    /// When the first of the federates that are there will have an event, as far as they have said: then they are
    /// likely to say something. Looks at every federate once.
    pub fn next_event_after(&self, now: Instant) -> Deadline {
        self.tags.next_event_after(now)
    }

    /// When [`handle_timeout`](Self::handle_timeout) is to be called.
    pub fn poll_timeout(&self) -> Deadline {
        let ends = self.members.patience().min(self.tags.idle.deadline());
        let ends = ends.min(self.stop.deadline().into()).min(self.barrier.deadline().into());
        ends.min(self.watch_deadline())
    }

    /// Gives up on connections that have been silent for too long, on federates that do not answer a stop request, and
    /// on a start for which some have been missing for too long.
    /// Looks at every connection and every federate once.
    #[cfg_attr(target_pointer_width = "32", inline(never))]
    pub fn handle_timeout(&mut self, now: Instant, outlet: &mut impl Outlet) {
        if self.members.patience().is_due(now) {
            for index in 0..self.members.connections.len() {
                if self.members.connections[index].deadline.is_some_and(|deadline| deadline <= now) {
                    self.lose_patience(ConnectionId(index), outlet);
                }
            }
        }
        if self.stop.deadline().is_some_and(|deadline| deadline <= now) {
            self.stop.give_up();
            for federate in 0..self.members.slots.len() {
                if !self.members.slots[federate].stop_agreed {
                    self.expel(federate, Cause::NoStopReply, outlet);
                }
            }
        }
        if self.barrier.deadline().is_some_and(|deadline| deadline <= now) {
            self.barrier.give_up(self.members.slots, outlet);
            self.abort(outlet);
        }
        self.limit_start(now);
        if self.watch_deadline().is_due(now) {
            self.look(now, outlet);
        }
        if self.tags.idle.deadline().is_due(now) && self.tags.tell_idleness(now) {
            for federate in 0..self.members.slots.len() {
                self.sending(outlet).advance(federate);
            }
        }
    }

    fn watch_deadline(&self) -> Deadline {
        if self.watch_interval().is_some() { self.watch.deadline() } else { Deadline::Never }
    }

    fn watch_interval(&self) -> Option<Interval> {
        if self.end.aborted || self.stop.granted().is_some() {
            return None;
        }
        if self.tags.start.is_none() { self.config.start_report } else { self.config.log_waits }
    }

    /// Looks who is waited for, and says it where that has lasted.
    fn look(&mut self, now: Instant, outlet: &mut impl Outlet) {
        let Some(interval) = self.watch_interval() else { return };
        if self.tags.start.is_some() {
            self.watch.look(now, interval, &mut self.members, &self.tags, &self.stop, outlet);
        } else {
            self.watch.look_at_start(now, interval, &self.members, outlet);
        }
    }

    /// When [`poll_exchange`](Self::poll_exchange) has something to send.
    pub fn poll_exchange_timeout(&self) -> Deadline {
        self.exchanges.poll_timeout()
    }

    /// Sends a T1 that tells `now`, if one is due and there is room for it, and gives its connection: write that at
    /// once.
    ///
    /// Looks at each connection at most once.
    pub fn poll_exchange(&mut self, now: Instant, outlet: &mut impl Outlet) -> Option<ConnectionId> {
        self.exchanges.poll(now, self.config.connection_time_out, &mut self.members, outlet)
    }

    /// The connection whose exchanges are under way. What comes on it is to be read before anything else, and what is
    /// sent on it to be written at once.
    pub fn exchanging(&self) -> Option<ConnectionId> {
        self.exchanges.current()
    }

    /// When [`poll_round`](Self::poll_round) has something to send.
    pub fn poll_round_timeout(&self) -> Deadline {
        match (self.config.clock_sync, self.tags.start) {
            (ClockSync::On { .. }, Some(start)) => self.rounds.poll_timeout(start),
            _ => Deadline::Never,
        }
    }

    /// The T1 that is to be sent at `now`, which is the time that it tells: send it at once. At most one; looks at
    /// every federate at most once.
    pub fn poll_round(&mut self, now: Instant) -> Option<Datagram> {
        let ClockSync::On { period, .. } = self.config.clock_sync else { return None };
        if !self.poll_round_timeout().is_due(now) {
            return None;
        }
        self.rounds.poll(now, period, self.members.slots)
    }

    /// Returns the federate that has this address for clock synchronization, for people.
    pub fn federate_at(&self, address: Endpoint) -> Option<FederateId> {
        self.members.slots.iter().position(|slot| Endpoint::new(slot.address, slot.udp_port) == address).map(id)
    }

    /// A datagram has come; `now` is the time right after it was read. If it is a T3 that is awaited, gives T4, which
    /// is to be sent at once, and behind it [`Datagram::coded_probe`] with the time right before that is sent.
    pub fn handle_datagram(
        &mut self,
        now: Instant,
        from: Endpoint,
        datagram: &[u8],
        outlet: &mut impl Outlet,
    ) -> Option<Datagram> {
        self.rounds.handle_datagram(now, from, datagram, self.members.slots, outlet)
    }
}
