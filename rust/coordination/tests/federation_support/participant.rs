// SPDX-License-Identifier: Apache-2.0
//! A federate of a random federation, with its program and its buffers.

use std::collections::{BTreeMap, BTreeSet};

use lf_coordination::federate::{
    Awaited, AwaitedInput, ClockSync, Config, Event, Federate, FederateError, Needs, Phase,
};
use lf_coordination::rti::ConnectionId;
use lf_coordination::{FederateId, WINDOW, to_wire};
use lf_model::time::{Instant, Interval, Tag};
use lf_testkit::messages::encoded;
use lf_wire::{DELAY_NONE, Decoded, Limits, Message, decode, decode_to_transient};

use super::graph::{END_NS, Edge, Graph, Inputs, Trace};
use lf_testkit::rti::Rig;

/// The tag that is open.
struct Open {
    tag: Tag,
    fires: bool,
    inputs: Inputs,
    /// The number of outputs that are done.
    done: usize,
}

pub(crate) struct Participant<N: Needs> {
    pub(crate) federate: Federate<'static, N>,
    pub(crate) connection: ConnectionId,
    pub(crate) id: u16,
    graph: Graph,
    awaited: Awaited<'static>,
    /// The connections to others, with their ports.
    outputs: Vec<(u16, Edge)>,
    timer: Option<Tag>,
    messages: BTreeMap<Tag, Inputs>,
    open: Option<Open>,
    pub(crate) trace: Trace,
    /// Its messages: port, tag and value.
    pub(crate) sent: Vec<(u16, Tag, u32)>,
    /// Its first tag, and the last one if it stops alone.
    first: Option<Tag>,
    alone: Tag,
    incoming: Vec<u8>,
    pub(crate) outgoing: Vec<u8>,
    /// The number of bytes in `outgoing` beyond which there is no room for control messages.
    room: usize,
    pub(crate) closed: bool,
}

/// Returns the level of sending over a connection.
fn send_level(port: u16) -> u16 {
    2 * port + 1
}

/// Returns the lowest level of reactions to a connection's values.
fn input_level(port: u16) -> u16 {
    2 * port + 2
}

// Tests end soon, so their memory may leak.
fn leak<T>(items: impl IntoIterator<Item = T>) -> &'static mut [T] {
    items.into_iter().collect::<Vec<_>>().leak()
}

impl<N: Needs> Participant<N> {
    /// Returns a federate that offers this window, or none.
    pub(crate) fn new(id: u16, graph: &Graph, rig: &mut Rig, room: usize, offer: u16) -> Self {
        Self::with_transients(id, graph, rig, room, &[], offer)
    }

    /// Returns a federate of a federation in which these are transient, which may be one of them.
    pub(crate) fn with_transients(
        id: u16,
        graph: &Graph,
        rig: &mut Rig,
        room: usize,
        transients: &'static [u16],
        offer: u16,
    ) -> Self {
        let mut upstream: BTreeMap<u16, i64> = BTreeMap::new();
        for edge in graph.edges.iter().filter(|edge| edge.to == id) {
            let delay = edge.delay.map_or(DELAY_NONE, Interval::as_nanos);
            upstream.entry(edge.from).and_modify(|least| *least = delay.min(*least)).or_insert(delay);
        }
        let downstream: BTreeSet<u16> = graph.edges.iter().filter(|edge| edge.from == id).map(|edge| edge.to).collect();
        let mut config = Config::with_needs(FederateId(id), b"random");
        config.upstream = leak(upstream);
        config.downstream = leak(downstream);
        config.transients = transients;
        config.window = offer;
        config.clock_sync = if id.is_multiple_of(2) { ClockSync::Init { trials: 3 } } else { ClockSync::Off };
        let awaited = graph.numbered().filter(|(_, edge)| edge.to == id && graph.is_awaited(*edge));
        let inputs: &[_] = leak(awaited.map(|(port, _)| AwaitedInput { port, level: input_level(port) }));
        let mut federate = Federate::new(config).unwrap();
        federate.handle_connected(rig.now, [0; 8]);
        let mut awaited = Awaited::new(inputs, leak(inputs.iter().map(|_| Tag::NEVER))).unwrap();
        for (port, edge) in graph.numbered().filter(|(_, edge)| transients.contains(&edge.from)) {
            if edge.to == id {
                awaited.learn(port, Tag::FOREVER);
            }
        }
        Self {
            federate,
            connection: rig.connect(),
            id,
            graph: graph.clone(),
            awaited,
            outputs: graph.numbered().filter(|(_, edge)| edge.from == id).collect(),
            timer: None,
            messages: BTreeMap::new(),
            open: None,
            trace: BTreeMap::new(),
            sent: Vec::new(),
            first: None,
            alone: Tag::FOREVER,
            incoming: Vec::new(),
            outgoing: Vec::new(),
            room,
            closed: false,
        }
    }

    /// Receives bytes from the RTI, and handles every whole message.
    pub(crate) fn receive(&mut self, now: Instant, bytes: &[u8]) {
        assert_eq!(self.try_receive(now, bytes), Ok(true));
    }

    /// Does the same, where it may be an error. Returns `false` if its id is in use.
    pub(crate) fn try_receive(&mut self, now: Instant, bytes: &[u8]) -> Result<bool, FederateError> {
        self.incoming.extend(bytes);
        let incoming = std::mem::take(&mut self.incoming);
        let mut rest = &incoming[..];
        while let Decoded::Complete { message, len } = self.decode(rest) {
            match self.federate.handle_message(now, message)? {
                Event::IdInUse => return Ok(false),
                Event::Started(start) => self.begin(start, Tag::at(start)),
                Event::Joined { start, tag } => self.begin(start, tag),
                Event::UpstreamCame(federate) => {
                    let provisional = self.federate.granted_provisionally().unwrap_or(Tag::NEVER);
                    let known = self.federate.granted().max(provisional);
                    self.of(federate).into_iter().for_each(|port| self.awaited.forget(port, known));
                }
                Event::UpstreamLeft(federate) => {
                    self.of(federate).into_iter().for_each(|port| self.awaited.learn(port, Tag::FOREVER));
                }
                Event::Replaced if self.federate.phase() == Phase::Running => self.leave(),
                Event::Replaced => self.federate.finish(),
                Event::Message { port, tag, payload } => {
                    self.deliver(port, tag, u32::from_le_bytes(payload.try_into().unwrap()));
                    self.awaited.learn(port, tag);
                }
                Event::PortAbsent { port, tag } => self.awaited.learn(port, tag),
                _ => {}
            }
            rest = &rest[len..];
            self.announce(now);
        }
        self.incoming = rest.to_vec();
        Ok(true)
    }

    fn decode<'b>(&self, bytes: &'b [u8]) -> Decoded<'b> {
        let awaits_start = self.federate.is_transient() && self.federate.phase() < Phase::Running;
        if awaits_start { decode_to_transient(bytes, &Limits::NONE, |_| true) } else { decode(bytes, &Limits::NONE) }
            .unwrap()
    }

    fn begin(&mut self, start: Instant, first: Tag) {
        self.federate.limit_stop(Tag::at(start + Interval::from_nanos(END_NS)).max(first));
        (self.timer, self.first) = (Some(first), Some(first));
    }

    /// Returns the ports over which a federate sends to this one.
    fn of(&self, federate: FederateId) -> Vec<u16> {
        let edges = self.graph.numbered().filter(|(_, edge)| edge.from == federate.0 && edge.to == self.id);
        edges.map(|(port, _)| port).collect()
    }

    /// Stops alone, one microstep after the current tag.
    pub(crate) fn leave(&mut self) {
        let current = self.open.as_ref().map_or(self.federate.current(), |open| open.tag);
        let next = current.next_microstep().max(self.first.unwrap_or(Tag::NEVER));
        self.alone = self.alone.min(next);
    }

    /// Returns whether it knows its first tag.
    pub(crate) fn has_begun(&self) -> bool {
        self.first.is_some()
    }

    /// Returns the first tag and the last one of this instance, if it has completed a tag.
    pub(crate) fn span(&self) -> Option<(Tag, Tag)> {
        let last = self.federate.current();
        self.first.filter(|first| *first <= last).map(|first| (first, last))
    }

    /// Asserts that each input holds at most the messages before the sender's tag, and those that the delay keeps in
    /// transit. While a stop is being agreed, it may also hold those by which the sender is ahead of the RTI. Both
    /// windows are the one on which all have `agreed`, if that is larger.
    pub(crate) fn check_queues(&self, window: u16, agreed: u16) {
        for (port, edge) in self.graph.numbered() {
            // A sender has a tag each nanosecond, and with `after 0` a microstep for every federate at most.
            let delay = edge.delay.map_or(0, |delay| usize::try_from(delay.as_nanos()).unwrap());
            let microsteps = if edge.delay.is_some() { self.graph.periods.len() } else { 1 };
            let windows = usize::from(window.max(agreed)) + usize::from(WINDOW.max(agreed));
            let capacity = windows + (2 * delay + 1) * microsteps;
            let pending = self.messages.values().flatten().filter(|(input, _)| *input == port).count();
            assert!(pending <= capacity, "{pending} of {capacity} at {port} of {edge:?}");
        }
    }

    fn deliver(&mut self, port: u16, tag: Tag, value: u32) {
        let Some(open) = self.open.as_mut().filter(|open| open.tag == tag) else {
            self.messages.entry(tag).or_default().insert((port, value));
            return;
        };
        let passed = self.outputs[..open.done].last().map_or(0, |(output, _)| send_level(*output) + 1);
        assert!(passed <= input_level(port), "the message for port {port} at {tag} is late: {:#?}", self.federate);
        open.inputs.insert((port, value));
    }

    /// Announces the next event, and moves control messages to the out-buffer as far as there is room.
    pub(crate) fn announce(&mut self, now: Instant) {
        let next = self.next();
        self.federate.next_event(now, next);
        while let Some(message) = self.federate.poll_transmit(self.room.saturating_sub(self.outgoing.len())) {
            self.outgoing.extend(encoded(&message));
        }
    }

    fn last(&self) -> Tag {
        let end =
            self.federate.start_time().map_or(Tag::FOREVER, |start| Tag::at(start + Interval::from_nanos(END_NS)));
        let end = end.max(self.first.unwrap_or(Tag::NEVER)).min(self.federate.stop_tag().unwrap_or(Tag::FOREVER));
        end.min(self.alone)
    }

    fn next(&self) -> Tag {
        let message = self.messages.first_key_value().map(|(tag, _)| *tag);
        self.timer.into_iter().chain(message).chain([self.last()]).min().unwrap()
    }

    /// Begins the next tag or continues the open one, as far as allowed; at `stop_at`, requests a stop of the
    /// federation. Returns whether a tag was open.
    pub(crate) fn run(&mut self, now: Instant, stop_at: Option<i64>) -> bool {
        if self.open.is_none() {
            // Announcements about a tag go before the messages of the next one.
            self.announce(now);
            let next = self.next();
            let tag = self.federate.demanded_tag().map_or(next, |demanded| demanded.min(next));
            if self.federate.has_transmit() || !self.federate.may_advance(tag) {
                return false;
            }
            self.federate.begin(tag).unwrap();
            let fires = self.timer == Some(tag);
            if fires {
                self.timer = self.graph.next_timer(self.id, tag);
            }
            self.open = Some(Open { tag, fires, inputs: self.messages.remove(&tag).unwrap_or_default(), done: 0 });
        }
        let limit = self.awaited.max_level(&self.federate);
        let Some(mut open) = self.open.take() else { return false };
        let done_before = open.done;
        while let Some((port, edge)) = self.outputs.get(open.done).copied() {
            if limit.is_some_and(|limit| send_level(port) >= limit) {
                break;
            }
            self.send(&open, port, edge);
            open.done += 1;
        }
        let goes_on = limit.is_none() || open.done > done_before;
        if limit.is_some() {
            self.open = Some(open);
        } else {
            self.complete(open, stop_at);
        }
        self.announce(now);
        goes_on
    }

    fn send(&mut self, open: &Open, port: u16, edge: Edge) {
        let at = open.tag.delayed(edge.delay);
        if !self.federate.may_send(at) {
            return;
        }
        let offset = self.offset(open.tag);
        let (tag, federate) = (to_wire(at), edge.to);
        if let Some(value) = self.graph.value(port, offset, open.fires, &open.inputs) {
            let payload = value.to_le_bytes();
            self.outgoing.extend(encoded(&Message::TaggedMessage { port, federate, tag, payload: &payload }));
            self.federate.sent();
            self.sent.push((port, at, value));
        } else if self.graph.tells_absence(edge) {
            self.outgoing.extend(encoded(&Message::PortAbsent { port, federate, tag }));
        }
    }

    fn complete(&mut self, open: Open, stop_at: Option<i64>) {
        let Open { tag, fires, inputs, .. } = open;
        let offset = self.offset(tag);
        self.federate.complete(!inputs.is_empty());
        // Without an event the tag has only announced absences.
        if fires || !inputs.is_empty() || tag == self.last() {
            self.trace.insert(Tag::new(Instant::from_nanos(offset), tag.microstep), inputs);
        }
        if stop_at.is_some_and(|at| at <= offset) {
            self.federate.request_stop(tag.next_microstep());
        }
        if tag == self.last() {
            self.federate.finish();
        }
    }

    fn offset(&self, tag: Tag) -> i64 {
        tag.time.since(self.federate.start_time().unwrap()).as_nanos()
    }
}
