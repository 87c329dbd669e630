// SPDX-License-Identifier: Apache-2.0
//! A scenario with decentralized coordination: the centralized one of the same seed, with other waits, and in a world
//! in which all delays of a message are bounded, or in any world.

use lf_testkit::random::{Random, combine};

use super::{Decentralized, MS, Scenario, US, has_cycle};
use crate::scenario::reactors::Ending;

impl Scenario {
    /// Returns the scenario of a seed. It has no waits yet: see [`waits`](crate::waits).
    pub(crate) fn decentralized(seed: u64) -> Self {
        let mut scenario = Self::from_seed(seed);
        let random = &mut Random::new(combine(seed, 21));
        let is_safe = random.percent(50);
        scenario.conditions.rti.in_transit = 64;
        if is_safe {
            scenario.break_cycles(random);
            scenario.bound_the_world(random);
        }
        scenario.end(random);
        let peer_spare = if is_safe { 1 << 16 } else { random.one_of(&[0, 0, 300, 4096, 1 << 16]) };
        scenario.decentralized = Some(Decentralized { is_safe, peer_spare });
        let tardy_percent = random.one_of(&[0, 50, 100]);
        let all = scenario.federates.iter_mut();
        for reactor in all.flat_map(|federate| {
            std::iter::once(&mut federate.reactions)
                .chain(federate.children.iter_mut().map(|child| &mut child.reactions))
        }) {
            for reaction in reactor {
                reaction.tardy = random.percent(tardy_percent);
            }
        }
        scenario
    }

    /// Returns whether threads schedule physical actions.
    pub(crate) fn has_physical_actions(&self) -> bool {
        let is_physical = |reactor: &super::Reactor| reactor.actions.iter().any(|action| action.physical);
        self.federates.iter().any(|federate| is_physical(federate) || federate.children.iter().any(is_physical))
    }

    /// Returns whether the work of reactions, and when it is done, follows from a run only.
    pub(crate) fn work_depends_on_the_run(&self) -> bool {
        self.has_physical_actions() || self.has_transients()
    }

    /// Returns, by federate, whether messages of some of these federates can cause an event there.
    pub(crate) fn reached(&self, senders: &[usize]) -> Vec<bool> {
        let mut reached = vec![false; self.federates.len()];
        let mut open = senders.to_vec();
        while let Some(from) = open.pop() {
            for to in self.connections.iter().filter(|one| one.from.0 == from).map(|one| one.to.0) {
                if !std::mem::replace(&mut reached[to], true) {
                    open.push(to);
                }
            }
        }
        reached
    }

    /// Adds a delay to connections that close a cycle, or removes them.
    fn break_cycles(&mut self, random: &mut Random) {
        let mut index = 0;
        while index < self.connections.len() {
            let (before, one) = (&self.connections[..index], &self.connections[index]);
            let closes = leads(before, one.to.0, one.from.0);
            if closes && random.percent(50) {
                self.remove_connection(index);
                continue;
            }
            if closes {
                let after = self.connections[index].after.unwrap_or(0);
                self.connections[index].after = Some(after.max(random.one_of(&[MS, 2 * MS, 10 * MS])));
            }
            index += 1;
        }
    }

    /// Bounds the world: no link is so slow, and no buffer so small, that the messages before another one can delay it
    /// much; every event is known in advance.
    fn bound_the_world(&mut self, random: &mut Random) {
        for host in &mut self.conditions.hosts {
            host.turn_ns = host.turn_ns.min(10 * US);
            host.wake_ns = host.wake_ns.min(10 * US);
            host.link.latency = host.link.latency.min(2 * MS);
            host.link.ns_per_byte = host.link.ns_per_byte.min(80);
            host.link.socket_bytes = 1 << 16;
        }
        self.conditions.receive_spare = 1 << 16;
        let slow = random.percent(50);
        for federate in &mut self.federates {
            federate.be_predictable(slow);
        }
    }

    /// Ends the program by a time-out, even where it would end by a stop; or, without a cycle, by itself.
    fn end(&mut self, random: &mut Random) {
        let is_idle = self.target.timeout.is_none() && self.federates.iter().all(|one| !one.asks_to_stop());
        if !is_idle || self.target.keepalive || has_cycle(self.federates.len(), &self.connections, false) {
            let timeout = self.target.timeout.unwrap_or(random.one_of(&[10 * MS, 40 * MS]));
            self.target.timeout = Some(timeout * random.one_of(&[1, 1, 3]));
            if random.percent(20) {
                self.ask_to_stop(random, Ending::Stop, 10);
            }
        }
    }
}

impl super::Reactor {
    fn asks_to_stop(&self) -> bool {
        self.reactions.iter().any(|reaction| reaction.script.stop_at.is_some())
    }

    /// Makes reactions short, unless the federate is `slow`.
    fn be_predictable(&mut self, slow: bool) {
        for reaction in &mut self.reactions {
            reaction.script.work_ns = reaction.script.work_ns.min(if slow { MS } else { 50 * US });
        }
        for child in &mut self.children {
            child.be_predictable(slow);
        }
    }
}

/// Returns whether one federate reaches another over these connections.
fn leads(connections: &[super::Connection], from: usize, to: usize) -> bool {
    let (mut open, mut seen) = (vec![from], vec![from]);
    while let Some(next) = open.pop() {
        if next == to {
            return true;
        }
        for one in connections.iter().filter(|one| one.from.0 == next) {
            if !seen.contains(&one.to.0) {
                seen.push(one.to.0);
                open.push(one.to.0);
            }
        }
    }
    false
}
