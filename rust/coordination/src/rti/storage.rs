// SPDX-License-Identifier: Apache-2.0
//! The memory of the RTI, provided by its owner.

use lf_model::time::{Instant, Interval, Tag};
use lf_wire::{ADDRESS_PORT_UNKNOWN, QueryEnd};

use super::config::SetupError;
use super::graph::Node;
#[cfg(feature = "transients")]
use super::incarnation::{Incarnation, Notifications};
use super::outlet::ConnectionId;
use super::path::PathWords;
use crate::auth::Nonce;
use crate::clock_sync::Poll;
use crate::{FederateId, IpAddress, Tally};

/// All the memory that an RTI needs, for n federates. Its content does not matter; `EMPTY` and `Default` are there to
/// fill it.
pub struct RtiStorage<'s> {
    /// One for each federate: n.
    pub slots: &'s mut [Slot],
    /// One for each federate: n.
    pub nodes: &'s mut [Node],
    /// One for each connection that can be open at once: n, and a few more, so that a rejected peer can learn the
    /// reason.
    pub connections: &'s mut [Connection],
    /// Paths between any two federates, seen from either end: 2 × n × n. The RTI does not touch what the federation
    /// does not use, so its pages cost nothing on a system that allocates them on the first write.
    pub paths: &'s mut [PathWords],
    /// Connections between federates: n × the maximum number of upstream federates of one federate, for which n always
    /// suffices.
    pub upstream: &'s mut [PathWords],
    /// Messages in transit: n × the number of different tags of messages to one federate that are stored exactly, at
    /// least 1. See the argument in the module `in_transit`: in cycles without delay, as many as can be outstanding.
    pub in_transit: &'s mut [Tag],
    /// With transient federates, n × n: the federates about whose comings and goings each one is informed.
    #[cfg(feature = "transients")]
    pub registrations: &'s mut [bool],
}

impl RtiStorage<'_> {
    pub(super) fn check(&self) -> Result<(), SetupError> {
        let count = self.slots.len();
        if count == 0 || count > usize::from(u16::MAX) {
            return Err(SetupError::Federates { slots: count });
        }
        let parts = [
            ("federates in the graph", count, self.nodes.len()),
            ("connections", count, self.connections.len()),
            ("paths", count.saturating_mul(count).saturating_mul(2), self.paths.len()),
            ("messages in transit", count, self.in_transit.len()),
        ];
        match parts.into_iter().find(|(_, needed, found)| found < needed) {
            Some((part, needed, found)) => Err(SetupError::Storage { part, needed, found }),
            None => Ok(()),
        }
    }
}

/// The membership of an id.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) enum Membership {
    /// No peer has this id.
    #[default]
    Free,
    /// The connection that claims it has not completed its handshake.
    Joining(ConnectionId),
    /// The federate is part of the federation.
    Joined(ConnectionId),
    /// The federate was part of the federation, and has left.
    Departed,
}

/// The messages to send to a federate as soon as there is room, in this order. The content of a grant or DNET is
/// computed when it is sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[expect(clippy::struct_excessive_bools, reason = "independent flags, one for each kind of message")]
pub(super) struct Pending {
    pub(super) start: bool,
    pub(super) stop_request: bool,
    /// A PTAG of the stop tag, which revokes earlier grants (see module `stop`).
    pub(super) revoked: bool,
    pub(super) stop_granted: bool,
    /// The range of ids of federates upstream that may have left since the last message about that.
    pub(super) left: Option<(u16, u16)>,
    /// The notifications about transient federates.
    #[cfg(feature = "transients")]
    pub(super) notifications: Notifications,
    pub(super) grant: bool,
    pub(super) dnet: bool,
}

impl Pending {
    const NONE: Self = Self {
        start: false,
        stop_request: false,
        revoked: false,
        stop_granted: false,
        left: None,
        #[cfg(feature = "transients")]
        notifications: Notifications::NONE,
        grant: false,
        dnet: false,
    };

    /// Records that a federate upstream has left.
    pub(super) fn record_departure(&mut self, federate: u16) {
        self.left = Some(extended(self.left, federate));
    }

    /// Returns whether something has to go out before any grant or forwarded message.
    pub(super) fn comes_first(self) -> bool {
        #[cfg(feature = "transients")]
        if self.notifications != Notifications::NONE {
            return true;
        }
        self.start || self.stop_request || self.revoked || self.stop_granted || self.left.is_some()
    }
}

/// Returns the range of ids that has this one, too.
pub(super) fn extended(range: Option<(u16, u16)>, federate: u16) -> (u16, u16) {
    let (first, last) = range.unwrap_or((federate, federate));
    (first.min(federate), last.max(federate))
}

/// Counters of a federate for events that are logged only now and then.
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

/// The waits of a federate that the RTI has seen, and since when.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Seen {
    pub(super) tag: Tag,
    pub(super) since: Instant,
    pub(super) logged: bool,
}

impl Seen {
    pub(super) const NOTHING: Self = Self { tag: Tag::NEVER, since: Instant::NEVER, logged: false };
}

/// The state of one federate, except for its tags (see [`Node`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts of a federate")]
pub struct Slot {
    pub(super) membership: Membership,
    pub(super) pending: Pending,
    /// Whether a federate with this id has left before the start.
    pub(super) vacated: bool,
    /// Its clock, once it has sent it.
    pub(super) clock: Option<Instant>,
    /// The time by which its clock was ahead of the RTI's when it sent it.
    pub(super) ahead: Interval,
    /// Whether the last byte of its last question for an address may still come.
    pub(super) query_end: QueryEnd,
    /// The knowledge about it that is not of one incarnation only, if it is transient.
    #[cfg(feature = "transients")]
    pub(super) incarnation: Incarnation,
    /// Whether it wants to be granted the stop tag like any other tag.
    pub(super) ordered_stop: bool,
    /// Whether it has asked to stop, or has agreed to.
    pub(super) stop_agreed: bool,
    /// Address of its connection to the RTI.
    pub(super) address: IpAddress,
    /// Port that it advertised.
    pub(super) port: i32,
    /// UDP port of its clock synchronization.
    pub(super) udp_port: u16,
    /// The rounds of its clock synchronization.
    pub(super) poll: Poll,
    /// Whether it has been suspected of a violation.
    pub(super) suspected: bool,
    /// Its counters.
    pub(super) tallies: Tallies,
    /// Its wait, if waits are logged.
    pub(super) seen: Seen,
    /// The window that it offers, or 0.
    pub(super) window: u16,
}

impl Slot {
    /// A fresh entry.
    pub const EMPTY: Self = Self {
        membership: Membership::Free,
        pending: Pending::NONE,
        vacated: false,
        clock: None,
        ahead: Interval::ZERO,
        query_end: QueryEnd::NONE,
        #[cfg(feature = "transients")]
        incarnation: Incarnation::NONE,
        ordered_stop: false,
        stop_agreed: false,
        address: IpAddress::UNSPECIFIED,
        port: ADDRESS_PORT_UNKNOWN,
        udp_port: 0,
        poll: Poll::NONE,
        suspected: false,
        tallies: Tallies::NOTHING,
        seen: Seen::NOTHING,
        window: 0,
    };

    /// Returns whether the federate may come and go while the federation runs.
    pub(super) const fn is_transient(&self) -> bool {
        #[cfg(feature = "transients")]
        return self.incarnation.is_transient;
        #[cfg(not(feature = "transients"))]
        return false;
    }
}

#[cfg(feature = "transients")]
impl Slot {
    /// Forgets everything that belongs to the incarnation of a transient federate in the running federation.
    pub(super) fn end_incarnation(&mut self) {
        let incarnation = Incarnation { begin: Tag::NEVER, ..self.incarnation };
        *self = Self { membership: Membership::Departed, incarnation, ..Self::EMPTY };
    }
}

impl Default for Slot {
    fn default() -> Self {
        Self::EMPTY
    }
}

/// The message that is expected next on a connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) enum Phase {
    /// There is no connection.
    #[default]
    Vacant,
    /// `FED_NONCE`, to be answered with this nonce and a proof.
    Nonce { own: Nonce },
    /// `FED_RESPONSE` of the peer that claims to be this federate: the proof for this nonce.
    Proof { own: Nonce, claimed: u16 },
    /// `FED_IDS`; with authentication, of the federate that it claimed to be in `FED_NONCE`.
    Ids { claimed: Option<u16> },
    /// `NEIGHBOR_STRUCTURE`.
    Neighbors,
    /// `UDP_PORT`.
    UdpPort,
    /// Nothing: it has been waiting for its exchanges of clock synchronization since this time, and then has this many.
    AwaitsExchange { since: Instant, trials: u32 },
    /// Nothing: the next T1 is due, and this many remain.
    Asked { left: u32 },
    /// The same, once there is room for it.
    Full { left: u32 },
    /// T3, this many times.
    ClockSync { left: u32 },
    /// Nothing: the federate whose place it takes has been told to stop, and is still there.
    #[cfg(feature = "transients")]
    Successor,
    /// Any message that a federate of the federation may send.
    Joined,
    /// Nothing but its end.
    Draining,
}

/// The state of one connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Connection {
    pub(super) phase: Phase,
    /// The federate that it claims to be, after `FED_IDS`.
    pub(super) federate: Option<u16>,
    pub(super) address: IpAddress,
    /// The time at which the RTI closes the connection if it stays silent.
    pub(super) deadline: Option<Instant>,
    /// Whether nothing more will come than what has.
    pub(super) ended: bool,
    /// UDP port of its clock synchronization, for a federate that takes the place of another one.
    #[cfg(feature = "transients")]
    pub(super) udp_port: u16,
}

impl Connection {
    /// A fresh entry.
    pub const EMPTY: Self = Self {
        phase: Phase::Vacant,
        federate: None,
        address: IpAddress::UNSPECIFIED,
        deadline: None,
        ended: false,
        #[cfg(feature = "transients")]
        udp_port: 0,
    };
}

/// Converts the index of a slot to the federate's id.
pub(super) fn id(index: usize) -> FederateId {
    // The error in the text of this panic would take half a KiB.
    let Ok(id) = u16::try_from(index) else { panic!("`check` says that an id can name each slot") };
    FederateId(id)
}
