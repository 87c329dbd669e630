// SPDX-License-Identifier: Apache-2.0
//! The deadlines of an RTI: time-outs, reports of waits, and clock synchronization.

use lf_derive::outlined;
use lf_model::time::{Instant, Interval};

use super::clock_sync::Datagram;
use super::config::ClockSync;
use super::log_event::Cause;
use super::machine::Rti;
use super::outlet::{ConnectionId, Outlet};
use super::storage::id;
use crate::{Deadline, Endpoint, FederateId};

impl Rti<'_> {
    /// Returns the time of the first announced event of the federates that are there: then they are likely to send
    /// something. Looks at every federate once.
    pub fn next_event_after(&self, now: Instant) -> Deadline {
        self.tags.next_event_after(now)
    }

    /// Returns the time at which to call [`handle_timeout`](Self::handle_timeout).
    pub fn poll_timeout(&self) -> Deadline {
        let ends = self.members.earliest_deadline().min(self.tags.idle.deadline());
        let ends = ends.min(self.stop.deadline().into()).min(self.barrier.deadline().into());
        #[cfg(feature = "transients")]
        let ends = ends.min(self.tags.horizon.deadline());
        ends.min(self.watch_deadline())
    }

    /// Abandons connections that have been silent for too long, federates that do not answer a stop request, and a
    /// start whose missing federates have not come in time. Looks at every connection and every federate once.
    #[outlined]
    pub fn handle_timeout(&mut self, now: Instant, outlet: &mut impl Outlet) {
        self.set_now(now);
        if self.members.earliest_deadline().is_due(now) {
            for index in 0..self.members.connections.len() {
                if self.members.connections[index].deadline.is_some_and(|deadline| deadline <= now) {
                    self.time_out(ConnectionId(index), outlet);
                }
            }
        }
        if self.stop.deadline().is_some_and(|deadline| deadline <= now) {
            // Without them the stop is granted.
            for federate in 0..self.members.slots.len() {
                if self.members.running(federate).is_some() && !self.members.slots[federate].stop_agreed {
                    self.expel(federate, Cause::NoStopReply, outlet);
                }
            }
        }
        if self.barrier.deadline().is_some_and(|deadline| deadline <= now) {
            self.barrier.give_up(self.members.slots, outlet);
            self.abort(outlet);
        }
        self.limit_start(now);
        #[cfg(feature = "transients")]
        if self.tags.horizon.take_due() {
            self.advance_all(outlet);
        }
        if self.watch_deadline().is_due(now) {
            self.check(now, outlet);
        }
        if self.tags.idle.deadline().is_due(now) && self.tags.handle_idleness(now) {
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

    /// Looks for federates that have been waiting for too long, and logs them.
    fn check(&mut self, now: Instant, outlet: &mut impl Outlet) {
        let Some(interval) = self.watch_interval() else { return };
        if self.tags.start.is_some() {
            self.watch.check(now, interval, &mut self.members, &self.tags, &self.stop, outlet);
        } else {
            self.watch.check_start(now, interval, &self.members, outlet);
        }
    }

    /// Returns the time at which [`poll_exchange`](Self::poll_exchange) has something to send.
    pub fn poll_exchange_timeout(&self) -> Deadline {
        self.exchanges.poll_timeout()
    }

    /// Sends a T1 with `now`, if one is due and there is room for it, and returns its connection: write that at once.
    ///
    /// Looks at each connection at most once.
    pub fn poll_exchange(&mut self, now: Instant, outlet: &mut impl Outlet) -> Option<ConnectionId> {
        self.exchanges.poll(now, self.config.connection_time_out, &mut self.members, outlet)
    }

    /// Returns the connection whose exchanges are open. Read it before anything else, and write it at once.
    pub fn exchanging(&self) -> Option<ConnectionId> {
        self.exchanges.current()
    }

    /// Returns the time at which [`poll_round`](Self::poll_round) has something to send.
    pub fn poll_round_timeout(&self) -> Deadline {
        match (self.config.clock_sync, self.tags.start) {
            (ClockSync::On { .. }, Some(start)) => self.rounds.poll_timeout(start),
            _ => Deadline::Never,
        }
    }

    /// Returns the T1 with the time `now`, if one is due: send it at once. At most one; looks at every federate at most
    /// once.
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

    /// Handles a datagram; `now` is the time right after it was read. If it is an expected T3, returns T4. Send it at
    /// once, and behind it [`Datagram::coded_probe`] with the time right before that is sent.
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
