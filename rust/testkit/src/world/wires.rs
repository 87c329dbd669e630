// SPDX-License-Identifier: Apache-2.0
//! What the network between the participants is like.

use crate::network::{Event, Medium};
use crate::random::{Random, combine};

/// What the network is like.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// Decides all that is left open: pieces, latencies, whose turn it is.
    pub seed: u64,
    /// Bytes that one direction of a connection holds, written and not read yet.
    pub pipe_bytes: usize,
    /// No piece takes longer from one end to the other.
    pub latency_ns_max: u64,
    /// Reads and writes move as much as there is, not a part of it.
    pub whole: bool,
}

impl Conditions {
    /// Ample pipes, some latency, in pieces.
    pub fn seeded(seed: u64) -> Self {
        Self { seed, pipe_bytes: 1 << 16, latency_ns_max: 200_000, whole: false }
    }
}

/// A network of these conditions, the same for all.
#[derive(Debug)]
pub struct Wires {
    conditions: Conditions,
    random: Random,
    moves: Vec<Move>,
}

/// Bytes have gone into a connection, or come out of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Move {
    /// Who accepted the connection of this number has written this.
    Said(usize, Vec<u8>),
    /// Who accepted the connection of this number has read something.
    Heard(usize),
}

impl Wires {
    /// A network of these conditions.
    pub fn new(conditions: Conditions) -> Self {
        Self { conditions, random: Random::new(combine(conditions.seed, 1)), moves: Vec::new() }
    }

    /// What those that accept connections have said and heard, in order.
    pub fn moves(&self) -> &[Move] {
        &self.moves
    }
}

impl Medium for Wires {
    fn latency_ns(&mut self, _owner: usize, _bytes: usize) -> u64 {
        self.random.range(0, self.conditions.latency_ns_max)
    }

    fn pipe_bytes(&self, _owner: usize) -> usize {
        self.conditions.pipe_bytes
    }

    fn piece(&mut self, most: usize) -> usize {
        if self.conditions.whole { most } else { self.random.count(1, most) }
    }

    fn see(&mut self, event: Event<'_>, _now: u64) {
        match event {
            Event::Written { connection, side: 1, bytes, .. } => {
                self.moves.push(Move::Said(connection, bytes.to_vec()));
            }
            Event::Read { connection, side: 0, .. } => self.moves.push(Move::Heard(connection)),
            _ => {}
        }
    }

    fn random(&mut self) -> &mut Random {
        &mut self.random
    }

    fn copies(&mut self) -> usize {
        if self.random.percent(5) { 0 } else { 1 + usize::from(self.random.percent(2)) }
    }
}
