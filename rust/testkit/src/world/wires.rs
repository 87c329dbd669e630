// SPDX-License-Identifier: Apache-2.0
//! The properties of the network between the participants.

use crate::network::{Event, Medium};
use crate::random::{Random, combine};

/// The percentage of writes in pieces that find no room, while those right after them do.
const LATE_PERCENT: u64 = 10;

/// The properties of the network.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// The seed of all open choices: pieces, latencies, the order of turns.
    pub seed: u64,
    /// The capacity in bytes of one direction of a connection, written and not read yet.
    pub pipe_bytes: usize,
    /// The longest latency of a piece.
    pub latency_ns_max: u64,
    /// Whether reads and writes move as much as there is, and not a part of it.
    pub whole: bool,
}

impl Conditions {
    /// Returns large pipes, some latency, and transfer in pieces.
    pub fn seeded(seed: u64) -> Self {
        Self { seed, pipe_bytes: 1 << 16, latency_ns_max: 200_000, whole: false }
    }
}

/// A network with these properties, the same for all participants.
#[derive(Debug)]
pub struct Wires {
    conditions: Conditions,
    random: Random,
    moves: Vec<Move>,
}

/// A write or a read on a connection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Move {
    /// The accepting side of the connection with this number has written these bytes.
    Said(usize, Vec<u8>),
    /// The accepting side of the connection with this number has read bytes.
    Heard(usize),
}

impl Wires {
    /// Returns a network with these properties.
    pub fn new(conditions: Conditions) -> Self {
        Self { conditions, random: Random::new(combine(conditions.seed, 1)), moves: Vec::new() }
    }

    /// Returns the writes and reads of the accepting sides, in order.
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

    fn is_read_in_time(&mut self) -> bool {
        self.conditions.whole || !self.random.percent(LATE_PERCENT)
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
