// SPDX-License-Identifier: Apache-2.0
//! The error of clocks in virtual time: our clock synchronization and the stock runtime's algorithm, under the same
//! delays.
//!
//! One federate, whose clock is a second off and drifts, exchanges messages with an RTI. The comparison is between
//! algorithms, not programs: a round begins with each period if the previous one is over, and takes only the time of
//! the network.

mod network;
mod ours;
mod stock;

use std::time::Duration;

pub use network::{Network, RoundDelays};
pub use ours::Ours;
pub use stock::Stock;

use crate::Samples;

/// The lead of the federate's clock at the beginning.
const OFFSET_NS: i64 = -1_000_000_000;
/// The drift of the federate's clock: it gains 26 µs in a second.
pub const DRIFT_PPB: i64 = 26_000;
/// The number of exchanges before the start, and of rounds that the stock algorithm averages.
pub const TRIALS: usize = 10;
/// The period of the rounds, LF's default.
pub const PERIOD_NS: i64 = 5_000_000;
/// LF's default.
pub const ATTENUATION: u16 = 10;
/// The duration of the federation.
const RUN_NS: i64 = 60_000_000_000;
/// The time before the first error that counts.
const SETTLED_NS: i64 = 5_000_000_000;
/// The period at which the error is sampled.
const LOOK_NS: i64 = 10_000_000;
/// The federate's side of clock synchronization. All times are those of the federate's own clock, except T1, T4 and T5.
pub trait Algorithm {
    /// Returns whether the RTI of this algorithm begins a round now, by its clock.
    fn begins(&mut self, now: i64) -> bool;

    /// Notes that the RTI received T3 at this time of its clock.
    fn answered(&mut self, now: i64);

    /// Evaluates the exchanges before the start, each with T1 to T4 and the time at which T4 arrived.
    fn initial(&mut self, exchanges: &[[i64; 5]]);

    /// Evaluates a round over UDP.
    fn round(&mut self, times: &RoundTimes);

    /// Returns the physical time at a time of the federate's own clock.
    fn physical(&self, own: i64) -> i64;
}

/// The times of a round over UDP; `None` for a message that was lost.
#[derive(Clone, Copy, Debug)]
pub struct RoundTimes {
    /// The time at which the RTI sent T1, by its clock.
    pub t1: i64,
    /// The arrival of T1.
    pub t2: i64,
    /// The time at which the federate sent T3.
    pub t3: i64,
    /// The arrival of T3 at the RTI, by its clock.
    pub t4: i64,
    /// The arrival of T4.
    pub r4: Option<i64>,
    /// The time at which the RTI sent the coded probe, by its clock.
    pub t5: i64,
    /// The arrival of the coded probe.
    pub r5: Option<i64>,
}

/// Returns the reading of the federate's clock at a time of the RTI's.
fn own(rti: i64) -> i64 {
    let drift = i128::from(rti) * i128::from(DRIFT_PPB) / 1_000_000_000;
    rti + OFFSET_NS + i64::try_from(drift).unwrap_or(0)
}

/// Runs a federation for a minute, and returns the errors of the federate's physical time after the first seconds. With
/// `on`, rounds follow the initial exchanges.
pub fn run(algorithm: &mut impl Algorithm, network: &Network, seed: u64, on: bool) -> Samples {
    let settled = offsets(algorithm, network, seed, on).into_iter().filter(|(at, _)| *at >= SETTLED_NS);
    settled.map(|(_, offset)| Duration::from_nanos(offset.unsigned_abs())).collect()
}

/// Does the same, and returns all samples: the time since the start, and the lead of the federate's physical time, in
/// nanoseconds.
pub fn offsets(algorithm: &mut impl Algorithm, network: &Network, seed: u64, on: bool) -> Vec<(i64, i64)> {
    let mut delays = network.delays(seed);
    let mut now = 1_000_000_000;
    let mut exchanges = Vec::new();
    for _ in 0..TRIALS {
        let [there, back, answer, _] = delays.next_round().times;
        let (t1, t4) = (now, now + there + back);
        exchanges.push([t1, own(t1 + there), own(t1 + there), t4, own(t4 + answer)]);
        now = t4 + answer;
    }
    algorithm.initial(&exchanges);
    let start = now + 1_000_000_000;
    let mut offsets = Vec::new();
    let mut look = start;
    let mut next_round = start + PERIOD_NS;
    // Messages in transit: the time of arrival, and the content.
    let mut pending: Vec<(i64, RoundTimes)> = Vec::new();
    while look < start + RUN_NS {
        while next_round <= look {
            let begun = next_round;
            next_round += PERIOD_NS;
            if !algorithm.begins(begun) {
                continue;
            }
            let round = delays.next_round();
            let [there, back, answer, probe] = round.times;
            if round.lost[0] || round.lost[1] {
                continue;
            }
            let (t2, t4) = (begun + there, begun + there + back);
            let t5 = t4 + network.between_ns;
            let arrives = |lost: bool, at: i64| (!lost).then(|| own(at));
            let times = RoundTimes {
                t1: begun,
                t2: own(t2),
                t3: own(t2),
                t4,
                r4: arrives(round.lost[2], t4 + answer),
                t5,
                r5: arrives(round.lost[3], t5 + probe),
            };
            algorithm.answered(t4);
            while next_round <= t4 {
                next_round += PERIOD_NS;
            }
            if on {
                pending.push(((t4 + answer).max(t5 + probe), times));
            }
        }
        pending.sort_by_key(|(at, _)| *at);
        let come = pending.partition_point(|(at, _)| *at <= look);
        for (_, times) in pending.drain(..come) {
            algorithm.round(&times);
        }
        offsets.push((look - start, algorithm.physical(own(look)) - look));
        look += LOOK_NS;
    }
    offsets
}
