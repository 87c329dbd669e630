// SPDX-License-Identifier: Apache-2.0
//! Federates and the RTI of this crate, together, in random graphs in which some federates are transient: they are
//! absent at the start, join, leave in order, crash, come back and are swapped at any moment.
//!
//! Invariants of every run: no message comes after its tag was granted, and no tag is over before a later life (the
//! machines say so); nobody waits without end; what a federate receives was sent to it, at most once; nothing is lost
//! that was sent in order to a federate which is there at its tag; the lives of a federate follow each other in tags.

use std::collections::{BTreeMap, BTreeSet};

use crate::federation_support::graph::{END_NS, Graph, any_graph};
use crate::federation_support::participant::Participant;
use lf_coordination::federate::{FederateError, Phase};
use lf_coordination::rti::{ClockSync as RtiClockSync, Config as RtiConfig, ConnectionId, Outcome, Status};
use lf_model::time::{Instant, Interval, Tag};
use lf_testkit::random::Random;
use lf_testkit::rti::{Rig, Sizes};
use lf_wire::RejectCode;
use proptest::prelude::*;

const PAYLOAD_MAX: usize = 1 << 16;
const TURNS_MAX: usize = 400_000;
/// Turns without a message or a tag after which only the clock can help.
const IDLE_TURNS: usize = 400;
/// The maximum number of lives of a federate.
const LIVES_MAX: usize = 6;

/// The end of an instance of a federate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum End {
    InOrder,
    Crash,
    /// It came too late, or while another one was about to begin.
    Refused,
}

struct Run<'g> {
    graph: &'g Graph,
    transients: &'static [u16],
    rig: Rig,
    random: Random,
    /// All instances of all federates, with their ends.
    instances: Vec<(Participant, Option<End>)>,
    idle: usize,
}

impl<'g> Run<'g> {
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
        let mut run = Self { graph, transients, rig, random, instances: Vec::new(), idle: 0 };
        for id in (0..).take(count) {
            if !transients.contains(&id) || run.random.percent(50) {
                run.join(id);
            }
        }
        run
    }

    fn join(&mut self, id: u16) {
        let instance = Participant::with_transients(id, self.graph, &mut self.rig, 1 << 16, self.transients);
        self.instances.push((instance, None));
    }

    fn is_transient(&self, index: usize) -> bool {
        self.transients.contains(&self.instances[index].0.id)
    }

    /// Runs turn by turn until all have ended.
    fn play(&mut self) {
        for _ in 0..TURNS_MAX {
            let living: Vec<_> = (0..self.instances.len()).filter(|index| self.instances[*index].1.is_none()).collect();
            if living.is_empty() {
                break;
            }
            self.pass_time();
            self.disturb();
            let index = living[self.random.index(living.len())];
            if self.instances[index].1.is_none() {
                let done = self.turn(index);
                self.idle = if done { 0 } else { self.idle + 1 };
            }
        }
        let stuck: Vec<_> =
            self.instances.iter().filter(|(_, end)| end.is_none()).map(|(instance, _)| &instance.federate).collect();
        assert!(stuck.is_empty(), "these have not come to their end: {stuck:#?}\n{:#?}", self.rig.outlet.notices);
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
            self.rig.now = start.map_or(self.rig.now + Interval::from_nanos(5), |start| start - Interval::from_nanos(3));
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
        let lives: Vec<_> = (0..self.instances.len()).filter(|index| self.instances[*index].0.id == id).collect();
        let here: Vec<_> = lives.iter().copied().filter(|index| self.instances[*index].1.is_none()).collect();
        let may_come = lives.len() < LIVES_MAX && here.len() < 2;
        match (here.last(), self.random.below(4)) {
            (None, _) if may_come => self.join(id),
            (Some(_), 0) if may_come => self.join(id),
            (Some(index), 1) => {
                let connection = self.instances[*index].0.connection;
                self.rig.close(connection);
                self.instances[*index].1 = Some(End::Crash);
            }
            (Some(index), _) if self.instances[*index].0.federate.phase() == Phase::Running => {
                self.instances[*index].0.leave();
            }
            _ => {}
        }
    }

    /// Does one turn of an instance; returns whether it has done something.
    fn turn(&mut self, index: usize) -> bool {
        let (kind, now, connection) = (self.random.below(3), self.rig.now, self.instances[index].0.connection);
        let pieces = (self.random.count(1, 60), self.random.count(1, 60));
        let instance = &mut self.instances[index].0;
        let done = match kind {
            0 => {
                let bytes = self.rig.take(connection, pieces.0);
                match instance.try_receive(now, &bytes) {
                    Ok(true) => {}
                    Ok(false) | Err(FederateError::Rejected(RejectCode::JoinsTooLate)) => {
                        return self.refused(index, connection);
                    }
                    // The RTI expects nobody any more and closes, which a joiner takes for a loss.
                    Err(error) => panic!("{error}: {:#?}\n{:#?}", instance.federate, self.rig.outlet.notices),
                }
                !bytes.is_empty()
            }
            1 => {
                let len = pieces.1.min(instance.outgoing.len());
                let bytes: Vec<u8> = instance.outgoing.drain(..len).collect();
                if instance.outgoing.is_empty() {
                    instance.federate.handle_written(now);
                }
                instance.tell(now);
                self.rig.send(connection, &bytes);
                !bytes.is_empty()
            }
            _ => instance.run(now, None),
        };
        let ended = self.rig.outlet.list[connection.0].ended;
        let instance = &self.instances[index].0;
        if ended && instance.federate.phase() == Phase::Ended && instance.outgoing.is_empty() {
            self.rig.close(connection);
            self.instances[index].1 = Some(End::InOrder);
        }
        done
    }

    fn refused(&mut self, index: usize, connection: ConnectionId) -> bool {
        assert!(self.is_transient(index));
        self.rig.take(connection, usize::MAX);
        self.rig.close(connection);
        self.instances[index].1 = Some(End::Refused);
        true
    }

    /// Checks what was sent against what was received.
    fn check(&self) {
        let start = self.rig.rti.start_time().expect("it has started");
        let offset = |tag: Tag| Tag::new(Instant::from_nanos(tag.time.since(start).as_nanos()), tag.microstep);
        // By connection and tag: the values, and whether all senders of them have left in order.
        let mut sent: BTreeMap<(u16, Tag), Vec<(u32, bool)>> = BTreeMap::new();
        for (instance, end) in &self.instances {
            for (port, tag, value) in &instance.sent {
                let is_sure = *end == Some(End::InOrder);
                sent.entry((*port, offset(*tag))).or_default().push((*value, is_sure));
            }
        }
        let mut received: BTreeSet<(u16, Tag)> = BTreeSet::new();
        for (instance, _) in &self.instances {
            for (tag, inputs) in &instance.trace {
                for (port, value) in inputs {
                    let values = sent.get(&(*port, *tag)).map(Vec::as_slice).unwrap_or_default();
                    assert!(values.iter().any(|(sent, _)| sent == value), "{value} at {port} and {tag} was not sent");
                    // One that comes back after a crash may repeat a tag.
                    let is_once = received.insert((*port, *tag)) || values.len() > 1;
                    assert!(is_once, "two receive what was sent over {port} at {tag}");
                }
            }
        }
        for ((port, tag), values) in sent.iter().filter(|(_, values)| values.iter().any(|(_, is_sure)| *is_sure)) {
            let to = self.graph.edges[usize::from(*port)].to;
            let lives = self.instances.iter().filter(|(instance, end)| instance.id == to && *end == Some(End::InOrder));
            let mut covering = lives.filter(|(instance, _)| instance.span().is_some_and(|(first, last)| {
                (offset(first)..=offset(last)).contains(tag)
            }));
            if covering.next().is_some() {
                assert!(received.contains(&(*port, *tag)), "{values:?} over {port} at {tag} is lost");
            }
        }
        self.check_lives(offset);
    }

    /// Checks that each life begins after those before it.
    fn check_lives(&self, offset: impl Fn(Tag) -> Tag) {
        let mut last: BTreeMap<u16, Tag> = BTreeMap::new();
        for (instance, end) in &self.instances {
            let Some((first, end_tag)) = instance.span().filter(|_| *end == Some(End::InOrder)) else { continue };
            if let Some(before) = last.insert(instance.id, end_tag) {
                assert!(first > before, "{} begins at {} before {}", instance.id, offset(first), offset(before));
            }
            assert!(end_tag.time.since(first.time).as_nanos() <= END_NS);
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
        let mut run = Run::new(&graph, transients.leak(), seed, dnet);
        run.play();
        run.check();
    }
}
