// SPDX-License-Identifier: Apache-2.0
//! Computes the waits of federates in decentralized coordination, from bounds on the delays of messages.
//!
//! A message that federate i sends at tag t leaves at most `S_i + L` after t: `S_i` is the maximum wait of i before it
//! begins the tag, and L, the launch lag, the time of its reactions before the message is sent. It arrives N later, by
//! clocks that differ by at most E, and its tag at j is later than t by the connection's delay α. So j is safe if it
//! waits
//!
//! ```text
//! S_j = max(0, max over all connections from i to j of S_i + X),    X = L + N + E − α
//! ```
//!
//! The least solution is the length of the longest path to j. Where a cycle's X add up to more than 0 there is none:
//! each round would have to wait longer than the one before it.
//!
//! All that is true as long as no sender is blocked: while j waits, its queues have to hold the messages that arrive.

mod bounds;
mod connections;
mod lateness;
mod longest_paths;
mod overflows;
mod render;
#[cfg(test)]
mod tests;

use serde::Serialize;

pub use bounds::{Bounds, FederateBounds, HostLatency, MissingBound, parse_time};
pub use connections::Connection;
pub use lateness::ShortWait;
pub use longest_paths::FederateOffset;
pub use overflows::QueueOverflow;

use crate::plan::{Plan, ReactionKind};
use connections::TaggedConnections;
use longest_paths::LongestPaths;

/// The offsets of a program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Offsets {
    /// The program.
    pub program: String,
    /// The connections between federates that carry tags, with the delays of each.
    pub connections: Vec<Connection>,
    /// The federates, in order of id.
    pub federates: Vec<FederateOffset>,
    /// Cycles of federates without enough delay, each as its connections in order; positions in `connections`.
    pub cycles: Vec<Vec<usize>>,
    /// The waits of the program that are too short.
    pub short_waits: Vec<ShortWait>,
    /// Queues that can receive more messages during a wait than they hold, so that the sender may be blocked.
    #[serde(rename = "crowds")]
    pub overflows: Vec<QueueOverflow>,
    /// The deadlines, with the remainders that the offsets leave.
    pub deadlines: Vec<Deadline>,
}

/// The remainder of a deadline.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Deadline {
    /// The reaction.
    pub reaction: String,
    /// The deadline in nanoseconds.
    pub deadline_ns: i64,
    /// The deadline less the offset (the launch lag of the thesis's equation 2.20), in nanoseconds; `None` without an
    /// offset.
    pub launch_lag_ns: Option<i64>,
    /// The time of the preceding reactions, in nanoseconds.
    pub before_ns: i64,
}

impl Offsets {
    /// Computes the offsets of a program. A program with centralized coordination has offsets too, but no waits of its
    /// own.
    ///
    /// # Errors
    /// Returns the necessary bounds that are missing.
    pub fn of(plan: &Plan, bounds: &Bounds) -> Result<Self, Vec<MissingBound>> {
        let network = TaggedConnections::of(plan, bounds)?;
        let paths = LongestPaths::of(plan.federates.len(), &network.edges());
        let federates: Vec<_> = plan
            .federates
            .iter()
            .map(|federate| FederateOffset {
                name: federate.name.clone(),
                offset_ns: paths.offsets[usize::from(federate.id)],
                path: paths.path(usize::from(federate.id), &network.edges()),
            })
            .collect();
        let short_waits = if plan.is_decentralized() { lateness::short_waits(plan, &network) } else { Vec::new() };
        let overflows =
            if plan.is_decentralized() { overflows::overflows(plan, &network, &federates) } else { Vec::new() };
        let deadlines = deadlines(plan, bounds, &federates);
        let cycles = paths.cycles;
        let connections = network.connections;
        Ok(Self { program: plan.name.clone(), connections, federates, cycles, short_waits, overflows, deadlines })
    }

    /// Returns whether all federates have a safe offset, and the program waits long enough, has room for the messages
    /// during waits, and leaves its deadlines enough time.
    pub fn is_safe(&self) -> bool {
        self.cycles.is_empty()
            && self.short_waits.is_empty()
            && self.overflows.is_empty()
            && self.deadlines.iter().all(Deadline::is_met)
    }
}

impl Deadline {
    /// Returns whether the reaction begins in time as long as the bounds hold.
    pub fn is_met(&self) -> bool {
        self.launch_lag_ns.is_some_and(|lag| lag >= self.before_ns)
    }
}

fn deadlines(plan: &Plan, bounds: &Bounds, offsets: &[FederateOffset]) -> Vec<Deadline> {
    let mut deadlines = Vec::new();
    for (federate, offset) in plan.federates.iter().zip(offsets) {
        let mut before_ns = 0_i64;
        for reaction in &federate.reactions {
            if let Some(deadline_ns) = reaction.deadline_ns {
                let launch_lag_ns = offset.offset_ns.map(|offset| deadline_ns.saturating_sub(offset));
                let reaction = reaction.name.clone();
                deadlines.push(Deadline { reaction, deadline_ns, launch_lag_ns, before_ns });
            }
            if let ReactionKind::Body { .. } = reaction.kind {
                let execution_ns = bounds.execution(plan, federate, reaction).unwrap_or_default();
                before_ns = before_ns.saturating_add(execution_ns);
            }
        }
    }
    deadlines
}
