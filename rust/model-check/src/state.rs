// SPDX-License-Identifier: Apache-2.0
//! One state of a federation: the RTI, the federates, and the messages in transit between them.

use std::fmt;

use crate::federate::Federate;
use crate::graph::FEDERATES_MAX;
use crate::messages::{ToFederate, ToRti, Violation};
use crate::rti::Suspension;

/// One state.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct State {
    pub(crate) rti: Suspension,
    pub(crate) federates: [Federate; FEDERATES_MAX],
    /// The messages to the RTI, in order.
    pub(crate) up: [Vec<ToRti>; FEDERATES_MAX],
    /// The messages from the RTI, in order.
    pub(crate) down: [Vec<ToFederate>; FEDERATES_MAX],
    /// The local events that the federates can still schedule.
    pub(crate) own_events_left: u8,
    /// The messages that they can still send.
    pub(crate) messages_left: u8,
    /// The losses that can still occur.
    pub(crate) losses_left: u8,
    /// The number of times that the transient federate can still come.
    pub(crate) comings_left: u8,
    pub(crate) violation: Option<Violation>,
}

impl State {
    /// Returns the first violation on the path to this state.
    pub fn violation(&self) -> Option<Violation> {
        self.violation
    }

    /// Returns whether no work is left: no event, and no message in transit.
    pub fn is_done(&self) -> bool {
        let quiet = self.up.iter().all(Vec::is_empty) && self.down.iter().all(Vec::is_empty);
        quiet && self.federates.iter().all(Federate::is_idle)
    }
}

impl fmt::Debug for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (id, federate) in self.federates.iter().enumerate() {
            writeln!(f, "federate {id}: {federate:?}")?;
            if !self.up[id].is_empty() || !self.down[id].is_empty() {
                writeln!(f, "  to the RTI: {:?}, from it: {:?}", self.up[id], self.down[id])?;
            }
        }
        if let Some(violation) = self.violation {
            writeln!(f, "violation: {violation:?}")?;
        }
        Ok(())
    }
}
