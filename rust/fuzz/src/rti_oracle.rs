// SPDX-License-Identifier: Apache-2.0
//! The connections of an RTI, and what it may not do on them whatever the peers say.

use std::collections::BTreeSet;

use lf_coordination::from_wire;
use lf_coordination::rti::{ConnectionId, Outlet, RtiEvent};
use lf_model::time::{Instant, Interval, Tag};
use lf_wire::{DELAY_NONE, Message};

/// More messages than one input can lead to.
const ANSWERS_MAX: usize = 2_000;

/// One connection and the federate on it.
#[derive(Default)]
pub(crate) struct Peer {
    pub(crate) open: bool,
    /// The peer has closed it; what it has said may still wait.
    pub(crate) closing: bool,
    /// The RTI's direction is closed.
    pub(crate) ended: bool,
    /// Bytes that wait to be sent.
    pub(crate) pending: usize,
    /// What the peer has said and the RTI has not consumed.
    pub(crate) input: Vec<u8>,
    pub(crate) federate: Option<u16>,
    /// The last neighbor structure that it has sent: from whom, with what delay.
    pub(crate) upstream: Vec<(u16, i64)>,
    granted: Option<Tag>,
    provisional: Option<Tag>,
    /// The latest tag that it says is complete.
    completed: Option<Tag>,
    /// Tags of messages that it has been sent, and that are not complete.
    unconsumed: BTreeSet<Tag>,
}

impl Peer {
    /// One that has said nothing yet.
    pub(crate) fn connected() -> Self {
        Self { open: true, ..Self::default() }
    }
}

/// All connections.
pub(crate) struct Oracle {
    pub(crate) peers: Vec<Peer>,
    pub(crate) capacity: usize,
    pub(crate) start: Option<i64>,
    /// Messages since the last input.
    answers: usize,
}

impl Oracle {
    pub(crate) fn new(connections: usize, capacity: usize) -> Self {
        let peers = (0..connections).map(|_| Peer::default()).collect();
        Self { peers, capacity, start: None, answers: 0 }
    }

    /// The message at the front of what a peer says, which the RTI is about to be offered.
    pub(crate) fn expect(&mut self, connection: usize, message: &Message<'_>) {
        self.answers = 0;
        let peer = &mut self.peers[connection];
        match *message {
            Message::LatestTagComplete(tag) if self.start.is_some() => {
                peer.completed = peer.completed.max(Some(from_wire(tag)));
                let completed = peer.completed;
                peer.unconsumed.retain(|tag| Some(*tag) > completed);
            }
            Message::FedIds { federate, .. } | Message::TransientFedIds { federate, .. } => {
                peer.federate = peer.federate.or(Some(federate));
            }
            Message::NeighborStructure(neighbors) if self.start.is_none() => {
                peer.upstream = neighbors.upstream().collect();
            }
            _ => {}
        }
    }

    /// A grant may not reach what a message on its way to a federate upstream can still cause.
    fn check_grant(&self, connection: usize, granted: Tag) {
        for (upstream, delay) in &self.peers[connection].upstream {
            let peer = self.peers.iter().find(|peer| peer.federate == Some(*upstream) && peer.open && !peer.ended);
            let Some(first) = peer.and_then(|peer| peer.unconsumed.first()) else { continue };
            // The ends of time are no tags of events.
            if first.time > Instant::NEVER && first.time < Instant::FOREVER {
                let arrival = arrival(*first, *delay);
                let never_comes = arrival == Tag::FOREVER;
                assert!(
                    never_comes || granted < arrival,
                    "{granted:?} is granted, but {first:?} is on its way to {upstream}"
                );
            }
        }
    }
}

/// When a message can come that is sent at `tag`.
fn arrival(tag: Tag, delay: i64) -> Tag {
    match delay {
        DELAY_NONE => tag,
        0 => tag.next_microstep(),
        _ if tag.time + Interval::from_nanos(delay) == Instant::FOREVER => Tag::FOREVER,
        _ => Tag::at(tag.time + Interval::from_nanos(delay)),
    }
}

impl Outlet for Oracle {
    fn room(&self, ConnectionId(connection): ConnectionId) -> usize {
        self.capacity - self.peers[connection].pending
    }

    fn send(&mut self, ConnectionId(connection): ConnectionId, message: &Message<'_>) {
        self.answers += 1;
        assert!(self.answers < ANSWERS_MAX, "one input leads to no end of messages");
        let peer = &mut self.peers[connection];
        assert!(peer.open && !peer.ended, "{message:?} is sent on a connection that is closed");
        if peer.closing {
            return;
        }
        peer.pending += message.encoded_len();
        assert!(peer.pending <= self.capacity, "{message:?} is sent although there is no room");
        match *message {
            Message::TagGrant(tag) => {
                let tag = from_wire(tag);
                // One without upstream federates needs no grant; what it announces counts as one.
                let rises = Some(tag) > peer.granted && Some(tag) >= peer.provisional;
                assert!(rises || peer.upstream.is_empty(), "grants rise");
                peer.granted = Some(tag);
                self.check_grant(connection, tag);
            }
            Message::ProvisionalTagGrant(tag) => {
                let tag = Some(from_wire(tag));
                assert!(tag > peer.granted && tag > peer.provisional, "provisional grants rise");
                peer.provisional = tag;
            }
            Message::TaggedMessage { tag, federate, .. } => {
                assert_eq!(Some(federate), peer.federate, "a message goes to its destination");
                let tag = from_wire(tag);
                // Nobody has an event before the start, so that is not told from no event at all.
                let counts = self.start.is_some_and(|start| tag.time >= Instant::from_nanos(start));
                if counts && Some(tag) > peer.completed {
                    peer.unconsumed.insert(tag);
                }
            }
            Message::Timestamp(start) => self.start = Some(start),
            _ => {}
        }
    }

    fn half_close(&mut self, ConnectionId(connection): ConnectionId) {
        self.peers[connection].ended = true;
    }

    fn close(&mut self, ConnectionId(connection): ConnectionId) {
        let peer = &mut self.peers[connection];
        (peer.open, peer.ended) = (false, true);
        peer.input.clear();
    }

    fn log(&mut self, event: RtiEvent<'_>) {
        assert!(!event.to_string().is_empty());
    }
}
