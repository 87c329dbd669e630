// SPDX-License-Identifier: Apache-2.0
//! The messages that an RTI may not send, whatever the peers send.

use std::collections::BTreeSet;

use lf_coordination::from_wire;
use lf_coordination::rti::ConnectionId;
use lf_model::time::{Instant, Interval, Tag};
use lf_testkit::rti::Observer;
use lf_wire::{DELAY_NONE, HANDED_OVER_PORT, Message};

/// The limit of messages per input, above any that an input can cause.
const ANSWERS_MAX: usize = 2_000;

/// The federate on one connection.
#[derive(Default)]
struct Peer {
    /// Whether the RTI may send to it.
    present: bool,
    federate: Option<u16>,
    /// The last neighbor structure that it has sent: upstream federates and delays.
    upstream: Vec<(u16, i64)>,
    granted: Option<Tag>,
    provisional: Option<Tag>,
    /// The latest tag that it reported complete.
    completed: Option<Tag>,
    /// The effective start of a transient federate.
    first: Option<Tag>,
    /// Whether it has said that it leaves.
    leaves: bool,
    /// The tags of messages that the RTI forwarded to it and that it has not completed.
    unconsumed: BTreeSet<Tag>,
}

/// The federates on all connections.
pub(crate) struct Oracle {
    peers: Vec<Peer>,
    start: Option<i64>,
    /// The number of messages since the last input.
    answers: usize,
}

impl Oracle {
    pub(crate) fn new(connections: usize) -> Self {
        Self { peers: (0..connections).map(|_| Peer::default()).collect(), start: None, answers: 0 }
    }

    /// Asserts that a grant stays before the tags of messages that a federate upstream can still cause.
    fn check_grant(&self, connection: usize, granted: Tag) {
        for (upstream, delay) in &self.peers[connection].upstream {
            let peer = self.peers.iter().find(|peer| peer.present && peer.federate == Some(*upstream));
            let Some(first) = peer.and_then(|peer| peer.unconsumed.first()) else { continue };
            // NEVER and FOREVER are no tags of events.
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

/// Returns the tag at which a message sent at `tag` arrives.
fn arrival(tag: Tag, delay: i64) -> Tag {
    match delay {
        DELAY_NONE => tag,
        0 => tag.next_microstep(),
        _ if tag.time + Interval::from_nanos(delay) == Instant::FOREVER => Tag::FOREVER,
        _ => Tag::at(tag.time + Interval::from_nanos(delay)),
    }
}

impl Observer for Oracle {
    fn connected(&mut self, ConnectionId(connection): ConnectionId) {
        self.peers[connection] = Peer { present: true, ..Peer::default() };
    }

    fn offered(&mut self, ConnectionId(connection): ConnectionId, message: &Message<'_>) {
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
            Message::Resign | Message::Failed => peer.leaves = true,
            Message::NeighborStructure(neighbors) if self.start.is_none() => {
                peer.upstream = neighbors.upstream().collect();
            }
            _ => {}
        }
    }

    fn sent(&mut self, ConnectionId(connection): ConnectionId, message: &Message<'_>) {
        self.answers += 1;
        assert!(self.answers < ANSWERS_MAX, "one input leads to no end of messages");
        let peer = &mut self.peers[connection];
        match *message {
            Message::TagGrant(tag) => {
                let tag = from_wire(tag);
                // A federate without upstream federates needs no grant; its announcement counts as one.
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
            // The instance that it is for has not begun.
            Message::TaggedMessage { port: HANDED_OVER_PORT, .. } if peer.first.is_none() => {}
            Message::TaggedMessage { tag, federate, .. } => {
                assert_eq!(Some(federate), peer.federate, "a message goes to its destination");
                let tag = from_wire(tag);
                assert!(peer.first <= Some(tag), "it is not from before the effective start");
                // No federate has an event before the start, so such a tag equals the absence of events.
                let counts = self.start.is_some_and(|start| tag.time >= Instant::from_nanos(start));
                if counts && Some(tag) > peer.completed {
                    peer.unconsumed.insert(tag);
                }
            }
            Message::Timestamp(start) => self.start = Some(start),
            Message::EffectiveStart { start, tag } => {
                let federate = peer.federate;
                let takes_part = |peer: &&Peer| peer.present && !peer.leaves && peer.first.is_some();
                let others = self.peers.iter().filter(|other| other.federate == federate);
                assert_eq!(others.filter(takes_part).count(), 0, "one instance of a federate takes part");
                (self.peers[connection].first, self.start) = (Some(from_wire(tag)), Some(start));
            }
            _ => {}
        }
    }

    fn ended(&mut self, ConnectionId(connection): ConnectionId) {
        self.peers[connection].present = false;
    }
}
