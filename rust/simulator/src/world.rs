// SPDX-License-Identifier: Apache-2.0
//! The world of a scenario: its participants, the properties of the network between them, and the observer.

use lf_testkit::network::{Event, Medium};
use lf_testkit::random::Random;
use lf_testkit::world::{ComputerSpeed, Shared, Side};

use crate::check::Watch;
use crate::scenario::{Conditions, Fault, FaultKind, Host, Scenario, Wire};

pub(crate) type World = lf_testkit::world::World<SimulatedMedium>;
/// One participant's view of the world.
pub(crate) type Virtual = lf_testkit::world::Virtual<SimulatedMedium>;

/// Returns the world of a scenario; the seed decides all that it leaves open.
pub(crate) fn world(scenario: &Scenario, seed: u64) -> Shared<SimulatedMedium> {
    let conditions = &scenario.conditions;
    let mut random = Random::new(seed);
    let keep = |host: &Host| Side::keep(host.clock_offset, host.clock_drift_ppb);
    let sides: Vec<_> = conditions.hosts.iter().map(keep).collect();
    let watch = Watch::new(scenario);
    let medium = SimulatedMedium::new(conditions, watch, sides.clone(), random.number());
    let mut world = World::new(medium, random);
    for (participant, (side, host)) in sides.into_iter().zip(&conditions.hosts).enumerate() {
        let computer = ComputerSpeed { turn_ns: (100, host.turn_ns), wake_ns: host.wake_ns };
        if participant > 0 && scenario.begins_later(participant - 1) {
            world.add(side, computer);
        } else {
            world.join(side, u64::try_from(host.begins).unwrap_or(0), computer);
        }
    }
    Shared::new(world)
}

/// Executes a fault at this virtual time.
pub(crate) fn strike(world: &mut World, fault: &Fault, at: u64) {
    world.advance_to(at);
    if let FaultKind::Vanish | FaultKind::Break = fault.kind {
        world.network.medium_mut().watch.lose(fault.participant, at);
    }
    match fault.kind {
        FaultKind::Begin => world.schedule(fault.participant, at),
        FaultKind::Vanish => world.end(fault.participant),
        FaultKind::Break => world.break_connections(fault.participant),
        FaultKind::Interrupt => world.interrupt(fault.participant),
    }
}

/// The percentage of writes that find no room, while those right after them do, where there are pieces.
const LATE_PERCENT: u64 = 5;
/// The percentage of datagrams that are lost, and of the others that arrive twice.
const LOST_PERCENT: u64 = 5;
const DOUBLE_PERCENT: u64 = 2;

/// The medium between the participants: their links, chance, and the observer.
#[derive(Debug)]
pub(crate) struct SimulatedMedium {
    wires: Vec<Wire>,
    pieces: bool,
    random: Random,
    /// The progress of each participant.
    sides: Vec<&'static Side>,
    /// By connection: both participants.
    ends: Vec<[usize; 2]>,
    /// The observer of all written bytes.
    pub(crate) watch: Watch,
    /// The number of writes that found no room.
    pub(crate) refused_writes: u64,
    /// The number of turns that datagrams can account for: one that sends, and one at each arrival.
    pub(crate) datagram_turns: u64,
}

impl SimulatedMedium {
    fn new(conditions: &Conditions, watch: Watch, sides: Vec<&'static Side>, seed: u64) -> Self {
        Self {
            wires: conditions.hosts.iter().map(|host| host.link.clone()).collect(),
            pieces: conditions.pieces,
            random: Random::new(seed),
            sides,
            ends: Vec::new(),
            watch,
            refused_writes: 0,
            datagram_turns: 0,
        }
    }
}

impl Medium for SimulatedMedium {
    fn latency_ns(&mut self, owner: usize, bytes: usize) -> u64 {
        let wire = &self.wires[owner];
        let jitter = self.random.time(0, wire.jitter);
        let jitter = if self.random.percent(wire.slow_percent) { 10 * jitter } else { jitter };
        let transfer = wire.ns_per_byte.saturating_mul(i64::try_from(bytes).unwrap_or(0));
        u64::try_from(wire.latency + jitter + transfer).unwrap_or(0)
    }

    fn pipe_bytes(&self, owner: usize) -> usize {
        self.wires[owner].socket_bytes
    }

    fn piece(&mut self, most: usize) -> usize {
        if self.pieces && self.random.percent(50) { self.random.count(1, most) } else { most }
    }

    fn is_read_in_time(&mut self) -> bool {
        !self.pieces || !self.random.percent(LATE_PERCENT)
    }

    fn copies(&mut self) -> usize {
        let is_lost = self.random.percent(LOST_PERCENT);
        let copies = if is_lost { 0 } else { 1 + u8::from(self.random.percent(DOUBLE_PERCENT)) };
        self.datagram_turns += 1 + u64::from(copies);
        copies.into()
    }

    fn random(&mut self) -> &mut Random {
        &mut self.random
    }

    fn see(&mut self, event: Event<'_>, now: u64) {
        match event {
            Event::Begun { connection, by, to } => {
                self.ends.push([by, to]);
                self.watch.begin(connection, by, to);
            }
            Event::Written { connection, side, bytes, arrives } => {
                // A reader whose turn goes on longer than that sees it only after the turn.
                let visible = arrives.max(self.sides[self.ends[connection][1 - side]].now());
                self.watch.write(connection, side, bytes, now, visible);
            }
            Event::Read { connection, side, bytes } => self.watch.read(connection, side, bytes, now),
            Event::Refused => self.refused_writes += 1,
        }
    }
}
