// SPDX-License-Identifier: Apache-2.0
//! Generates a scenario from a seed. The order of all draws is fixed, so a seed stands for one scenario.

use lf_coordination::WINDOW;
use lf_testkit::random::Random;

use super::reactors::{Ending, Style, federate};
use super::{
    Conditions, Connection, Fault, FaultKind, Host, MS, Nanos, RtiConditions, SEC, Scenario, Target, Ty, US, Variable,
    Wire, has_cycle,
};

/// Returns the period of clock synchronization while the federation runs. It has a generator of its own, so that it
/// changes nothing else.
fn rounds(seed: u64) -> Option<i64> {
    let mut random = Random::new(seed ^ 0x726f_756e_6473);
    random.percent(20).then(|| random.one_of(&[MS, 5 * MS, 20 * MS]))
}

impl Scenario {
    /// Returns the scenario of a seed.
    pub(crate) fn from_seed(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let count = federates(&mut random);
        let period = random.one_of(&[100 * US, 500 * US, MS, 2 * MS, 5 * MS]);
        let ending = match random.below(100) {
            0..=69 => Ending::Timeout,
            70..=84 => Ending::Stop,
            _ => Ending::Idle,
        };
        let ticks = random.time(5, 30);
        let target = Target {
            timeout: (ending == Ending::Timeout).then_some(period * ticks + random.one_of(&[0, 0, 1, 50 * US])),
            fast: random.percent(30),
            keepalive: ending != Ending::Idle && random.percent(20),
            auth: random.percent(10),
            advance: random.percent(30).then(|| random.one_of(&[100 * US, MS, 3 * MS])),
            clock_sync: random.percent(70).then(|| random.one_of(&[1, 3, 10])),
            rounds: None,
        };
        let target = Target { rounds: target.clock_sync.and_then(|_| rounds(seed)), ..target };
        let connections = connections(&mut random, count, period);
        let types = output_types(&mut random, count, &connections);
        let style = Style { period, ending, slow: random.percent(35), busy: random.percent(40) };
        let federates = (0..count)
            .map(|index| {
                let mut inputs: Vec<_> = connections.iter().filter(|connection| connection.to.0 == index).collect();
                inputs.sort_by_key(|connection| connection.to.1);
                let inputs = inputs.iter().map(|connection| types[connection.from.0][connection.from.1]).collect();
                federate(&mut random, &style, inputs, types[index].clone())
            })
            .collect();
        let conditions =
            conditions(&mut random, count, target.clock_sync.is_some(), has_cycle(count, &connections, false));
        let faults = if ending == Ending::Stop { Vec::new() } else { faults(&mut random, count, target.timeout) };
        let instances = (0..count).collect();
        let mut scenario =
            Self { seed, target, federates, connections, conditions, faults, instances, decentralized: None };
        scenario.ask_to_stop(&mut random, ending, ticks);
        scenario.narrow(&mut random);
        scenario
    }

    /// Reduces the RTI's memory, and the distance by which receivers may lag behind. In a cycle without delay the RTI
    /// has to remember all tags that can be in transit; elsewhere one suffices.
    fn narrow(&mut self, random: &mut Random) {
        if random.percent(50) || has_cycle(self.federates.len(), &self.connections, true) {
            return;
        }
        self.conditions.rti.in_transit = random.one_of(&[1, 2, 4, 16, 64]);
        self.conditions.rti.window = random.one_of(&[1, 2, 4, WINDOW]);
    }

    /// Lets reactions of timers request a stop. At least one of them does if there is no other end.
    pub(super) fn ask_to_stop(&mut self, random: &mut Random, ending: Ending, ticks: i64) {
        if ending == Ending::Idle || (ending == Ending::Timeout && !random.percent(15)) {
            return;
        }
        let at = random.range(1, u64::try_from(ticks).unwrap_or(1));
        let mut candidates: Vec<_> = (0..self.federates.len()).filter(|index| self.ticker(*index).is_some()).collect();
        if ending == Ending::Stop && candidates.is_empty() {
            self.target.timeout = Some(20 * MS);
        }
        let wanted = random.count(1, 3);
        for _ in 0..wanted.min(candidates.len()) {
            let chosen = candidates.swap_remove(random.count(0, candidates.len() - 1));
            let count = if random.percent(70) { at } else { random.range(1, at) };
            let offset = if random.percent(70) { 0 } else { random.time(1, 3 * MS) };
            if let Some(reaction) = self.ticker(chosen) {
                let script = &mut self.federates[chosen].reactions[reaction].script;
                (script.stop_at, script.stop_offset_ns) = (Some(count), offset);
            }
        }
    }

    /// Returns the reaction of a federate that a timer triggers periodically.
    fn ticker(&self, federate: usize) -> Option<usize> {
        let reactor = &self.federates[federate];
        let ticks =
            |variable: &Variable| matches!(variable, Variable::Timer(timer) if reactor.timers[*timer].period.is_some());
        reactor.reactions.iter().position(|reaction| reaction.triggers.iter().any(ticks))
    }
}

fn federates(random: &mut Random) -> usize {
    match random.below(100) {
        0..=59 => random.count(2, 5),
        60..=84 => random.count(6, 8),
        _ => random.count(9, 12),
    }
}

/// Returns connections between federates. Without `after` they lead from earlier to later federates of a random order,
/// and in some scenarios also back.
fn connections(random: &mut Random, count: usize, period: Nanos) -> Vec<Connection> {
    let mut order: Vec<usize> = (0..count).collect();
    for index in (1..count).rev() {
        order.swap(index, random.count(0, index));
    }
    let place = |federate: usize| order.iter().position(|one| *one == federate).unwrap_or(0);
    let wanted = random.count(count - 1, 2 * count);
    let cyclic = random.percent(50);
    let zero_delay_cycles = random.percent(35);
    let mut outputs = vec![0; count];
    let mut inputs = vec![0; count];
    let mut connections = Vec::new();
    for index in 0..wanted {
        // The first ones connect all federates.
        let to = if index + 1 < count { order[index + 1] } else { random.count(0, count - 1) };
        let from = if index + 1 < count { order[random.count(0, index)] } else { random.count(0, count - 1) };
        let (from, to) = if place(from) > place(to) && !cyclic { (to, from) } else { (from, to) };
        if from == to || inputs[to] == 6 {
            continue;
        }
        let forward = place(from) < place(to);
        let after = match random.below(10) {
            0..=4 if forward || zero_delay_cycles => None,
            0..=2 | 5 => Some(0),
            6 => Some(random.time(1, 1000)),
            _ => Some(random.one_of(&[period / 2, period, period, 2 * period, 5 * period, MS])),
        };
        let output = if outputs[from] == 0 || (outputs[from] < 3 && random.percent(50)) {
            outputs[from] += 1;
            outputs[from] - 1
        } else {
            random.count(0, outputs[from] - 1)
        };
        let capacity = match random.below(10) {
            0..=6 => None,
            7..=8 => Some(random.count(1, 4)),
            _ => Some(16),
        };
        let (from, to_end) = ((from, output), (to, inputs[to]));
        connections.push(Connection { from, to: to_end, after, capacity, max_wait: None, absent_after: None });
        inputs[to] += 1;
    }
    connections
}

/// Returns the types of all outputs, by federate.
fn output_types(random: &mut Random, count: usize, connections: &[Connection]) -> Vec<Vec<Ty>> {
    let mut types = vec![Vec::new(); count];
    for connection in connections {
        let (federate, output) = connection.from;
        while types[federate].len() <= output {
            types[federate].push(random.one_of(&[Ty::Small, Ty::Small, Ty::Small, Ty::Varying, Ty::Large]));
        }
    }
    types
}

fn conditions(random: &mut Random, count: usize, synchronized: bool, cyclic: bool) -> Conditions {
    let calm = random.percent(20);
    let slow_link = if random.percent(25) { random.count(1, count) } else { 0 };
    let drift = if random.percent(10) { 5_000_000 } else { 50_000 };
    let offset_max = if synchronized { SEC } else { 3 * MS };
    let hosts = (0..=count).map(|index| host(random, offset_max, drift, calm, index > 0 && index == slow_link));
    let hosts = hosts.collect();
    let dnet = random.percent(75);
    let in_transit = if cyclic || dnet { 256 } else { random.one_of(&[1, 2, 4, 16, 64, 64, 64]) };
    Conditions {
        hosts,
        pieces: !calm && random.percent(60),
        rti: RtiConditions {
            dnet,
            stop_all_after_loss: random.percent(50),
            start_time_multiple: random.percent(10).then(|| random.one_of(&[MS, 10 * MS, 7_777_777])),
            in_transit,
            window: WINDOW,
            spare: random.one_of(&[0, 0, 300, 4096]),
        },
        receive_spare: random.one_of(&[0, 0, 1000, 4096, 1 << 16]),
        send_spare: random.one_of(&[0, 0, 300, 4096]),
    }
}

pub(super) fn host(random: &mut Random, offset_max: Nanos, drift: i64, calm: bool, slow_link: bool) -> Host {
    Host {
        begins: if random.percent(20) { random.time(0, 300 * MS) } else { random.time(0, MS) },
        clock_offset: random.time(-offset_max, offset_max),
        clock_drift_ppb: if random.percent(50) { random.time(-drift, drift) } else { 0 },
        turn_ns: random.one_of(&[200, 2 * US, 10 * US, 50 * US]),
        wake_ns: if calm { 0 } else { random.one_of(&[0, 10 * US, 100 * US]) },
        link: if calm {
            Wire { latency: 20 * US, jitter: 0, slow_percent: 0, ns_per_byte: 0, socket_bytes: 1 << 16 }
        } else if slow_link {
            Wire {
                latency: random.one_of(&[2 * MS, 20 * MS]),
                jitter: random.one_of(&[0, 5 * MS]),
                slow_percent: random.one_of(&[0, 5]),
                ns_per_byte: random.one_of(&[US, 10 * US]),
                socket_bytes: random.one_of(&[128, 2048]),
            }
        } else {
            Wire {
                latency: random.one_of(&[0, 5 * US, 50 * US, 500 * US]),
                jitter: random.one_of(&[0, 10 * US, 200 * US, MS]),
                slow_percent: random.one_of(&[0, 0, 2, 20]),
                ns_per_byte: random.one_of(&[0, 8, 80]),
                socket_bytes: random.one_of(&[64, 256, 2048, 1 << 16]),
            }
        },
    }
}

/// Returns the faults after the start, which a few of the scenarios have.
fn faults(random: &mut Random, count: usize, timeout: Option<Nanos>) -> Vec<Fault> {
    if !random.percent(15) {
        return Vec::new();
    }
    let length = timeout.unwrap_or(20 * MS);
    let faults = random.count(1, 2);
    (0..faults)
        .map(|_| Fault {
            early: false,
            at: if random.percent(60) { SEC + random.time(-MS, length + MS) } else { random.time(0, 5 * MS) },
            participant: if random.percent(8) { 0 } else { random.count(1, count) },
            kind: random.one_of(&[FaultKind::Vanish, FaultKind::Vanish, FaultKind::Break, FaultKind::Interrupt]),
        })
        .collect()
}
