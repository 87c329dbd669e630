// SPDX-License-Identifier: Apache-2.0
//! Observes every connection: no later message may violate a grant.

use std::collections::{BTreeMap, BTreeSet};

use lf_coordination::from_wire;
use lf_model::Payload as _;
use lf_model::time::Tag;
use lf_testkit::random::combine;
use lf_wire::{Decoded, HANDED_OVER_PORT, Limits, Message, QueryEnd, decode, decode_to_transient};

use super::Violation;
use super::direct::{Direct, Written};
use super::seen::{Introduction, Seen, Unpassed};
use crate::program::Value;
use crate::scenario::Scenario;

/// The numbers of messages of some kinds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    pub(crate) messages: u64,
    pub(crate) data: u64,
    pub(crate) grants: u64,
    pub(crate) provisional: u64,
    pub(crate) absent: u64,
    pub(crate) dnet: u64,
    pub(crate) stop_requests: u64,
    pub(crate) revoked: u64,
    /// Messages from and to the RTI that decentralized coordination does not need.
    pub(crate) centralized: u64,
}

impl Counts {
    /// Counts a message of the RTI that needs no check.
    fn count(&mut self, message: &Message<'_>) {
        match message {
            Message::PortAbsent { .. } => self.absent += 1,
            Message::DownstreamNextEventTag(_) => self.dnet += 1,
            _ => {}
        }
    }

    /// Counts messages that were written to another federate.
    fn take(&mut self, written: Result<Written, Violation>, violation: &mut Option<Violation>) {
        match written {
            Ok(Written { data, absent }) => {
                self.messages += data + absent;
                self.data += data;
                self.absent += absent;
            }
            Err(error) => {
                violation.get_or_insert(error);
            }
        }
    }
}

/// Both directions of a connection: the bytes of incomplete messages.
#[derive(Debug, Default)]
struct Tap {
    federate: usize,
    to_rti: Vec<u8>,
    /// The number of these bytes that the RTI has read.
    read: usize,
    /// Whether the last byte of an address query may come in a later piece.
    query_end: QueryEnd,
    from_rti: Vec<u8>,
}

/// The observer of every connection.
#[derive(Debug)]
pub(crate) struct Watch {
    /// The federate of each instance, and whether it is transient.
    instances: Vec<(usize, bool)>,
    taps: Vec<Tap>,
    pub(crate) seen: Vec<Seen>,
    /// The messages in the order in which they were read.
    pub(crate) unpassed: Vec<Unpassed>,
    /// The pairs of federates with a delay in between.
    delayed: BTreeSet<(usize, usize)>,
    /// By receiver and port: the last message that the RTI has forwarded, with its sender.
    passed: BTreeMap<(usize, u16), (usize, Tag)>,
    /// The connections between federates.
    pub(crate) direct: Direct,
    pub(crate) counts: Counts,
    /// A hash of all written bytes, with their times and connections.
    pub(crate) digest: u64,
    pub(crate) violation: Option<Violation>,
    /// Whether to print all messages, as the RTI reads and writes them.
    pub(crate) prints: bool,
}

/// Returns whether a message grants tags, asks for that, or goes through the RTI to another federate.
fn is_centralized(message: &Message<'_>) -> bool {
    matches!(
        message,
        Message::NextEventTag(_)
            | Message::LatestTagComplete(_)
            | Message::TagGrant(_)
            | Message::ProvisionalTagGrant(_)
            | Message::DownstreamNextEventTag(_)
            | Message::TaggedMessage { .. }
            | Message::PortAbsent { .. }
    )
}

/// Returns whether a message is a state for the next instance of its sender: another check looks at those.
fn is_handed_over(message: &Message<'_>) -> bool {
    matches!(message, Message::TaggedMessage { port: HANDED_OVER_PORT, .. })
}

impl Watch {
    pub(crate) fn new(scenario: &Scenario) -> Self {
        let instances = (0..).zip(&scenario.instances);
        let instances = instances.map(|(instance, federate)| (*federate, scenario.is_transient(instance)));
        let delayed = scenario.connections.iter().filter(|one| one.after.is_some_and(|after| after > 0));
        let delayed = delayed.map(|one| (one.from.0, one.to.0)).collect();
        Self { delayed, ..Self::of(instances.collect()) }
    }

    /// Returns the observer of these instances.
    fn of(instances: Vec<(usize, bool)>) -> Self {
        Self {
            taps: Vec::new(),
            direct: Direct::default(),
            seen: vec![Seen::NOTHING; instances.len()],
            instances,
            unpassed: Vec::new(),
            delayed: BTreeSet::new(),
            passed: BTreeMap::new(),
            counts: Counts::default(),
            digest: 0,
            violation: None,
            prints: false,
        }
    }

    /// Notes a connection of this participant to the RTI; connections are numbered consecutively.
    pub(crate) fn begin(&mut self, connection: usize, participant: usize, host: usize) {
        self.taps.resize_with(connection + 1, Tap::default);
        self.taps[connection].federate = participant.saturating_sub(1);
        if host > 0 {
            self.direct.begin(connection, participant.saturating_sub(1), host - 1);
        }
    }

    /// Notes written bytes and the time at which they arrive; side 0 is the one that connected: a federate.
    pub(crate) fn write(&mut self, connection: usize, side: usize, bytes: &[u8], now: u64, arrives: u64) {
        let place = (connection as u64) << 1 | side as u64;
        let content = bytes.iter().fold(place, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3));
        self.digest = combine(self.digest, combine(now, content));
        if self.direct.has(connection) {
            if side == 0 {
                let prints = self.prints;
                let messages = self.direct.write(connection, bytes, (now, arrives), prints);
                self.counts.take(messages, &mut self.violation);
            }
        } else if side == 0 {
            self.taps[connection].to_rti.extend_from_slice(bytes);
        } else {
            self.taps[connection].from_rti.extend_from_slice(bytes);
            self.follow(connection, 1, now);
        }
    }

    /// Notes that the process or the connection of a participant has ended.
    pub(crate) fn lose(&mut self, participant: usize, now: u64) {
        if let Some(seen) = participant.checked_sub(1).and_then(|instance| self.seen.get_mut(instance)) {
            seen.lost.get_or_insert(now);
        }
    }

    /// Notes that this number of bytes of a direction were read.
    pub(crate) fn read(&mut self, connection: usize, direction: usize, count: usize, now: u64) {
        if self.direct.has(connection) {
            if direction == 0 {
                self.direct.read(connection, count, now);
            }
        } else if direction == 0 {
            self.taps[connection].read += count;
            self.follow(connection, 0, now);
        }
    }

    /// Handles the whole messages.
    fn follow(&mut self, connection: usize, direction: usize, now: u64) {
        let tap = &mut self.taps[connection];
        let federate = tap.federate;
        let bytes = std::mem::take(if direction == 0 { &mut tap.to_rti } else { &mut tap.from_rti });
        let end = if direction == 0 { tap.read } else { bytes.len() };
        let mut query_end = if direction == 0 { std::mem::take(&mut tap.query_end) } else { QueryEnd::NONE };
        let mut at = usize::from(query_end.take(&bytes[..end]).is_some());
        while at < end {
            let awaits_start = direction == 1 && self.awaits_start(federate);
            let rest = &bytes[at..end];
            let decoded = if awaits_start {
                decode_to_transient(rest, &Limits::NONE, |_| true)
            } else {
                decode(rest, &Limits::NONE)
            };
            match decoded {
                Ok(Decoded::Complete { message, len }) => {
                    at += len;
                    query_end.follow(&message);
                    at += usize::from(query_end.take(&bytes[at..end]).is_some());
                    self.counts.messages += 1;
                    // A transient federate tells the RTI its last tag, whatever the coordination.
                    let is_last = matches!(message, Message::LatestTagComplete(_)) && self.instances[federate].1;
                    let is_needed = is_last || is_handed_over(&message);
                    self.counts.centralized += u64::from(is_centralized(&message) && !is_needed);
                    if self.prints {
                        let way = if direction == 0 { "->" } else { "<-" };
                        println!("{now:12} f{federate} {way} RTI {message:?}");
                    }
                    if direction == 0 {
                        self.hear_federate(federate, &message, now);
                    } else {
                        self.hear_rti(federate, &message);
                    }
                }
                Ok(Decoded::Incomplete { .. }) => break,
                Err(error) => {
                    self.report(Violation::Bytes { federate, error: error.to_string() });
                    at = end;
                }
            }
        }
        let rest = bytes[at..].to_vec();
        let tap = &mut self.taps[connection];
        if direction == 0 {
            tap.read -= at;
            tap.query_end = query_end;
            tap.to_rti = rest;
        } else {
            tap.from_rti = rest;
        }
    }

    fn report(&mut self, violation: Violation) {
        self.violation.get_or_insert(violation);
    }

    /// Returns whether an instance is one of a transient federate that does not know its first tag.
    fn awaits_start(&self, instance: usize) -> bool {
        self.instances.get(instance).is_some_and(|(_, is_transient)| *is_transient)
            && self.seen[instance].first.is_none()
    }

    fn hear_federate(&mut self, federate: usize, message: &Message<'_>, now: u64) {
        if self.seen.get(federate).is_some_and(|seen| seen.is_expelled) {
            return;
        }
        if is_handed_over(message) {
            self.hand_over(federate);
            return;
        }
        if let Message::TaggedMessage { federate: to, port, tag, payload } = *message {
            let number = Value::decode(payload).map_or(0, Value::number);
            let (to, tag) = (to.into(), from_wire(tag));
            self.unpassed.push(Unpassed { from: federate, to, port, tag, number, read: now });
        }
        if let Message::TaggedMessage { federate: to, tag: wire, .. } = *message
            && let Some(receiver) = self.seen.get_mut(usize::from(to))
        {
            receiver.in_transit.insert(from_wire(wire));
            receiver.announce(receiver.announced);
        }
        let Some(seen) = self.seen.get_mut(federate) else { return };
        match *message {
            Message::UdpPort(_) => seen.introduction = Introduction::Read,
            Message::NextEventTag(next) => seen.announce(from_wire(next)),
            Message::LatestTagComplete(last) => {
                while seen.in_transit.first().is_some_and(|message| *message <= from_wire(last)) {
                    seen.in_transit.pop_first();
                }
                seen.announce(seen.announced.max(from_wire(last).next_microstep()));
                seen.completed = seen.completed.max(from_wire(last));
            }
            Message::StopRequest(named) => {
                self.counts.stop_requests += 1;
                seen.name_stop(from_wire(named));
            }
            Message::StopReply(named) => seen.name_stop(from_wire(named)),
            Message::Resign => seen.left = Some(now),
            Message::Failed => {
                seen.lost.get_or_insert(now);
            }
            _ => {}
        }
    }

    /// Notes that an instance hands over a state to those that wait for its place.
    fn hand_over(&mut self, instance: usize) {
        let federate = self.instances[instance].0;
        let others = self.instances.iter().zip(&mut self.seen).enumerate();
        for (_, (_, seen)) in others.filter(|(other, ((of, _), _))| *of == federate && *other != instance) {
            if seen.introduction == Introduction::Read && seen.first.is_none() {
                seen.introduction = Introduction::Next;
            }
        }
    }

    /// Notes that the RTI forwards a message, or that it stops to, and drops all that it holds of the sender.
    fn follow_passing(&mut self, federate: usize, message: &Message<'_>) {
        match *message {
            Message::TaggedMessage { port, tag, payload, .. } => {
                let tag = from_wire(tag);
                let to = self.instances[federate].0;
                let number = Value::decode(payload).map_or(0, Value::number);
                let is_it = |it: &Unpassed| (it.to, it.port, it.tag, it.number) == (to, port, tag, number);
                match self.unpassed.iter().position(is_it) {
                    Some(place) => {
                        let from = self.unpassed.remove(place).from;
                        self.check_sender(from, federate, port, tag);
                    }
                    None => self.report(Violation::Unsent { federate, port, tag }),
                }
            }
            Message::Failed => {
                let lost = self.unpassed.iter().filter(|it| it.from == federate).map(|it| it.tag).min();
                if let Some(seen) = self.seen.get_mut(federate) {
                    seen.announced = seen.announced.min(lost.unwrap_or(Tag::FOREVER));
                    seen.is_expelled = true;
                }
            }
            _ => {}
        }
    }

    /// Checks that no later instance of its sender was heard before a message, and no earlier one has sent that tag. A
    /// delay can give messages of two tags one tag.
    fn check_sender(&mut self, from: usize, to: usize, port: u16, tag: Tag) {
        let Some((other, before)) = self.passed.insert((to, port), (from, tag)) else { return };
        let first = |instance: usize| self.seen[instance].first;
        let is_delayed = self.delayed.contains(&(self.instances[from].0, self.instances[to].0));
        if other != from && first(other) > first(from) {
            self.report(Violation::TwoHeard { first: from, second: other });
        } else if other != from && (tag < before || tag == before && !is_delayed) {
            self.report(Violation::Repeated { first: other, second: from, tag, before });
        }
    }

    /// Checks the first tag of an instance: no other one of its federate is heard, and those before have not had it.
    fn begin_incarnation(&mut self, instance: usize, first: Tag) {
        let federate = self.instances[instance].0;
        for other in (0..self.instances.len()).filter(|it| *it != instance && self.instances[*it].0 == federate) {
            let seen = &self.seen[other];
            if seen.first.is_some() && seen.over().is_none() && !seen.is_expelled {
                self.violation.get_or_insert(Violation::TwoHeard { first: other, second: instance });
            }
            if first <= seen.completed {
                let before = seen.completed;
                let violation = Violation::Repeated { first: other, second: instance, tag: first, before };
                self.violation.get_or_insert(violation);
            }
        }
        self.seen[instance].first = Some(first);
    }

    fn hear_rti(&mut self, federate: usize, message: &Message<'_>) {
        if is_handed_over(message) {
            return;
        }
        self.counts.count(message);
        self.follow_passing(federate, message);
        if let Message::EffectiveStart { tag, .. } = *message {
            self.begin_incarnation(federate, from_wire(tag));
        }
        let Some(seen) = self.seen.get_mut(federate) else { return };
        let violation = match *message {
            Message::TaggedMessage { tag: wire, port, .. } => {
                self.counts.data += 1;
                seen.count(usize::from(port), from_wire(wire));
                let message = from_wire(wire);
                let violated = |grant, granted| Violation::GrantViolated { federate, grant, granted, message };
                if seen.first.is_some_and(|first| message < first) {
                    Some(violated("its effective start", seen.first.unwrap_or(message)))
                } else if message <= seen.granted {
                    Some(violated("TAG", seen.granted))
                } else if message < seen.provisional {
                    Some(violated("PTAG", seen.provisional))
                } else {
                    None
                }
            }
            Message::TagGrant(wire) => {
                self.counts.grants += 1;
                let (granted, before) = (from_wire(wire), seen.granted);
                seen.granted = seen.granted.max(granted);
                seen.limit();
                // Before a stop, the RTI may withdraw grants from that tag on.
                (granted < before && seen.named.is_none()).then_some(Violation::GrantOrder {
                    federate,
                    granted,
                    before,
                })
            }
            Message::ProvisionalTagGrant(wire) => {
                self.counts.provisional += 1;
                let (granted, before) = (from_wire(wire), seen.granted);
                // A PTAG of the stop tag withdraws the grants from there on.
                let takes_back = granted <= before;
                if takes_back {
                    (seen.granted, seen.provisional) = (granted.before(), granted);
                    self.counts.revoked += 1;
                } else {
                    seen.provisional = seen.provisional.max(granted);
                }
                seen.limit();
                (takes_back && self.counts.stop_requests == 0).then_some(Violation::GrantOrder {
                    federate,
                    granted,
                    before,
                })
            }
            Message::StopGranted(wire) => {
                seen.stop = Some(from_wire(wire));
                seen.named = None;
                None
            }
            Message::Stop => {
                seen.is_told_to_stop = true;
                None
            }
            _ => None,
        };
        if let Some(violation) = violation {
            self.report(violation);
        }
    }
}

#[cfg(test)]
mod tests {
    use lf_coordination::to_wire;
    use lf_model::time::Instant;
    use lf_testkit::messages::encoded;

    use super::*;

    fn at(ns: i64) -> Tag {
        Tag::at(Instant::from_nanos(ns))
    }

    /// Returns the tag before which all messages of the first of two federates count.
    fn announced(said: &[Message<'_>], heard: &[Message<'_>]) -> Tag {
        let mut watch = Watch::of(vec![(0, false), (1, false)]);
        watch.begin(0, 1, 0);
        let said: Vec<u8> = said.iter().flat_map(encoded).collect();
        watch.write(0, 0, &said, 0, 0);
        watch.read(0, 0, said.len(), 0);
        let heard: Vec<u8> = heard.iter().flat_map(encoded).collect();
        watch.write(0, 1, &heard, 0, 0);
        watch.seen[0].announced
    }

    #[test]
    fn a_message_at_a_stop_is_not_announced_before() {
        let next = Message::NextEventTag(to_wire(at(9)));
        for named in [Message::StopReply(to_wire(at(5))), Message::StopRequest(to_wire(at(5)))] {
            assert_eq!([announced(&[next], &[]), announced(&[next, named], &[])], [at(9), at(5)]);
        }
    }

    #[test]
    fn messages_that_the_rti_holds_of_an_expelled_federate_are_lost() {
        let sent = Message::TaggedMessage { port: 0, federate: 1, tag: to_wire(at(5)), payload: &[] };
        let said = [sent, Message::NextEventTag(to_wire(at(9)))];
        // A message that it has sent does not matter while nothing is lost.
        assert_eq!([announced(&said, &[]), announced(&said, &[Message::Failed])], [at(9), at(5)]);
    }
}
