// SPDX-License-Identifier: Apache-2.0
//! Federates and the RTI of this crate, together, in random graphs in which some federates are transient: they are
//! absent at the start, join, leave in order, crash, come back and are swapped at any moment.
//!
//! Invariants of every run: no message comes after its tag was granted, and no tag is over before a later incarnation
//! (the machines say so); nobody waits without end; what a federate receives was sent to it, at most once; nothing is
//! lost that was sent in order to a federate which is there at its tag; the incarnations of a federate follow each
//! other in tags.

use std::collections::{BTreeMap, BTreeSet};

use crate::federation_support::graph::{Graph, any_graph};
use crate::federation_support::participant::Participant;
use lf_coordination::federate::{FederateError, Phase};
use lf_coordination::rti::{ClockSync as RtiClockSync, Config as RtiConfig, ConnectionId, Outcome, Status};
use lf_model::time::{Instant, Interval, Tag};
use lf_testkit::profiles::CentralizedTransients;
use lf_testkit::random::Random;
use lf_testkit::rti::{Rig, Sizes};
use lf_wire::RejectCode;
use proptest::prelude::*;

const PAYLOAD_MAX: usize = 1 << 16;
const TURNS_MAX: usize = 400_000;
/// Turns without a message or a tag after which only the clock can help.
const IDLE_TURNS: usize = 400;
/// The maximum number of incarnations of a federate.
const INCARNATIONS_MAX: usize = 6;

/// The end of an instance of a federate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum End {
    InOrder,
    Crash,
    /// It came too late, or while another one was about to begin.
    Refused,
}

/// An instance of a federate.
struct Incarnation {
    federate: Participant<CentralizedTransients>,
    end: Option<End>,
    /// The turns in which it has learnt its first tag, and has sent its resignation.
    joined: Option<usize>,
    resigned: Option<usize>,
}

struct Federation<'g> {
    graph: &'g Graph,
    transients: &'static [u16],
    rig: Rig,
    random: Random,
    /// All instances of all federates.
    incarnations: Vec<Incarnation>,
    turns: usize,
    idle: usize,
}

impl<'g> Federation<'g> {
    fn new(graph: &'g Graph, transients: &'static [u16], seed: u64, dnet: bool) -> Self {
        let count = graph.periods.len();
        let config = RtiConfig {
            clock_sync: RtiClockSync::Init { trials: 3 },
            dnet,
            transients: u16::try_from(transients.len()).unwrap(),
            ..RtiConfig::new(b"random", PAYLOAD_MAX)
        };
        let sizes = Sizes { output: 160, connections: 2 * count + 2, ..Sizes::ample(count) };
        let (rig, random) = (Rig::new(config, sizes), Random::new(seed));
        let mut run = Self { graph, transients, rig, random, incarnations: Vec::new(), turns: 0, idle: 0 };
        for id in (0..).take(count) {
            if !transients.contains(&id) || run.random.percent(50) {
                run.join(id);
            }
        }
        run
    }

    fn join(&mut self, id: u16) {
        let federate = Participant::with_transients(id, self.graph, &mut self.rig, 1 << 16, self.transients, 0);
        self.incarnations.push(Incarnation { federate, end: None, joined: None, resigned: None });
    }

    fn is_transient(&self, index: usize) -> bool {
        self.transients.contains(&self.incarnations[index].federate.id)
    }

    /// Runs turn by turn until all have ended.
    fn play(&mut self) {
        for _ in 0..TURNS_MAX {
            self.turns += 1;
            let living: Vec<_> =
                (0..self.incarnations.len()).filter(|index| self.incarnations[*index].end.is_none()).collect();
            if living.is_empty() {
                break;
            }
            self.pass_time();
            self.disturb();
            let index = living[self.random.index(living.len())];
            if self.incarnations[index].end.is_none() {
                let done = self.turn(index);
                self.idle = if done { 0 } else { self.idle + 1 };
            }
        }
        let stuck: Vec<_> = self
            .incarnations
            .iter()
            .filter(|incarnation| incarnation.end.is_none())
            .map(|incarnation| &incarnation.federate.federate)
            .collect();
        assert!(stuck.is_empty(), "these have not come to their end: {stuck:#?}\n{:#?}", self.rig.outlet.log_events);
        assert_eq!(self.rig.rti.status(), Status::Finished(Outcome::Complete));
    }

    /// Lets the clock pass, and at once where only time can help.
    fn pass_time(&mut self) {
        if self.idle < IDLE_TURNS {
            if self.random.percent(20) {
                self.rig.now = self.rig.now + Interval::from_nanos(1);
            }
        } else {
            self.idle = 0;
            let start = self.rig.rti.start_time().filter(|start| *start > self.rig.now + Interval::from_nanos(9));
            self.rig.now =
                start.map_or(self.rig.now + Interval::from_nanos(5), |start| start - Interval::from_nanos(3));
        }
        let now = self.rig.now;
        self.rig.rti.handle_timeout(now, &mut self.rig.outlet);
    }

    /// Has a transient federate come, leave or crash, now and then.
    fn disturb(&mut self) {
        if !self.random.percent(1) {
            return;
        }
        let id = self.random.one_of(self.transients);
        let incarnations: Vec<_> =
            (0..self.incarnations.len()).filter(|index| self.incarnations[*index].federate.id == id).collect();
        let here: Vec<_> =
            incarnations.iter().copied().filter(|index| self.incarnations[*index].end.is_none()).collect();
        let may_come = incarnations.len() < INCARNATIONS_MAX && here.len() < 2;
        match (here.last(), self.random.below(4)) {
            (None, _) | (Some(_), 0) if may_come => self.join(id),
            (Some(index), 1) => {
                self.end(*index, End::Crash);
            }
            (Some(index), _) if self.incarnations[*index].federate.federate.phase() == Phase::Running => {
                self.incarnations[*index].federate.leave();
            }
            _ => {}
        }
    }

    /// Does one turn of an instance; returns whether it has done something.
    fn turn(&mut self, index: usize) -> bool {
        let (kind, now, connection) =
            (self.random.below(3), self.rig.now, self.incarnations[index].federate.connection);
        let pieces = (self.random.count(1, 60), self.random.count(1, 60));
        let instance = &mut self.incarnations[index].federate;
        let done = match kind {
            0 => {
                let bytes = self.rig.take(connection, pieces.0);
                match instance.try_receive(now, &bytes) {
                    Ok(true) => {}
                    Ok(false) | Err(FederateError::Rejected(RejectCode::JoinsTooLate)) => {
                        return self.refused(index, connection);
                    }
                    // The RTI expects nobody any more and closes, which a joiner takes for a loss.
                    Err(error) => panic!("{error}: {:#?}\n{:#?}", instance.federate, self.rig.outlet.log_events),
                }
                !bytes.is_empty()
            }
            1 => {
                let len = pieces.1.min(instance.outgoing.len());
                let bytes: Vec<u8> = instance.outgoing.drain(..len).collect();
                if instance.outgoing.is_empty() {
                    instance.federate.handle_written(now);
                }
                instance.announce(now);
                self.rig.send(connection, &bytes);
                !bytes.is_empty()
            }
            _ => instance.run(now, None),
        };
        let ended = self.rig.outlet.list[connection.0].ended;
        let incarnation = &mut self.incarnations[index];
        let has_resigned =
            incarnation.federate.federate.phase() == Phase::Ended && incarnation.federate.outgoing.is_empty();
        incarnation.resigned = incarnation.resigned.or(has_resigned.then_some(self.turns));
        incarnation.joined = incarnation.joined.or(incarnation.federate.has_begun().then_some(self.turns));
        if ended && has_resigned {
            self.end(index, End::InOrder);
        }
        done
    }

    fn refused(&mut self, index: usize, connection: ConnectionId) -> bool {
        assert!(self.is_transient(index));
        self.rig.take(connection, usize::MAX);
        self.end(index, End::Refused);
        true
    }

    fn end(&mut self, index: usize, end: End) {
        let incarnation = &mut self.incarnations[index];
        incarnation.end = Some(end);
        self.rig.close(incarnation.federate.connection);
    }

    /// Checks what was sent against what was received.
    fn check(&self) {
        let start = self.rig.rti.start_time().expect("it has started");
        let offset = |tag: Tag| Tag::new(Instant::from_nanos(tag.time.since(start).as_nanos()), tag.microstep);
        // By connection and tag: the values, and the incarnation that sent them.
        let mut sent: BTreeMap<(u16, Tag), Vec<(u32, &Incarnation)>> = BTreeMap::new();
        for incarnation in &self.incarnations {
            for (port, tag, value) in &incarnation.federate.sent {
                sent.entry((*port, offset(*tag))).or_default().push((*value, incarnation));
            }
        }
        let mut received: BTreeSet<(u16, Tag)> = BTreeSet::new();
        for (tag, inputs) in self.incarnations.iter().flat_map(|incarnation| &incarnation.federate.trace) {
            for (port, value) in inputs {
                let values = sent.get(&(*port, *tag)).map(Vec::as_slice).unwrap_or_default();
                assert!(values.iter().any(|(sent, _)| sent == value), "{value} at {port} and {tag} was not sent");
                // One that comes back after a crash may repeat a tag.
                let is_once = received.insert((*port, *tag)) || values.len() > 1;
                assert!(is_once, "two receive what was sent over {port} at {tag}");
            }
        }
        let in_order = |incarnation: &&Incarnation| incarnation.end == Some(End::InOrder);
        for ((port, tag), values) in &sent {
            let to = self.graph.edges[usize::from(*port)].to;
            for (value, sender) in values.iter().filter(|(_, sender)| in_order(sender)) {
                let mut incarnations =
                    self.incarnations.iter().filter(in_order).filter(|incarnation| incarnation.federate.id == to);
                // One that comes when the receiver has left sends to nobody.
                let is_there = incarnations.any(|incarnation| {
                    let covers = |(first, last)| (offset(first)..=offset(last)).contains(tag);
                    incarnation.resigned > sender.joined && incarnation.federate.span().is_some_and(covers)
                });
                let is_received = received.contains(&(*port, *tag));
                let log_events = &self.rig.outlet.log_events;
                assert!(is_received || !is_there, "{value} over {port} at {tag} is lost: {start:?} {log_events:#?}");
            }
        }
        self.check_lives(offset);
    }

    /// Checks that each incarnation begins after those before it.
    fn check_lives(&self, offset: impl Fn(Tag) -> Tag) {
        let mut last: BTreeMap<u16, Tag> = BTreeMap::new();
        let mut incarnations: Vec<_> =
            self.incarnations.iter().filter(|incarnation| incarnation.end == Some(End::InOrder)).collect();
        // One that has connected later may be accepted earlier.
        incarnations.sort_by_key(|incarnation| incarnation.joined);
        for incarnation in incarnations {
            let Some((first, end_tag)) = incarnation.federate.span() else { continue };
            let id = incarnation.federate.id;
            if let Some(before) = last.insert(id, end_tag) {
                assert!(first > before, "{id} begins at {} before {}", offset(first), offset(before));
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn who_stays_is_not_disturbed_by_who_comes_and_goes(
        graph in any_graph(),
        seed: u64,
        chosen in 1..31u16,
        dnet: bool,
    ) {
        let count = u16::try_from(graph.periods.len()).unwrap();
        let transients: Vec<u16> = (0..count).filter(|id| chosen >> id & 1 == 1).collect();
        prop_assume!(!transients.is_empty() && transients.len() < usize::from(count));
        let mut run = Federation::new(&graph, transients.leak(), seed, dnet);
        run.play();
        run.check();
    }
}
