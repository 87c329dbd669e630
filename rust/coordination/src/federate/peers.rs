// SPDX-License-Identifier: Apache-2.0
//! Before the start: where the federates are to which this one sends directly, one after the other.
//!
//! The RTI is asked for an address until it knows one, because that federate may come later; then the owner connects.
//! Only when all connections are there the RTI is told the time, so none can be missing at the start.

use core::net::{Ipv4Addr, SocketAddrV4};

use lf_model::time::{Instant, Interval};

use super::config::{CONNECT_RETRY, CONNECT_TIME_OUT};
use super::error::FederateError;
use super::event::Event;
use super::machine::Federate;
use super::phase::Phase;
use crate::{Deadline, FederateId};

/// How long after the RTI did not know an address it is asked again.
pub const ADDRESS_RETRY: Interval = Interval::from_millis(250);

/// How far the connections to other federates are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Meeting {
    /// How many of them are there.
    done: usize,
    /// When to give the next one up, once its address is known.
    give_up: Option<Instant>,
    /// The RTI owes an address.
    asked: bool,
}

impl Federate<'_> {
    /// The federate to which a connection is to be made next.
    fn next_peer(&self) -> Option<FederateId> {
        self.config.peers.get(self.meeting.done).copied().map(FederateId)
    }

    /// The place of the federate to which a connection is to be made next, among those to which this one sends.
    pub fn next_peer_index(&self) -> Option<usize> {
        (self.meeting.done < self.config.peers.len()).then_some(self.meeting.done)
    }

    /// Asks for the next address, or goes on to the start barrier when all connections are there.
    pub(super) fn meet(&mut self, now: Instant) {
        self.patience = Deadline::Never;
        let next = self.next_peer();
        if next.is_some() {
            self.phase = Phase::Meeting;
            self.meeting.asked = true;
            self.outbox.address_query = next;
        } else {
            self.phase = Phase::Starting;
            self.outbox.timestamp = Some(self.clock.physical(now));
        }
    }

    /// The RTI's answer to the last question; `port` is negative as long as it knows none.
    pub(super) fn handle_address(&mut self, now: Instant, port: i32, address: [u8; 4]) -> Event<'static> {
        let Some(federate) = self.next_peer().filter(|_| self.meeting.asked) else { return Event::None };
        self.meeting.asked = false;
        let Some(port) = u16::try_from(port).ok().filter(|port| *port != 0) else {
            self.patience = Deadline::At(now + ADDRESS_RETRY);
            return Event::None;
        };
        self.meeting.give_up.get_or_insert(now + CONNECT_TIME_OUT);
        Event::PeerFound { federate, address: SocketAddrV4::new(Ipv4Addr::from(address), port) }
    }

    /// The federate of the last [`Event::PeerFound`] takes this one's messages.
    pub fn peer_connected(&mut self, now: Instant) {
        if self.phase == Phase::Meeting {
            self.meeting.done += 1;
            self.meeting.give_up = None;
            self.meet(now);
        }
    }

    /// The connection that [`Event::PeerFound`] asked for could not be made, or ended before it was accepted. Its
    /// address is asked for again after a while, for it may be another one.
    ///
    /// # Errors
    /// When the time for it is over.
    pub fn peer_lost(&mut self, now: Instant) -> Result<(), FederateError> {
        let Some(federate) = self.next_peer().filter(|_| self.phase == Phase::Meeting) else { return Ok(()) };
        if self.meeting.give_up.is_some_and(|give_up| give_up <= now) {
            return self.refuse(FederateError::PeerUnreachable { federate });
        }
        self.patience = Deadline::At(now + CONNECT_RETRY);
        Ok(())
    }
}
