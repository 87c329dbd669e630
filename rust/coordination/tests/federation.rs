// SPDX-License-Identifier: Apache-2.0
//! Federates and the RTI of this crate, together, in random graphs: whatever the speeds of the participants and the
//! splits of the byte streams, every federate sees the same events at the same tags, and all come to their end.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

mod rti_support;

use std::collections::{BTreeMap, BTreeSet};

use lf_coordination::FederateId;
use lf_coordination::federate::{ClockSync, Config, Disconnected, Event, Federate, Phase};
use lf_coordination::rti::{ClockSync as RtiClockSync, Config as RtiConfig, ConnectionId, Outcome, Status, WINDOW};
use lf_model::time::{Instant, Interval, Tag};
use lf_wire::Limits;
use lf_wire::june_2026::{DELAY_NONE, Decoded, Message, decode};
use proptest::collection::vec;
use proptest::prelude::*;
use rti_support::{Sizes, World};

/// The time-out of every program, in ns after the start.
const END_NS: i64 = 40;
/// Longer than any payload here: answers to stop requests are looked for in as many bytes.
const PAYLOAD_MAX: usize = 1 << 16;
/// So many turns are far more than any of these federations needs.
const TURNS_MAX: usize = 200_000;

/// A connection between federates; its place in the list is its port.
#[derive(Clone, Copy, Debug)]
struct Edge {
    from: u16,
    to: u16,
    /// `None`: no `after`.
    delay: Option<Interval>,
}

#[derive(Clone, Debug)]
struct Graph {
    edges: Vec<Edge>,
    /// Period of each federate's timer in ns; 0 for none.
    periods: Vec<i64>,
}

fn any_graph() -> impl Strategy<Value = Graph> {
    (2..6u16).prop_flat_map(|federates| {
        let edge = (0..federates, 0..federates, 0..4i64, 1..12i64).prop_map(|(from, to, kind, ns)| {
            // Backwards only with a delay that has a time, so that there are cycles, but none without delay.
            let delay = match kind {
                0 if from < to => Some(Interval::ZERO),
                1 | 2 if from < to => None,
                _ => Some(Interval(ns)),
            };
            Edge { from, to, delay }
        });
        let periods = vec(prop_oneof![1 => Just(0i64), 3 => 1..15i64], usize::from(federates));
        (vec(edge, 1..10), periods).prop_map(|(edges, periods)| Graph { edges, periods })
    })
}

/// What a federate has seen: the inputs at each of its tags, as (port, value).
type Trace = BTreeMap<Tag, BTreeSet<(u16, u32)>>;

struct Participant {
    federate: Federate<'static>,
    connection: ConnectionId,
    period: i64,
    /// Its connections to others, with their ports.
    outputs: Vec<(u16, Edge)>,
    events: Trace,
    trace: Trace,
    incoming: Vec<u8>,
    outgoing: Vec<u8>,
    /// Bytes of `outgoing` beyond which there is no room for control messages.
    room: usize,
    closed: bool,
}

impl Participant {
    fn new(id: u16, graph: &Graph, world: &mut World, room: usize) -> Self {
        let numbered = || (0..).zip(graph.edges.iter().copied());
        let mut upstream: BTreeMap<u16, i64> = BTreeMap::new();
        for edge in graph.edges.iter().filter(|edge| edge.to == id) {
            let delay = edge.delay.map_or(DELAY_NONE, Interval::as_nanos);
            upstream.entry(edge.from).and_modify(|least| *least = delay.min(*least)).or_insert(delay);
        }
        let downstream: BTreeSet<u16> = graph.edges.iter().filter(|edge| edge.from == id).map(|edge| edge.to).collect();
        let mut config = Config::new(FederateId(id), b"random");
        // Tests end soon, so their memory may stay.
        config.upstream = upstream.into_iter().collect::<Vec<_>>().leak();
        config.downstream = downstream.into_iter().collect::<Vec<_>>().leak();
        config.clock_sync = if id.is_multiple_of(2) { ClockSync::Init { trials: 3 } } else { ClockSync::Off };
        let mut federate = Federate::new(config).unwrap();
        federate.handle_connected(world.now);
        Self {
            federate,
            connection: world.connect(),
            period: graph.periods[usize::from(id)],
            outputs: numbered().filter(|(_, edge)| edge.from == id).collect(),
            events: BTreeMap::new(),
            trace: BTreeMap::new(),
            incoming: Vec::new(),
            outgoing: Vec::new(),
            room,
            closed: false,
        }
    }

    /// Bytes come from the RTI; every whole message is handled.
    fn receive(&mut self, now: Instant, bytes: &[u8]) {
        self.incoming.extend(bytes);
        let incoming = std::mem::take(&mut self.incoming);
        let mut rest = &incoming[..];
        while let Decoded::Complete { message, len } = decode(rest, &Limits::NONE).unwrap() {
            match self.federate.handle_message(now, message).unwrap() {
                Event::Started(start) => {
                    self.federate.limit_stop(Tag::at(start + Interval(END_NS)));
                    self.events.insert(Tag::at(start), BTreeSet::new());
                }
                Event::Message { port, tag, payload } => {
                    let value = u32::from_le_bytes(payload.try_into().unwrap());
                    self.events.entry(tag).or_default().insert((port, value));
                }
                _ => {}
            }
            rest = &rest[len..];
            self.tell(now);
        }
        self.incoming = rest.to_vec();
    }

    /// Each input has to hold what is before the tag where its sender is, and what the delay keeps on its way.
    fn check_queues(&self, graph: &Graph, window: usize) {
        for (port, edge) in (0..).zip(&graph.edges) {
            // A sender has a tag each nanosecond, and with `after 0` a microstep for every federate at most.
            let delay = edge.delay.map_or(0, |delay| usize::try_from(delay.as_nanos()).unwrap());
            let microsteps = if edge.delay.is_some() { graph.periods.len() } else { 1 };
            let capacity = window + (2 * delay + 1) * microsteps;
            let pending = self.events.values().flatten().filter(|(input, _)| *input == port).count();
            assert!(pending <= capacity, "{pending} of {capacity} at {port} of {edge:?}");
        }
    }

    /// Tells the next event, and moves control messages to the out-buffer as far as there is room.
    fn tell(&mut self, now: Instant) {
        let next = self.next();
        self.federate.next_event(now, next);
        while let Some(message) = self.federate.poll_transmit(self.room.saturating_sub(self.outgoing.len())) {
            push(&mut self.outgoing, &message);
        }
    }

    fn last(&self) -> Tag {
        let end = self.federate.start_time().map_or(Tag::FOREVER, |start| Tag::at(start + Interval(END_NS)));
        end.min(self.federate.stop_tag().unwrap_or(Tag::FOREVER))
    }

    fn next(&self) -> Tag {
        self.events.keys().next().copied().unwrap_or(Tag::FOREVER).min(self.last())
    }

    /// Runs the next tag, if it may be begun; at `stop_at`, asks the federation to stop.
    fn run(&mut self, now: Instant, stop_at: Option<i64>) -> bool {
        // What is told of a tag goes before the messages of the next one.
        self.tell(now);
        let tag = self.next();
        if self.federate.has_transmit() || !self.federate.next_event(now, tag) {
            return false;
        }
        self.federate.begin(tag).unwrap();
        let start = self.federate.start_time().unwrap();
        // At the last tag there may be no event; then the program does nothing.
        let event = self.events.remove(&tag);
        let acts = event.is_some();
        let inputs = event.unwrap_or_default();
        let offset = tag.time.since(start).as_nanos();
        for (port, edge) in self.outputs.clone() {
            // A value that depends on all that was seen; some tags send nothing.
            let seen = inputs.iter().fold(u32::from(port) * 7 + 1, |sum, (port, value)| {
                sum.wrapping_mul(31).wrapping_add(u32::from(*port)).wrapping_mul(31).wrapping_add(*value)
            });
            let at = tag.delayed(edge.delay);
            if seen.wrapping_add(u32::try_from(offset).unwrap()) % 3 != 0 && acts && self.federate.may_send(at) {
                let wire = lf_wire::Tag::new(at.time.as_nanos(), at.microstep.0);
                let payload = seen.to_le_bytes();
                push(
                    &mut self.outgoing,
                    &Message::TaggedMessage { port, federate: edge.to, tag: wire, payload: &payload },
                );
                self.federate.sent(at);
            }
        }
        if self.period > 0 && offset % self.period == 0 && tag.microstep.0 == 0 {
            self.events.entry(Tag::at(tag.time + Interval(self.period))).or_default();
        }
        let had_input = !inputs.is_empty();
        self.trace.insert(Tag::new(Instant(offset), tag.microstep), inputs);
        self.federate.complete(had_input);
        if stop_at.is_some_and(|at| at <= offset) {
            self.federate.request_stop(tag.next_microstep());
        }
        if tag == self.last() {
            self.federate.finish();
        }
        self.tell(now);
        true
    }
}

fn push(target: &mut Vec<u8>, message: &Message<'_>) {
    let start = target.len();
    target.resize(start + message.encoded_len(), 0);
    message.encode(&mut target[start..]).unwrap();
}

/// Who is next, and how much it does.
struct Choice(u64);

impl Choice {
    /// Below `bound`, by xorshift.
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 >> 11).unwrap() % bound
    }
}

/// How a federation is run.
#[derive(Clone, Copy, Debug)]
struct Manner {
    /// Decides on speeds and splits.
    seed: u64,
    /// Bytes of every federate's output.
    room: usize,
    dnet: bool,
    window: usize,
    /// This federate runs one tag where others may run many.
    slow: Option<usize>,
    /// Who asks to stop, and when.
    stop: Option<(usize, i64)>,
}

impl Manner {
    fn usual(seed: u64) -> Self {
        Self { seed, room: 1 << 16, dnet: true, window: WINDOW, slow: None, stop: None }
    }
}

/// Runs a federation to its end; returns what each federate has seen.
fn run(graph: &Graph, manner: Manner) -> Vec<Trace> {
    let Manner { seed, room, dnet, window, slow, stop } = manner;
    let count = graph.periods.len();
    let clock_sync = RtiClockSync::Init { trials: 3 };
    let config = RtiConfig { clock_sync, dnet, window, ..RtiConfig::new(b"random", PAYLOAD_MAX) };
    let mut world = World::new(config, Sizes { output: 128, ..Sizes::ample(count) });
    let mut participants: Vec<_> = (0..).take(count).map(|id| Participant::new(id, graph, &mut world, room)).collect();
    let mut choice = Choice(seed | 1);
    for _ in 0..TURNS_MAX {
        if participants.iter().all(|participant| participant.closed) {
            break;
        }
        let index = choice.below(count);
        let participant = &mut participants[index];
        let connection = participant.connection;
        world.now = world.now + Interval(1);
        let now = world.now;
        match choice.below(3) {
            _ if participant.closed => {}
            0 => {
                let bytes = world.take(connection, choice.below(40) + 1);
                participant.receive(now, &bytes);
                participant.check_queues(graph, window);
            }
            1 => {
                let len = (choice.below(60) + 1).min(participant.outgoing.len());
                let bytes: Vec<u8> = participant.outgoing.drain(..len).collect();
                if participant.outgoing.is_empty() {
                    participant.federate.handle_written(now);
                }
                participant.tell(now);
                world.send(connection, &bytes);
            }
            _ if slow == Some(index) && choice.below(40) > 0 => {}
            _ => {
                let stop_at = stop.filter(|(who, _)| *who == index).map(|(_, at)| at);
                participant.run(now, stop_at);
            }
        }
        // The RTI ends its direction when it has read the RESIGN.
        let ended = world.outlet.list[connection.0].ended;
        if participant.federate.phase() == Phase::Ended && ended && !participant.closed {
            assert_eq!(participant.federate.handle_disconnected(), Ok(Disconnected::Ended));
            world.close(connection);
            participant.closed = true;
        }
    }
    let stuck: Vec<_> = participants.iter().filter(|participant| !participant.closed).map(|p| &p.federate).collect();
    assert!(stuck.is_empty(), "these have not come to their end: {stuck:#?}");
    assert_eq!(world.rti.status(), Status::Finished(Outcome::Complete));
    // Who has come to its time-out before somebody asks is not told any more.
    let stop_tags: BTreeSet<_> =
        participants.iter().filter_map(|participant| participant.federate.stop_tag()).collect();
    assert!(stop_tags.len() <= 1, "{stop_tags:?}");
    participants.into_iter().map(|participant| participant.trace).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Speed, room and DNETs make no difference to what the federates see.
    #[test]
    fn what_is_seen_does_not_depend_on_the_speed(graph in any_graph(), seeds: [u64; 3], small in 75..100usize) {
        let reference = run(&graph, Manner::usual(seeds[0]));
        prop_assert_eq!(&run(&graph, Manner { room: small, ..Manner::usual(seeds[1]) }), &reference);
        prop_assert_eq!(&run(&graph, Manner { dnet: false, ..Manner::usual(seeds[2]) }), &reference);
    }

    /// A slow federate makes others wait, which makes no difference either, in cycles neither; and it never has more
    /// in its queues than they are made for.
    #[test]
    fn what_is_seen_does_not_depend_on_the_window(
        graph in any_graph(),
        seeds: [u64; 2],
        window in 1..4usize,
        slow: usize,
        dnet: bool,
    ) {
        let reference = run(&graph, Manner::usual(seeds[0]));
        let slow = Some(slow % graph.periods.len());
        prop_assert_eq!(&run(&graph, Manner { dnet, window, slow, ..Manner::usual(seeds[1]) }), &reference);
    }

    /// A stop ends all federates at one tag, and until then makes no difference.
    #[test]
    fn all_stop_at_one_tag(
        graph in any_graph(),
        seeds: [u64; 2],
        who: usize,
        at in 0..END_NS,
        window in 1..4usize,
        slow: usize,
    ) {
        let reference = run(&graph, Manner::usual(seeds[0]));
        let (stop, slow) = (Some((who % graph.periods.len(), at)), Some(slow % graph.periods.len()));
        let stopped = run(&graph, Manner { window, slow, stop, ..Manner::usual(seeds[1]) });
        for (all, seen) in reference.iter().zip(&stopped) {
            // The last tag is one more event, which has no inputs of its own.
            let last = seen.keys().next_back();
            for (tag, inputs) in seen {
                prop_assert!(all.get(tag) == Some(inputs) || (Some(tag) == last && inputs.is_empty()), "{tag:?}");
            }
            prop_assert!(all.keys().filter(|tag| Some(*tag) <= last).all(|tag| seen.contains_key(tag)));
        }
    }
}
