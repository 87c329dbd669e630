// SPDX-License-Identifier: Apache-2.0
//! Reads along on every connection: no grant may be violated by a later message.

use lf_coordination::from_wire;
use lf_model::time::Tag;
use lf_testkit::random::combine;
use lf_wire::{Decoded, Limits, Message, decode};

use super::Violation;
use super::direct::{Direct, Written};

/// How often messages of some kinds were seen.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    pub(crate) messages: u64,
    pub(crate) data: u64,
    pub(crate) grants: u64,
    pub(crate) provisional: u64,
    pub(crate) absent: u64,
    pub(crate) dnet: u64,
    pub(crate) stop_requests: u64,
    pub(crate) taken_back: u64,
    /// Messages of the RTI and to it that decentralized coordination has no use for.
    pub(crate) centralized: u64,
}

impl Counts {
    /// Counts what has been written to another federate.
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

/// What is known of one federate from its connection.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    granted: Tag,
    provisional: Tag,
    /// Before this tag all is complete, and all that was sent has come to the RTI.
    pub(crate) announced: Tag,
    /// Messages that were sent to it, and that it has not completed.
    in_transit: Vec<Tag>,
    /// By port number: the tag of the last message, how many there were for it, and the most for any.
    bursts: Vec<(Tag, usize, usize)>,
    /// The stop that it has named, while the RTI has not decided.
    named: Option<Tag>,
    /// It has had its say about the stop.
    pub(crate) has_named: bool,
    /// The stop that was granted.
    pub(crate) stop: Option<Tag>,
    /// When the RTI heard that it has left.
    pub(crate) left: Option<u64>,
}

impl Seen {
    /// It will not begin this tag or a later one before the RTI has decided, whatever is granted.
    fn name_stop(&mut self, named: Tag) {
        (self.named, self.has_named) = (Some(named), true);
        self.limit();
    }

    /// It says that all before this tag is complete; messages that it had not seen then may come before.
    ///
    /// One that has named a tag to stop at may have another event before what it tells: the stop.
    fn announce(&mut self, tag: Tag) {
        let stop = self.stop.or(self.named).filter(|_| tag != Tag::FOREVER).unwrap_or(Tag::FOREVER);
        let tag = tag.min(stop);
        self.announced = self.in_transit.iter().copied().min().unwrap_or(Tag::FOREVER).min(tag);
    }

    fn count(&mut self, port: usize, tag: Tag) {
        if self.bursts.len() <= port {
            self.bursts.resize(port + 1, (Tag::NEVER, 0, 0));
        }
        let (last, count, most) = &mut self.bursts[port];
        *count = if *last == tag { *count + 1 } else { 1 };
        (*last, *most) = (tag, (*most).max(*count));
    }

    /// The most messages that came for one tag at the input with this port number.
    pub(crate) fn burst(&self, port: u16) -> usize {
        self.bursts.get(usize::from(port)).map_or(0, |(_, _, most)| *most)
    }

    fn limit(&mut self) {
        if let Some(named) = self.named {
            self.granted = self.granted.min(named.before());
            self.provisional = self.provisional.min(named);
        }
    }
}

/// Both directions of a connection: the bytes that are no whole message yet.
#[derive(Debug, Default)]
struct Tap {
    federate: usize,
    to_rti: Vec<u8>,
    /// How many of these bytes the RTI has read.
    read: usize,
    from_rti: Vec<u8>,
}

/// Reads along on every connection.
#[derive(Debug)]
pub(crate) struct Watch {
    taps: Vec<Tap>,
    pub(crate) seen: Vec<Seen>,
    /// The connections between federates.
    pub(crate) direct: Direct,
    pub(crate) counts: Counts,
    /// A hash of all that was written, when and where.
    pub(crate) digest: u64,
    pub(crate) violation: Option<Violation>,
    /// Whether all messages are printed, as they are read by the RTI and written by it.
    pub(crate) prints: bool,
}

/// Whether a message grants tags, asks for that, or goes through the RTI to another federate.
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

impl Watch {
    pub(crate) fn new(federates: usize) -> Self {
        let seen = Seen {
            granted: Tag::NEVER,
            provisional: Tag::NEVER,
            announced: Tag::NEVER,
            in_transit: Vec::new(),
            bursts: Vec::new(),
            named: None,
            has_named: false,
            stop: None,
            left: None,
        };
        Self {
            taps: Vec::new(),
            direct: Direct::default(),
            seen: vec![seen; federates],
            counts: Counts::default(),
            digest: 0,
            violation: None,
            prints: false,
        }
    }

    /// A connection of this participant to the RTI; connections are numbered one after the other.
    pub(crate) fn begin(&mut self, connection: usize, participant: usize, host: usize) {
        self.taps.resize_with(connection + 1, Tap::default);
        self.taps[connection].federate = participant.saturating_sub(1);
        if host > 0 {
            self.direct.begin(connection, participant.saturating_sub(1), host - 1);
        }
    }

    /// Somebody has written what arrives at a time; side 0 is the one that connected: a federate.
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

    /// So many bytes of a direction were read.
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

    /// Looks at the whole messages.
    fn follow(&mut self, connection: usize, direction: usize, now: u64) {
        let tap = &mut self.taps[connection];
        let federate = tap.federate;
        let bytes = std::mem::take(if direction == 0 { &mut tap.to_rti } else { &mut tap.from_rti });
        let end = if direction == 0 { tap.read } else { bytes.len() };
        let mut at = 0;
        while at < end {
            match decode(&bytes[at..end], &Limits::NONE) {
                Ok(Decoded::Complete { message, len }) => {
                    at += len;
                    self.counts.messages += 1;
                    self.counts.centralized += u64::from(is_centralized(&message));
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
            tap.to_rti = rest;
        } else {
            tap.from_rti = rest;
        }
    }

    fn report(&mut self, violation: Violation) {
        self.violation.get_or_insert(violation);
    }

    fn hear_federate(&mut self, federate: usize, message: &Message<'_>, now: u64) {
        if let Message::TaggedMessage { federate: to, tag: wire, .. } = *message
            && let Some(receiver) = self.seen.get_mut(usize::from(to))
        {
            receiver.in_transit.push(from_wire(wire));
            receiver.announce(receiver.announced);
        }
        let Some(seen) = self.seen.get_mut(federate) else { return };
        match *message {
            Message::NextEventTag(next) => seen.announce(from_wire(next)),
            Message::LatestTagComplete(last) => {
                seen.in_transit.retain(|message| *message > from_wire(last));
                seen.announce(seen.announced.max(from_wire(last).next_microstep()));
            }
            Message::StopRequest(named) => {
                self.counts.stop_requests += 1;
                seen.name_stop(from_wire(named));
            }
            Message::StopReply(named) => seen.name_stop(from_wire(named)),
            Message::Resign => seen.left = Some(now),
            _ => {}
        }
    }

    fn hear_rti(&mut self, federate: usize, message: &Message<'_>) {
        let Some(seen) = self.seen.get_mut(federate) else { return };
        let violation = match *message {
            Message::TaggedMessage { tag: wire, port, .. } => {
                self.counts.data += 1;
                seen.count(usize::from(port), from_wire(wire));
                let message = from_wire(wire);
                let violated = |grant, granted| Violation::GrantViolated { federate, grant, granted, message };
                if message <= seen.granted {
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
                // Before a stop, grants from that tag on are taken back.
                (granted < before && seen.named.is_none()).then_some(Violation::GrantOrder {
                    federate,
                    granted,
                    before,
                })
            }
            Message::ProvisionalTagGrant(wire) => {
                self.counts.provisional += 1;
                let (granted, before) = (from_wire(wire), seen.granted);
                // A PTAG of the stop tag takes back what was granted from there on.
                let takes_back = granted <= before;
                if takes_back {
                    (seen.granted, seen.provisional) = (granted.before(), granted);
                    self.counts.taken_back += 1;
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
            Message::PortAbsent { .. } => {
                self.counts.absent += 1;
                None
            }
            Message::DownstreamNextEventTag(_) => {
                self.counts.dnet += 1;
                None
            }
            _ => None,
        };
        if let Some(violation) = violation {
            self.report(violation);
        }
    }
}
