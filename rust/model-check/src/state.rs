// SPDX-License-Identifier: Apache-2.0
//! One state of a federation: the RTI, the federates, and the messages in transit between them.

use std::fmt;

use crate::federate::Federate;
use crate::graph::INSTANCES_MAX;
use crate::messages::{ToFederate, ToRti, Violation};
use crate::rti::Suspension;
use crate::small_tag::SmallTag;
use crate::world::World;

/// One state.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct State {
    pub(crate) rti: Suspension,
    /// The federates, by instance.
    pub(crate) federates: [Federate; INSTANCES_MAX],
    /// The messages of each instance to the RTI, in order.
    pub(crate) up: [Vec<ToRti>; INSTANCES_MAX],
    /// The messages from the RTI to each instance, in order.
    pub(crate) down: [Vec<ToFederate>; INSTANCES_MAX],
    /// The local events that the federates can still schedule.
    pub(crate) own_events_left: u8,
    /// The messages that they can still send.
    pub(crate) messages_left: u8,
    /// The losses that can still occur.
    pub(crate) losses_left: u8,
    /// The number of times that the transient federate can still come.
    pub(crate) comings_left: u8,
    /// The last tag that an instance of the transient federate had completed when it left in order.
    pub(crate) past: Option<SmallTag>,
    pub(crate) violation: Option<Violation>,
}

impl State {
    /// Returns the first violation on the path to this state.
    pub fn violation(&self) -> Option<Violation> {
        self.violation
    }

    /// Returns the instance of the transient federate that can come, if one can. Its connection has to be free; while
    /// the RTI has not read the clock of another instance, it refuses one.
    pub(crate) fn newcomer(&self, world: &World) -> Option<usize> {
        let is_free = |id: &usize| world.is_transient(*id) && self.federates[*id].gone && self.up[*id].is_empty();
        let none_begins = !self.up.iter().flatten().any(|message| *message == ToRti::Clock);
        (0..world.instances()).find(is_free).filter(|_| none_begins && self.comings_left > 0)
    }

    /// Returns whether an instance may leave or be lost, or one may come.
    pub(crate) fn may_change(&self) -> bool {
        self.losses_left > 0 || self.comings_left > 0 || self.federates.iter().any(Federate::is_told_to_stop)
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
