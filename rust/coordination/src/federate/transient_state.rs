// SPDX-License-Identifier: Apache-2.0
//! The state of a federate that is transient or has transient neighbors: its first tag, and the search for one of them.

use lf_model::time::Tag;
use lf_wire::Message;

use super::event::Event;
use super::outbox::query;
use crate::{Endpoint, FederateId, IpAddress};

/// The state of a federate that is transient or has transient neighbors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transients {
    /// The first tag of this federate, once the RTI has chosen it.
    first: Tag,
    search: Search,
}

/// The search for a transient federate that has come while this one runs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Search {
    None,
    /// The question for its address is to be sent.
    Due(FederateId),
    /// The RTI owes its address.
    Asked(FederateId),
    /// The owner connects to it.
    Found(FederateId),
}

impl Transients {
    pub(super) const fn new() -> Self {
        Self { first: Tag::NEVER, search: Search::None }
    }

    /// Sets the first tag of this federate.
    pub(super) fn begin(&mut self, tag: Tag) {
        self.first = tag;
    }

    /// Returns whether this tag is before the first one.
    pub(super) fn misses(&self, tag: Tag) -> bool {
        tag < self.first
    }

    /// Returns whether a search is open.
    pub(super) fn is_searching(&self) -> bool {
        self.search != Search::None
    }

    /// Begins to look for a federate. Returns `false`, and does nothing, while another search is open.
    pub(super) fn search(&mut self, federate: FederateId) -> bool {
        let is_free = !self.is_searching();
        if is_free {
            self.search = Search::Due(federate);
        }
        is_free
    }

    /// Handles that a federate has left: it is not looked for any more. An answer that the RTI owes still comes.
    pub(super) fn left(&mut self, federate: FederateId) {
        if matches!(self.search, Search::Due(sought) | Search::Found(sought) if sought == federate) {
            self.search = Search::None;
        }
    }

    /// Returns whether the RTI owes an address.
    pub(super) fn is_asked(&self) -> bool {
        matches!(self.search, Search::Asked(_))
    }

    /// Returns the question that is due.
    pub(super) fn due(&self) -> Option<Message<'static>> {
        match self.search {
            Search::Due(federate) => Some(query(federate, true)),
            _ => None,
        }
    }

    /// Records that the question has been transmitted.
    pub(super) fn transmitted(&mut self) {
        if let Search::Due(federate) = self.search {
            self.search = Search::Asked(federate);
        }
    }

    /// Ends the search.
    pub(super) fn end_search(&mut self) {
        self.search = Search::None;
    }

    /// Handles an address: that of the federate in question, unless no question is open.
    pub(super) fn found(&mut self, port: i32, ip: IpAddress) -> Option<Event<'static>> {
        let Search::Asked(federate) = self.search else { return None };
        let port = u16::try_from(port).ok().filter(|port| *port != 0);
        self.search = if port.is_some() { Search::Found(federate) } else { Search::None };
        Some(match port {
            Some(port) => Event::PeerFound { federate, address: Endpoint::new(ip, port) },
            // It has left in the meantime, and the RTI says when it comes again.
            None => Event::None,
        })
    }
}
