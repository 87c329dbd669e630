// SPDX-License-Identifier: Apache-2.0
//! Before the start: where the federates are to which this one sends directly, one after the other.
//!
//! The RTI is asked for an address until it knows one, because that federate may come later; then the owner connects.
//! Only when all connections are there the RTI is told the time, so none can be missing at the start.

use lf_model::time::{Instant, Interval};

use super::config::{CONNECT_RETRY, CONNECT_TIME_OUT};
use crate::{Endpoint, FederateId, IpAddress};

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

/// What an address that the RTI has told leads to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Address {
    /// Nothing: it was not asked for.
    Unasked,
    /// To be asked for again at this time.
    AskAgain(Instant),
    /// This federate is to be connected to.
    Found(FederateId, Endpoint),
}

impl Meeting {
    /// The place of the federate to which a connection is to be made next, among those to which this one sends.
    pub(super) fn next_index(&self, peers: &[u16]) -> Option<usize> {
        (self.done < peers.len()).then_some(self.done)
    }

    /// The federate to which a connection is to be made next.
    fn next(&self, peers: &[u16]) -> Option<FederateId> {
        peers.get(self.done).copied().map(FederateId)
    }

    /// The federate of which the address is to be asked for; `None` when all connections are there.
    pub(super) fn ask(&mut self, peers: &[u16]) -> Option<FederateId> {
        let next = self.next(peers);
        self.asked = next.is_some();
        next
    }

    /// The RTI's answer to the last question; `port` is negative as long as it knows none.
    pub(super) fn handle_address(&mut self, peers: &[u16], now: Instant, port: i32, ip: IpAddress) -> Address {
        let Some(federate) = self.next(peers).filter(|_| self.asked) else { return Address::Unasked };
        self.asked = false;
        let Some(port) = u16::try_from(port).ok().filter(|port| *port != 0) else {
            return Address::AskAgain(now + ADDRESS_RETRY);
        };
        self.give_up.get_or_insert(now + CONNECT_TIME_OUT);
        Address::Found(federate, Endpoint::new(ip, port))
    }

    /// The next federate takes this one's messages.
    pub(super) fn connected(&mut self) {
        self.done += 1;
        self.give_up = None;
    }

    /// The connection to the next federate could not be made, or ended before it was accepted. Gives when its address
    /// is to be asked for again, for it may be another one.
    ///
    /// # Errors
    /// The federate, when the time for it is over.
    pub(super) fn lost(&self, peers: &[u16], now: Instant) -> Result<Instant, FederateId> {
        match self.next(peers) {
            Some(federate) if self.give_up.is_some_and(|give_up| give_up <= now) => Err(federate),
            _ => Ok(now + CONNECT_RETRY),
        }
    }
}
