// SPDX-License-Identifier: Apache-2.0
//! The memory of the RTI, which its owner gives.

use lf_model::time::{Instant, Interval, Tag};
use lf_wire::{ADDRESS_PORT_UNKNOWN, QueryEnd};

use super::config::SetupError;
use super::graph::Node;
use super::outlet::ConnectionId;
use super::path::PathWords;
use crate::auth::Nonce;
use crate::clock_sync::Poll;
use crate::{FederateId, IpAddress, Tally};

/// All the memory that an RTI needs, for n federates. What it contains does not matter; `EMPTY` and `Default`
/// are there to fill it.
pub struct RtiStorage<'s> {
    /// One for each federate: n.
    pub slots: &'s mut [Slot],
    /// One for each federate: n.
    pub nodes: &'s mut [Node],
    /// One for each connection that can be open at once: n, and a few more so that wrong ones can be told why they
    /// are refused.
    pub connections: &'s mut [Connection],
    /// Paths between any two federates, seen from either end: 2 × n × n. What the federation does not use is not
    /// touched, so its pages cost nothing where the system gives them when they are first written.
    pub paths: &'s mut [PathWords],
    /// Connections between federates: n × the most upstream federates that one may have, which n always suffices for.
    pub upstream: &'s mut [PathWords],
    /// Messages in transit: n × how many different tags of messages to one federate are remembered exactly, at least 1.
    /// See the argument in the module `in_transit`: in cycles without delay, as many as can be outstanding.
    pub in_transit: &'s mut [Tag],
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

/// Where a federate stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) enum Membership {
    /// Nobody has this id.
    #[default]
    Free,
    /// The connection that claims it has not completed its handshake.
    Joining(ConnectionId),
    /// The federate is part of the federation.
    Joined(ConnectionId),
    /// It was, and has left.
    Departed,
}

/// What is to be sent to a federate as soon as there is room, in this order. What a grant or DNET says is worked out
/// when it is sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[expect(clippy::struct_excessive_bools, reason = "independent flags, one for each kind of message")]
pub(super) struct Pending {
    pub(super) start: bool,
    pub(super) stop_request: bool,
    /// A PTAG of the stop tag, which takes back earlier grants (see module `stop`).
    pub(super) taken_back: bool,
    pub(super) stop_granted: bool,
    /// Which federates upstream have left since it was told, at most: the least and the greatest id.
    pub(super) left: Option<(u16, u16)>,
    pub(super) grant: bool,
    pub(super) dnet: bool,
}

impl Pending {
    const NONE: Self = Self {
        start: false,
        stop_request: false,
        taken_back: false,
        stop_granted: false,
        left: None,
        grant: false,
        dnet: false,
    };

    /// A federate upstream has left.
    pub(super) fn note_left(&mut self, federate: u16) {
        let (first, last) = self.left.unwrap_or((federate, federate));
        self.left = Some((first.min(federate), last.max(federate)));
    }

    /// Whether something has to go out before any grant or forwarded message.
    pub(super) fn comes_first(self) -> bool {
        self.start || self.stop_request || self.taken_back || self.stop_granted || self.left.is_some()
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

/// What a federate is waiting for since when, as far as the RTI has seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Seen {
    pub(super) tag: Tag,
    pub(super) since: Instant,
    pub(super) told: bool,
}

impl Seen {
    pub(super) const NOTHING: Self = Self { tag: Tag::NEVER, since: Instant::NEVER, told: false };
}

/// What the RTI knows of one federate, but for its tags (see [`Node`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts of a federate")]
pub struct Slot {
    pub(super) membership: Membership,
    pub(super) pending: Pending,
    /// Whoever had this id has left before the start.
    pub(super) vacated: bool,
    /// Its clock, once it has sent it.
    pub(super) clock: Option<Instant>,
    /// How far its clock was ahead of the RTI's when it told it.
    pub(super) ahead: Interval,
    /// The last byte of its last question for an address may still come.
    pub(super) query_end: QueryEnd,
    /// It wants to be granted the stop tag in its turn.
    pub(super) stops_in_turn: bool,
    /// It has asked to stop, or has agreed to.
    pub(super) stop_agreed: bool,
    /// Address of its connection to the RTI.
    pub(super) address: IpAddress,
    /// Port that it advertised.
    pub(super) port: i32,
    /// UDP port of its clock synchronization.
    pub(super) udp_port: u16,
    /// The rounds of its clock synchronization.
    pub(super) poll: Poll,
    /// Something that it said was doubtful.
    pub(super) suspected: bool,
    /// What it did and is told now and then.
    pub(super) tallies: Tallies,
    /// What it waits for, if that is looked at.
    pub(super) seen: Seen,
}

impl Slot {
    /// What fresh storage holds.
    pub const EMPTY: Self = Self {
        membership: Membership::Free,
        pending: Pending::NONE,
        vacated: false,
        clock: None,
        ahead: Interval::ZERO,
        query_end: QueryEnd::NONE,
        stops_in_turn: false,
        stop_agreed: false,
        address: IpAddress::UNSPECIFIED,
        port: ADDRESS_PORT_UNKNOWN,
        udp_port: 0,
        poll: Poll::NONE,
        suspected: false,
        tallies: Tallies::NOTHING,
        seen: Seen::NOTHING,
    };
}

impl Default for Slot {
    fn default() -> Self {
        Self::EMPTY
    }
}

/// What a connection is expected to say next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) enum Phase {
    /// There is no connection.
    #[default]
    Vacant,
    /// `FED_NONCE`, to be answered with this nonce and a proof.
    Nonce { own: Nonce },
    /// `FED_RESPONSE` by whoever claims to be this federate: the proof over this nonce.
    Proof { own: Nonce, claimed: u16 },
    /// `FED_IDS`; with authentication, of the federate that it claimed to be in `FED_NONCE`.
    Ids { claimed: Option<u16> },
    /// `NEIGHBOR_STRUCTURE`.
    Neighbors,
    /// `UDP_PORT`.
    UdpPort,
    /// Nothing: it waits for its turn since this time, and then has so many exchanges of clock synchronization.
    Turn { since: Instant, trials: u32 },
    /// Nothing: it is to be sent T1, this often.
    Asked { left: u32 },
    /// The same, once there is room for it.
    Full { left: u32 },
    /// T3, this often.
    ClockSync { left: u32 },
    /// Anything that a federate of the federation may say.
    Joined,
    /// Nothing; only its end.
    Draining,
}

/// All that the RTI knows of one connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Connection {
    pub(super) phase: Phase,
    /// The federate that it claims to be, after `FED_IDS`.
    pub(super) federate: Option<u16>,
    pub(super) address: IpAddress,
    /// When the RTI loses patience with it.
    pub(super) deadline: Option<Instant>,
    /// Nothing more will come but what has.
    pub(super) ended: bool,
}

impl Connection {
    /// What fresh storage holds.
    pub const EMPTY: Self =
        Self { phase: Phase::Vacant, federate: None, address: IpAddress::UNSPECIFIED, deadline: None, ended: false };
}

/// An index of a slot as the federate's id.
pub(super) fn id(index: usize) -> FederateId {
    // The error in the text of this panic would take half a KiB.
    let Ok(id) = u16::try_from(index) else { panic!("`check` says that an id can name each slot") };
    FederateId(id)
}
