// SPDX-License-Identifier: Apache-2.0
//! The connections to federates to which this one sends directly, one after the other before the start.
//!
//! This federate asks the RTI for an address until the RTI knows one, because that federate may come later; then the
//! owner connects. The federate sends its time to the RTI only when all connections exist, so none can be missing at
//! the start.

use lf_model::time::{Instant, Interval};

use super::config::{CONNECT_RETRY, CONNECT_TIME_OUT};
use crate::{Endpoint, FederateId, IpAddress};

/// The pause before the next question after the RTI did not know an address.
pub const ADDRESS_RETRY: Interval = Interval::from_millis(250);

/// The progress of the connections to other federates.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Meeting {
    /// The number of connections that exist.
    done: usize,
    /// The time at which the federate gives up on the next one, once its address is known.
    give_up: Option<Instant>,
    /// The RTI owes an address.
    asked: bool,
}

/// The consequence of an address from the RTI.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Address {
    /// Nothing: it was not asked for.
    Unasked,
    /// Ask again at this time.
    AskAgain(Instant),
    /// Connect to this federate.
    Found(FederateId, Endpoint),
}

impl Meeting {
    /// Returns the index of the federate to connect to next, among those to which this one sends.
    pub(super) fn next_index(&self, peers: &[u16]) -> Option<usize> {
        (self.done < peers.len()).then_some(self.done)
    }

    /// Returns the federate to connect to next.
    fn next(&self, peers: &[u16]) -> Option<FederateId> {
        peers.get(self.done).copied().map(FederateId)
    }

    /// Returns the federate whose address to ask for; `None` if all connections exist.
    pub(super) fn ask(&mut self, peers: &[u16]) -> Option<FederateId> {
        let next = self.next(peers);
        self.asked = next.is_some();
        next
    }

    /// Handles the RTI's answer to the last question; `port` is negative while the RTI knows none.
    pub(super) fn handle_address(&mut self, peers: &[u16], now: Instant, port: i32, ip: IpAddress) -> Address {
        let Some(federate) = self.next(peers).filter(|_| self.asked) else { return Address::Unasked };
        self.asked = false;
        let Some(port) = u16::try_from(port).ok().filter(|port| *port != 0) else {
            return Address::AskAgain(now + ADDRESS_RETRY);
        };
        self.give_up.get_or_insert(now + CONNECT_TIME_OUT);
        Address::Found(federate, Endpoint::new(ip, port))
    }

    /// Records that the next federate accepts this one's messages.
    pub(super) fn connected(&mut self) {
        self.done += 1;
        self.give_up = None;
    }

    /// Handles that the connection to the next federate could not be made, or ended before it was accepted. Returns
    /// when to ask for its address again, because it may have changed.
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
