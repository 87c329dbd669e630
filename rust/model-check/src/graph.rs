// SPDX-License-Identifier: Apache-2.0
//! Graphs of federates, each once up to the names of the federates.

use std::fmt;

use lf_testkit::random::combine;
use lf_wire::DELAY_NONE;

use crate::small_tag::SmallTag;

/// The maximum number of federates of a graph.
pub const FEDERATES_MAX: usize = 5;

/// The maximum number of instances of federates: the transient one may have two.
pub(crate) const INSTANCES_MAX: usize = FEDERATES_MAX + 1;

/// The delay of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Delay {
    /// No delay: the message arrives at the tag at which it is sent.
    Zero,
    /// `after 0`.
    Microstep,
    /// `after` one tick.
    Tick,
}

impl Delay {
    /// Returns the delay as in a neighbor structure, in nanoseconds.
    pub(crate) fn wire(self) -> i64 {
        match self {
            Self::Zero => DELAY_NONE,
            Self::Microstep => 0,
            Self::Tick => 1,
        }
    }

    /// Returns the tag at which a message sent at this tag arrives.
    pub(crate) fn after(self, sent: SmallTag) -> SmallTag {
        match self {
            Self::Zero => sent,
            Self::Microstep => SmallTag::new(sent.time(), sent.microstep() + 1),
            Self::Tick => SmallTag::new(sent.time() + 1, 0),
        }
    }
}

/// The connections between federates, with their delays.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Graph {
    federates: usize,
    /// The delays by sender, then receiver.
    delays: [[Option<Delay>; FEDERATES_MAX]; FEDERATES_MAX],
}

impl Graph {
    /// Returns a graph with these connections: from, to, delay.
    ///
    /// # Panics
    /// If there are more than [`FEDERATES_MAX`] federates, or a connection names another one.
    pub fn new(federates: usize, connections: &[(usize, usize, Delay)]) -> Self {
        assert!(federates <= FEDERATES_MAX, "there are at most {FEDERATES_MAX} federates, not {federates}");
        let mut delays = [[None; FEDERATES_MAX]; FEDERATES_MAX];
        for (from, to, delay) in connections {
            assert!(*from < federates && *to < federates, "there is no connection from {from} to {to}");
            delays[*from][*to] = Some(*delay);
        }
        Self { federates, delays }
    }

    /// Returns the number of federates.
    pub fn federates(&self) -> usize {
        self.federates
    }

    /// Returns the delay of the connection between two federates, if there is one.
    pub fn delay(&self, from: usize, to: usize) -> Option<Delay> {
        self.delays[from][to]
    }

    /// Returns the connections into a federate: the sender and the delay of each.
    pub(crate) fn upstream(&self, to: usize) -> impl Iterator<Item = (usize, Delay)> {
        (0..self.federates).filter_map(move |from| self.delays[from][to].map(|delay| (from, delay)))
    }

    /// Returns the connections from a federate: the receiver and the delay of each.
    pub(crate) fn downstream(&self, from: usize) -> impl Iterator<Item = (usize, Delay)> {
        (0..self.federates).filter_map(move |to| self.delays[from][to].map(|delay| (to, delay)))
    }

    /// Returns, for each pair of federates, whether a path without delay leads from one to the other.
    fn zero_delay_paths(&self) -> [[bool; FEDERATES_MAX]; FEDERATES_MAX] {
        let mut paths = self.delays.map(|row| row.map(|delay| delay == Some(Delay::Zero)));
        for middle in 0..self.federates {
            for from in 0..self.federates {
                for to in 0..self.federates {
                    paths[from][to] |= paths[from][middle] && paths[middle][to];
                }
            }
        }
        paths
    }

    /// Returns, for each connection, whether it has no delay and connects two federates of the same cycle without
    /// delay.
    pub(crate) fn awaited(&self) -> [[bool; FEDERATES_MAX]; FEDERATES_MAX] {
        let paths = self.zero_delay_paths();
        let mut awaited = [[false; FEDERATES_MAX]; FEDERATES_MAX];
        for from in 0..self.federates {
            for to in 0..self.federates {
                awaited[from][to] = self.delays[from][to] == Some(Delay::Zero) && paths[to][from];
            }
        }
        awaited
    }

    /// Returns whether there is a cycle without delay.
    pub fn has_zero_delay_cycle(&self) -> bool {
        let paths = self.zero_delay_paths();
        (0..self.federates).any(|federate| paths[federate][federate])
    }

    /// Returns whether there is a connection with the delay of a microstep.
    pub fn has_microstep_delay(&self) -> bool {
        self.delays.iter().flatten().any(|delay| *delay == Some(Delay::Microstep))
    }

    /// Returns the same graph with other names: federate `i` is called `names[i]`.
    #[must_use]
    pub fn renamed(&self, names: &[usize]) -> Self {
        let mut delays = [[None; FEDERATES_MAX]; FEDERATES_MAX];
        for from in 0..self.federates {
            for to in 0..self.federates {
                delays[names[from]][names[to]] = self.delays[from][to];
            }
        }
        Self { federates: self.federates, delays }
    }

    /// Returns whether no permutation of the names makes this graph a lesser one, which is true for exactly one of the
    /// graphs that differ only in names.
    fn is_canonical(&self, permutations: &[Vec<usize>]) -> bool {
        permutations.iter().all(|names| *self <= self.renamed(names))
    }

    /// Returns whether the graph is connected. The parts of another one are graphs of their own, which are checked
    /// separately.
    fn is_connected(&self) -> bool {
        let mut reached = 1u8;
        for _ in 0..self.federates {
            for from in 0..self.federates {
                for to in 0..self.federates {
                    if self.delays[from][to].is_some() && (reached >> from | reached >> to) & 1 == 1 {
                        reached |= 1 << from | 1 << to;
                    }
                }
            }
        }
        reached.count_ones() as usize == self.federates
    }
}

impl fmt::Debug for Graph {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for from in 0..self.federates {
            for (to, delay) in self.downstream(from) {
                let after = match delay {
                    Delay::Zero => "",
                    Delay::Microstep => " after 0",
                    Delay::Tick => " after 1 tick",
                };
                write!(f, "{separator}{from} -> {to}{after}")?;
                separator = "; ";
            }
        }
        if separator.is_empty() { write!(f, "{} federates without connections", self.federates) } else { Ok(()) }
    }
}

/// Returns the number of named graphs with this many federates: each of the n(n − 1) connections is one of four.
fn numbers(federates: usize) -> u64 {
    4u64.pow(u32::try_from(federates * federates.saturating_sub(1)).unwrap_or(u32::MAX))
}

/// Returns a random selection of connected graphs with this many federates, the same for the same seed: each of all
/// named graphs is equally likely. Federates have the names that [`all_graphs`] gives them.
pub fn some_graphs(federates: usize, seed: u64) -> impl Iterator<Item = Graph> {
    let permutations = permutations(federates);
    let numbers = (0..).map(move |index| combine(seed, index) % numbers(federates));
    let graphs = numbers.map(move |number| decode(federates, number)).filter(Graph::is_connected);
    graphs.filter_map(move |graph| permutations.iter().map(|names| graph.renamed(names)).min())
}

/// Returns all connected graphs with this many federates, each once up to the names of the federates.
pub fn all_graphs(federates: usize) -> impl Iterator<Item = Graph> {
    let permutations = permutations(federates);
    (0..numbers(federates))
        .map(move |number| decode(federates, number))
        .filter(move |graph| graph.is_connected() && graph.is_canonical(&permutations))
}

fn decode(federates: usize, mut number: u64) -> Graph {
    let mut graph = Graph::new(federates, &[]);
    for from in 0..federates {
        for to in (0..federates).filter(|to| *to != from) {
            graph.delays[from][to] = [None, Some(Delay::Zero), Some(Delay::Microstep), Some(Delay::Tick)]
                .get((number % 4) as usize)
                .copied()
                .flatten();
            number /= 4;
        }
    }
    graph
}

/// Returns all orders of the numbers below `count`.
pub(crate) fn permutations(count: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for _ in 0..count {
        let longer = |order: Vec<usize>| {
            let rest: Vec<_> = (0..count).filter(|next| !order.contains(next)).collect();
            rest.into_iter().map(move |next| order.iter().copied().chain([next]).collect())
        };
        all = all.into_iter().flat_map(longer).collect();
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of connected graphs of three federates follows from counting orbits by hand: of the 4^6 named graphs,
    /// subtract the disconnected ones, and divide by the symmetries under the six permutations.
    #[test]
    fn graphs_are_counted_once() {
        assert_eq!(all_graphs(1).count(), 1);
        assert_eq!(all_graphs(2).count(), 9);
        let orbits: usize = (0..numbers(3))
            .map(|number| decode(3, number))
            .filter(Graph::is_connected)
            .map(|graph| {
                let mut others: Vec<_> = permutations(3).iter().map(|names| graph.renamed(names)).collect();
                others.sort_unstable();
                others.dedup();
                // Each orbit is visited once for each of its members.
                60 / others.len()
            })
            .sum();
        assert_eq!(all_graphs(3).count() * 60, orbits);
    }

    #[test]
    fn only_connections_within_one_cycle_without_delay_are_awaited() {
        use Delay::{Tick, Zero};
        let two_cycles = [(0, 1, Zero), (1, 0, Zero), (1, 2, Zero), (2, 3, Zero), (3, 2, Zero), (3, 0, Tick)];
        let awaited = Graph::new(4, &two_cycles).awaited();
        assert!(awaited[0][1] && awaited[1][0] && awaited[2][3] && awaited[3][2]);
        assert!(!awaited[1][2] && !awaited[3][0]);
    }
}
