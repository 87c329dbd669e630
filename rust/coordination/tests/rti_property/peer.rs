// SPDX-License-Identifier: Apache-2.0
//! A federate that keeps the rules, for tests of the RTI: it announces what it has to, waits for grants, and notices
//! when a grant was wrong.

use std::collections::{BTreeMap, BTreeSet};

use lf_coordination::rti::ConnectionId;
use lf_testkit::messages::{encoded, introduction};
use lf_testkit::rti::dialogue::START;
use lf_wire::{Decoded, Limits, Message, Tag, decode};

/// The steps of a federate.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) upstream: Vec<(u16, i64)>,
    /// Destination and delay of each connection, as on the wire.
    pub(crate) downstream: Vec<(u16, i64)>,
    /// Its own events, in nanoseconds after the start.
    pub(crate) events: BTreeSet<i64>,
    /// When it ends, in nanoseconds after the start.
    pub(crate) end: i64,
    /// Whether it leaves out announcements that nobody needs.
    pub(crate) honours_dnet: bool,
    /// Whether it ends without a word instead of resigning.
    pub(crate) dies: bool,
}

pub(crate) struct Peer {
    pub(crate) id: u16,
    pub(crate) plan: Plan,
    pub(crate) connection: ConnectionId,
    /// Bytes on their way to the RTI.
    pub(crate) outbox: Vec<u8>,
    inbox: Vec<u8>,
    started: bool,
    /// Events to come; true if a message causes it.
    queue: BTreeMap<Tag, bool>,
    current: Tag,
    granted: Tag,
    announced: Option<Tag>,
    skipped: Option<Tag>,
    dnet: Option<Tag>,
    pub(crate) left: bool,
    pub(crate) received: usize,
    pub(crate) sent: usize,
}

fn delayed(tag: Tag, delay: i64) -> Tag {
    match delay {
        i64::MIN => tag,
        0 => Tag::new(tag.time, tag.microstep + 1),
        _ => Tag::new(tag.time + delay, 0),
    }
}

impl Peer {
    pub(crate) fn new(id: u16, plan: Plan, connection: ConnectionId, federation: &[u8]) -> Self {
        let queue = plan.events.iter().chain([&plan.end]).map(|ns| (Tag::new(START + ns, 0), false)).collect();
        let mut peer = Self {
            id,
            connection,
            outbox: Vec::new(),
            inbox: Vec::new(),
            started: false,
            queue,
            current: Tag::NEVER,
            granted: Tag::NEVER,
            announced: None,
            skipped: None,
            dnet: None,
            left: false,
            received: 0,
            sent: 0,
            plan,
        };
        let (upstream, downstream) = (peer.plan.upstream.clone(), peer.plan.downstream.clone());
        let mut ids: Vec<u16> = downstream.iter().map(|(id, _)| *id).collect();
        ids.sort_unstable();
        ids.dedup();
        for message in introduction(id, federation, &upstream, &ids) {
            peer.say(&message);
        }
        peer.say(&Message::Timestamp(0));
        peer
    }

    fn say(&mut self, message: &Message<'_>) {
        self.outbox.extend(encoded(message));
    }

    fn next(&self) -> Tag {
        self.queue.first_key_value().map_or(Tag::FOREVER, |(tag, _)| *tag)
    }

    /// Returns the last tag.
    fn end(&self) -> Tag {
        Tag::new(START + self.plan.end, 0)
    }

    fn waits_for_grants(&self) -> bool {
        !self.plan.upstream.is_empty()
    }

    fn announce(&mut self) {
        let next = self.next();
        if self.announced == Some(next) || self.skipped == Some(next) {
            return;
        }
        let needs_grant = self.waits_for_grants() && self.granted < next;
        let nobody_asks = self.dnet.is_some_and(|dnet| dnet >= next);
        if self.plan.honours_dnet && nobody_asks && !needs_grant {
            self.skipped = Some(next);
            return;
        }
        (self.announced, self.skipped) = (Some(next), None);
        self.say(&Message::NextEventTag(next));
    }

    /// Handles its next event, if it may. Returns whether it did anything.
    pub(crate) fn step(&mut self, choose: &mut impl FnMut(usize) -> usize) -> bool {
        if !self.started || self.left {
            return false;
        }
        let tag = self.next();
        if self.waits_for_grants() && self.granted < tag {
            return false;
        }
        let had_input = self.queue.remove(&tag).unwrap_or_default();
        self.current = tag;
        for (federate, delay) in self.plan.downstream.clone() {
            let arrival = delayed(tag, delay);
            if choose(3) > 0 && arrival <= self.end() {
                let payload = vec![7; choose(20)];
                self.say(&Message::TaggedMessage { port: 0, federate, tag: arrival, payload: &payload });
                self.sent += 1;
                self.dnet = self.dnet.map(|dnet| dnet.min(tag));
            }
        }
        if had_input {
            self.say(&Message::LatestTagComplete(tag));
        }
        if tag >= self.end() {
            if !self.plan.dies {
                self.say(&Message::NextEventTag(Tag::FOREVER));
                self.say(&Message::Resign);
            }
            self.left = true;
        } else {
            self.announce();
        }
        true
    }

    /// Reads what has come from the RTI.
    pub(crate) fn read(&mut self, bytes: &[u8]) {
        self.inbox.extend(bytes);
        let inbox = std::mem::take(&mut self.inbox);
        let mut at = 0;
        while let Ok(Decoded::Complete { message, len }) = decode(&inbox[at..], &Limits::NONE) {
            self.hear(&message);
            at += len;
        }
        self.inbox = inbox[at..].to_vec();
    }

    fn hear(&mut self, message: &Message<'_>) {
        let id = self.id;
        match *message {
            Message::Ack => {}
            Message::Timestamp(start) => {
                assert_eq!(start, START);
                self.started = true;
                self.announce();
            }
            Message::TagGrant(tag) => {
                assert!(tag > self.granted, "federate {id} is granted {tag} after {}", self.granted);
                self.granted = tag;
            }
            Message::DownstreamNextEventTag(tag) => {
                self.dnet = Some(tag);
                if let Some(skipped) = self.skipped.filter(|skipped| tag < *skipped) {
                    (self.announced, self.skipped) = (Some(skipped), None);
                    self.say(&Message::NextEventTag(skipped));
                }
            }
            Message::TaggedMessage { tag, federate, .. } => {
                assert_eq!(federate, id);
                self.received += 1;
                if self.left {
                    return;
                }
                let granted = self.granted;
                assert!(tag > granted, "federate {id} is granted {granted}, but gets a message at {tag}");
                assert!(tag > self.current, "federate {id} is at {}, but gets a message at {tag}", self.current);
                self.queue.insert(tag, true);
                self.announce();
            }
            other => panic!("federate {id} should not get {other:?}"),
        }
    }
}
