// SPDX-License-Identifier: Apache-2.0
//! Shapes of federations.

use std::fmt;

use lf_wire::DELAY_NONE;

/// The shape of the connections between federates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Pairs of a sender and a receiver.
    Pairs,
    /// Each federate sends to the next.
    Chain,
    /// The first federate sends to all others.
    Star,
    /// Each but the first few has up to three upstream federates of lower number, a quarter of them with a delay.
    Random,
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Pairs => "pairs",
            Self::Chain => "chain",
            Self::Star => "star",
            Self::Random => "random",
        })
    }
}

/// One connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// The sender.
    pub from: u16,
    /// The receiver.
    pub to: u16,
    /// The delay as on the wire: [`DELAY_NONE`], or nanoseconds.
    pub delay: i64,
}

/// The connections of a federation.
#[derive(Clone, Debug)]
pub struct Graph {
    /// The number of federates.
    pub federates: u16,
    /// The connections, at most one from one federate to another.
    pub edges: Vec<Edge>,
}

impl Graph {
    /// Returns the federation of this shape, the same one in each call. `period_ns` is the delay of the connections
    /// with a delay.
    pub fn new(shape: Shape, federates: u16, period_ns: i64) -> Self {
        let edge = |from, to| Edge { from, to, delay: DELAY_NONE };
        let edges = match shape {
            Shape::Pairs => (0..federates / 2).map(|pair| edge(2 * pair, 2 * pair + 1)).collect(),
            Shape::Chain => (1..federates).map(|to| edge(to - 1, to)).collect(),
            Shape::Star => (1..federates).map(|to| edge(0, to)).collect(),
            Shape::Random => random(federates, period_ns),
        };
        Self { federates, edges }
    }

    /// Returns the upstream federates of one federate, with the delays as on the wire.
    pub fn upstream(&self, federate: u16) -> Vec<(u16, i64)> {
        self.edges.iter().filter(|edge| edge.to == federate).map(|edge| (edge.from, edge.delay)).collect()
    }

    /// Returns the downstream federates of one federate, with the delays as on the wire.
    pub fn downstream(&self, federate: u16) -> Vec<(u16, i64)> {
        self.edges.iter().filter(|edge| edge.from == federate).map(|edge| (edge.to, edge.delay)).collect()
    }
}

fn random(federates: u16, period_ns: i64) -> Vec<Edge> {
    let mut dice = Dice(1);
    let mut edges: Vec<Edge> = Vec::new();
    for to in 1..federates {
        for _ in 0..3 {
            let from = u16::try_from(dice.below(u64::from(to))).unwrap_or(0);
            let delay = if dice.below(4) == 0 { period_ns } else { DELAY_NONE };
            if !edges.iter().any(|edge| (edge.from, edge.to) == (from, to)) {
                edges.push(Edge { from, to, delay });
            }
        }
    }
    edges
}

/// A generator whose numbers need only look unordered.
struct Dice(u64);

impl Dice {
    fn below(&mut self, max: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % max
    }
}
