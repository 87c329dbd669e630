// SPDX-License-Identifier: Apache-2.0
//! Transient federates: this one or its neighbors come and go while the federation runs.
//!
//! **This one.** The RTI answers the clock of a transient federate with its *effective start*, the first tag of this
//! incarnation. The RTI drops messages before it, apart from some that a stock RTI lets through, which this part drops.
//! A transient federate can stop alone, and has to when another instance takes its place.
//!
//! **Neighbors.** A transient federate is absent until the RTI says that it has come, and again when it has left. One
//! to which this federate sends directly is connected before the start if it is there, and otherwise each time that it
//! comes: this part asks for its address then. The owner keeps the list of those that it still has to find.

use lf_model::time::{Instant, Interval, Tag};
use lf_wire::Message;

use super::config::{Config, Coordination};
use super::event::Event;
use super::machine::Federate;
use super::needs::Needs;
use super::phase::Phase;
use crate::tag::from_wire;
use crate::{FederateId, IpAddress};

/// The time before its first tag that a transient federate gives others with decentralized coordination: they connect
/// to it meanwhile, and send it what it needs at that tag. It is the time between the last clock and the start.
const JOIN_DELAY: Interval = Interval::from_secs(1);

impl<N: Needs> Federate<'_, N> {
    /// Returns whether this federate comes and goes while the federation runs.
    pub fn is_transient(&self) -> bool {
        self.config.is_transient()
    }

    /// Returns whether a federate, this one or a neighbor, comes and goes while the federation runs.
    pub fn may_be_absent(&self, federate: FederateId) -> bool {
        self.config.may_be_absent(federate)
    }

    /// Returns whether a message with this tag is from before the effective start of this federate, and so not for it.
    pub fn misses(&self, tag: Tag) -> bool {
        N::TRANSIENTS && self.transients.misses(tag)
    }

    /// Returns whether this federate has announced a next event after this tag. Then others may be past the tag, and
    /// what it sent there would come too late.
    pub fn has_announced_beyond(&self, tag: Tag) -> bool {
        N::TRANSIENTS && N::CENTRALIZED && self.tags.has_announced_beyond(tag)
    }

    /// Asks for the address of a transient federate that has come ([`Event::PeerCame`]), to connect to it:
    /// [`Event::PeerFound`] follows if it is still there. Returns `false`, and does nothing, while another search is
    /// open.
    pub fn find_peer(&mut self, federate: FederateId) -> bool {
        self.phase() == Phase::Running && self.transients.search(federate)
    }

    /// Returns whether a search of [`Federate::find_peer`] is open.
    pub fn is_searching(&self) -> bool {
        N::TRANSIENTS && self.transients.is_searching()
    }

    /// Handles a message about transient federates. Returns `None` for any other message.
    pub(super) fn handle_of_transients<'m>(&mut self, message: &Message<'m>) -> Option<Event<'m>> {
        let phase = self.phase();
        if !N::TRANSIENTS || !(Phase::Synchronizing..=Phase::Running).contains(&phase) {
            return None;
        }
        Some(match *message {
            Message::EffectiveStart { start, tag } if self.config.is_transient() && self.session.start() => {
                let (start, tag) = (Instant::from_nanos(start), from_wire(tag));
                self.transients.begin(tag);
                self.tags.join(start, tag);
                Event::Joined { start, tag }
            }
            Message::TaggedMessage { tag, .. } if phase == Phase::Running && self.misses(from_wire(tag)) => Event::None,
            Message::UpstreamConnected { federate } => Event::UpstreamCame(FederateId(federate)),
            Message::UpstreamDisconnected { federate } => Event::UpstreamLeft(FederateId(federate)),
            Message::Stop if self.config.is_transient() => Event::Replaced,
            Message::OutboundConnected { federate } => Event::PeerCame(FederateId(federate)),
            Message::OutboundDisconnected { federate } => {
                let federate = FederateId(federate);
                self.transients.left(federate);
                Event::PeerLeft(federate)
            }
            Message::AddressQueryReply { port, address } => {
                return self.transients.found(port, IpAddress::V4(address.into()));
            }
            #[cfg(feature = "ipv6")]
            Message::AddressQueryReplyIpv6 { port, address, scope } => {
                return self.transients.found(port, self.config.as_seen_here(address.into(), scope));
            }
            _ => return None,
        })
    }
}

impl<N: Needs> Config<'_, N> {
    /// Returns how long after its clock this federate begins: with decentralized coordination nobody waits for a
    /// federate that joins, so it leaves the others the time to connect to it.
    pub(super) fn join_delay(&self) -> Interval {
        let waits = self.is_transient() && self.coordination() == Coordination::Decentralized;
        if waits && self.listening.is_some() { JOIN_DELAY } else { Interval::ZERO }
    }
}
