// SPDX-License-Identifier: Apache-2.0
//! The control messages that are due.
//!
//! Not a queue, but one place per kind of message: a later NET or LTC replaces one that has not gone out yet, for it says
//! all that the earlier one said. So the outbox is bounded however rarely it is emptied.

use lf_model::time::{Instant, Tag};
use lf_wire::june_2026::{Message, NeighborStructure, UDP_PORT_CLOCK_SYNC_INITIAL, UDP_PORT_CLOCK_SYNC_OFF};

use super::config::{ClockSync, Config};
use crate::tag::to_wire;

/// The messages that are due. They go out in the order of [`Outbox::next`].
// Each flag stands for a message of its own; no two of them make a state.
#[allow(clippy::struct_excessive_bools)]
#[derive(Clone, Debug, Default)]
pub(super) struct Outbox {
    pub(super) fed_ids: bool,
    pub(super) neighbor_structure: bool,
    pub(super) udp_port: bool,
    pub(super) t3: bool,
    pub(super) timestamp: Option<Instant>,
    pub(super) stop_request: Option<Tag>,
    pub(super) stop_reply: Option<Tag>,
    ltc: Option<Tag>,
    net: Option<Tag>,
    pub(super) resign: bool,
    pub(super) failed: bool,
}

impl Outbox {
    /// The next message, without taking it out.
    pub(super) fn next<'a>(&self, config: &Config<'a>) -> Option<Message<'a>> {
        if self.fed_ids {
            return Some(Message::FedIds { federate: config.id.0, federation_id: config.federation_id });
        }
        if self.neighbor_structure {
            let neighbors = NeighborStructure::new(config.upstream, config.downstream);
            return Some(Message::NeighborStructure(neighbors));
        }
        if self.udp_port {
            return Some(Message::UdpPort(match config.clock_sync {
                ClockSync::Off => UDP_PORT_CLOCK_SYNC_OFF,
                ClockSync::Init { .. } => UDP_PORT_CLOCK_SYNC_INITIAL,
            }));
        }
        if self.t3 {
            return Some(Message::T3 { federate: config.id.0 });
        }
        if let Some(time) = self.timestamp {
            return Some(Message::Timestamp(time.as_nanos()));
        }
        if let Some(tag) = self.stop_request {
            return Some(Message::StopRequest(to_wire(tag)));
        }
        if let Some(tag) = self.stop_reply {
            return Some(Message::StopReply(to_wire(tag)));
        }
        if let Some(tag) = self.ltc {
            return Some(Message::LatestTagComplete(to_wire(tag)));
        }
        if let Some(tag) = self.net {
            return Some(Message::NextEventTag(to_wire(tag)));
        }
        if self.resign {
            return Some(Message::Resign);
        }
        self.failed.then_some(Message::Failed)
    }

    /// Takes out a message that [`Outbox::next`] gave.
    pub(super) fn remove(&mut self, message: &Message<'_>) {
        match message {
            Message::FedIds { .. } => self.fed_ids = false,
            Message::NeighborStructure(_) => self.neighbor_structure = false,
            Message::UdpPort(_) => self.udp_port = false,
            Message::T3 { .. } => self.t3 = false,
            Message::Timestamp(_) => self.timestamp = None,
            Message::StopRequest(_) => self.stop_request = None,
            Message::StopReply(_) => self.stop_reply = None,
            Message::LatestTagComplete(_) => self.ltc = None,
            Message::NextEventTag(_) => self.net = None,
            Message::Resign => self.resign = false,
            Message::Failed => self.failed = false,
            // No other message is ever given.
            _ => {}
        }
    }

    /// A NET is due; it replaces one that has not gone out.
    pub(super) fn set_net(&mut self, tag: Tag) {
        self.net = Some(tag);
    }

    /// This tag has been begun: a NET of an earlier one that has not gone out would tell of an event that is over.
    pub(super) fn forget_net_before(&mut self, tag: Tag) {
        self.net = self.net.filter(|net| *net >= tag);
    }

    /// An LTC is due; it replaces one that has not gone out, and a NET that is not later.
    pub(super) fn set_ltc(&mut self, tag: Tag) {
        self.ltc = Some(tag);
        self.net = self.net.filter(|net| *net > tag);
    }

    /// Nothing is due any more.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }
}
