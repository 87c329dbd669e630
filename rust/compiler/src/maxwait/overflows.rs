// SPDX-License-Identifier: Apache-2.0
//! Detects waits during which more messages arrive than there is room for. The sender is then blocked, and its messages
//! arrive later than its lag says.

use serde::Serialize;

use super::connections::TaggedConnections;
use super::longest_paths::FederateOffset;
use crate::analysis::{direct_capacity, in_flight};
use crate::plan::{Federate, Plan};

/// More messages than a queue holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct QueueOverflow {
    /// The connection; its position in [`Offsets::connections`](super::Offsets::connections).
    pub connection: usize,
    /// The wait of the receiver in nanoseconds: the program's or the safe offset, whichever is longer.
    pub wait_ns: i64,
    /// The number of messages that can arrive meanwhile.
    pub messages: usize,
    /// The capacity of the queue.
    pub capacity: usize,
}

/// Returns the connections whose known rate of messages is too high.
pub(super) fn overflows(plan: &Plan, network: &TaggedConnections, offsets: &[FederateOffset]) -> Vec<QueueOverflow> {
    let mut overflows = Vec::new();
    for (connection, ends) in network.connections.iter().enumerate() {
        let federate = &plan.federates[usize::from(ends.to)];
        let input = &federate.inputs[ends.input.0];
        let Some(spacings) = &input.spacings_ns else { continue };
        let own_wait_ns = own_wait(federate);
        let wait_ns = own_wait_ns.max(offsets[usize::from(ends.to)].offset_ns.unwrap_or_default());
        let capacity = federate.triggers[input.trigger.0].capacity;
        // A capacity that the program does not set follows the waits.
        let follows = capacity == direct_capacity(spacings, ends.delay_ns, own_wait_ns);
        let capacity = if follows { direct_capacity(spacings, ends.delay_ns, wait_ns) } else { capacity };
        let messages = in_flight(spacings, ends.delay_ns.saturating_add(wait_ns));
        if messages > capacity {
            overflows.push(QueueOverflow { connection, wait_ns, messages, capacity });
        }
    }
    overflows
}

/// Returns the longest finite wait that the program sets for a federate.
fn own_wait(federate: &Federate) -> i64 {
    let inputs = federate.inputs.iter().filter(|input| !input.physical);
    let waits = inputs.map(|input| input.max_wait_ns.saturating_add(input.absent_after_ns));
    waits.filter(|wait| *wait != i64::MAX).max().unwrap_or_default()
}
