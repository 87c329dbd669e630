// SPDX-License-Identifier: Apache-2.0
//! Federates and the RTI of this crate, together, in random graphs in which some federates are transient: they are
//! absent at the start, join, leave in order, crash, come back and are swapped at any moment.
//!
//! Invariants of every run: no message comes after its tag was granted, and no tag is over before a later life (the
//! machines say so); nobody waits without end; what a federate receives was sent to it, at most once; nothing is lost
//! that was sent in order to a federate which is there at its tag; the lives of a federate follow each other in tags.

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

/// An instance of a federate.
struct Life {
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
    lives: Vec<Life>,
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
        let mut run = Self { graph, transients, rig, random, lives: Vec::new(), turns: 0, idle: 0 };
        for id in (0..).take(count) {
            if !transients.contains(&id) || run.random.percent(50) {
                run.join(id);
            }
        }
        run
    }

    fn join(&mut self, id: u16) {
        let federate = Participant::with_transients(id, self.graph, &mut self.rig, 1 << 16, self.transients);
        self.lives.push(Life { federate, end: None, joined: None, resigned: None });
    }

    fn is_transient(&self, index: usize) -> bool {
        self.transients.contains(&self.lives[index].federate.id)
    }

    /// Runs turn by turn until all have ended.
    fn play(&mut self) {
        for _ in 0..TURNS_MAX {
            self.turns += 1;
            let living: Vec<_> = (0..self.lives.len()).filter(|index| self.lives[*index].end.is_none()).collect();
            if living.is_empty() {
                break;
            }
            self.pass_time();
            self.disturb();
            let index = living[self.random.index(living.len())];
            if self.lives[index].end.is_none() {
                let done = self.turn(index);
                self.idle = if done { 0 } else { self.idle + 1 };
            }
        }
        let stuck: Vec<_> =
            self.lives.iter().filter(|life| life.end.is_none()).map(|life| &life.federate.federate).collect();
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
        let lives: Vec<_> = (0..self.lives.len()).filter(|index| self.lives[*index].federate.id == id).collect();
        let here: Vec<_> = lives.iter().copied().filter(|index| self.lives[*index].end.is_none()).collect();
        let may_come = lives.len() < LIVES_MAX && here.len() < 2;
        match (here.last(), self.random.below(4)) {
            (None, _) | (Some(_), 0) if may_come => self.join(id),
            (Some(index), 1) => {
                self.end(*index, End::Crash);
            }
            (Some(index), _) if self.lives[*index].federate.federate.phase() == Phase::Running => {
                self.lives[*index].federate.leave();
            }
            _ => {}
        }
    }

    /// Does one turn of an instance; returns whether it has done something.
    fn turn(&mut self, index: usize) -> bool {
        let (kind, now, connection) = (self.random.below(3), self.rig.now, self.lives[index].federate.connection);
        let pieces = (self.random.count(1, 60), self.random.count(1, 60));
        let instance = &mut self.lives[index].federate;
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
        let life = &mut self.lives[index];
        let has_resigned = life.federate.federate.phase() == Phase::Ended && life.federate.outgoing.is_empty();
        life.resigned = life.resigned.or(has_resigned.then_some(self.turns));
        life.joined = life.joined.or(life.federate.has_begun().then_some(self.turns));
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
        let life = &mut self.lives[index];
        life.end = Some(end);
        self.rig.close(life.federate.connection);
    }

    /// Checks what was sent against what was received.
    fn check(&self) {
        let start = self.rig.rti.start_time().expect("it has started");
        let offset = |tag: Tag| Tag::new(Instant::from_nanos(tag.time.since(start).as_nanos()), tag.microstep);
        // By connection and tag: the values, and the life that sent them.
        let mut sent: BTreeMap<(u16, Tag), Vec<(u32, &Life)>> = BTreeMap::new();
        for life in &self.lives {
            for (port, tag, value) in &life.federate.sent {
                sent.entry((*port, offset(*tag))).or_default().push((*value, life));
            }
        }
        let mut received: BTreeSet<(u16, Tag)> = BTreeSet::new();
        for (tag, inputs) in self.lives.iter().flat_map(|life| &life.federate.trace) {
            for (port, value) in inputs {
                let values = sent.get(&(*port, *tag)).map(Vec::as_slice).unwrap_or_default();
                assert!(values.iter().any(|(sent, _)| sent == value), "{value} at {port} and {tag} was not sent");
                // One that comes back after a crash may repeat a tag.
                let is_once = received.insert((*port, *tag)) || values.len() > 1;
                assert!(is_once, "two receive what was sent over {port} at {tag}");
            }
        }
        let in_order = |life: &&Life| life.end == Some(End::InOrder);
        for ((port, tag), values) in &sent {
            let to = self.graph.edges[usize::from(*port)].to;
            for (value, sender) in values.iter().filter(|(_, sender)| in_order(sender)) {
                let mut lives = self.lives.iter().filter(in_order).filter(|life| life.federate.id == to);
                // One that comes when the receiver has left sends to nobody.
                let is_there = lives.any(|life| {
                    let covers = |(first, last)| (offset(first)..=offset(last)).contains(tag);
                    life.resigned > sender.joined && life.federate.span().is_some_and(covers)
                });
                let is_received = received.contains(&(*port, *tag));
                let notices = &self.rig.outlet.notices;
                assert!(is_received || !is_there, "{value} over {port} at {tag} is lost: {start:?} {notices:#?}");
            }
        }
        self.check_lives(offset);
    }

    /// Checks that each life begins after those before it.
    fn check_lives(&self, offset: impl Fn(Tag) -> Tag) {
        let mut last: BTreeMap<u16, Tag> = BTreeMap::new();
        let mut lives: Vec<_> = self.lives.iter().filter(|life| life.end == Some(End::InOrder)).collect();
        // One that has connected later may be accepted earlier.
        lives.sort_by_key(|life| life.joined);
        for life in lives {
            let Some((first, end_tag)) = life.federate.span() else { continue };
            let id = life.federate.id;
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
