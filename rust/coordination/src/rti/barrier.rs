// SPDX-License-Identifier: Apache-2.0
//! How long the start waits for a federate that was there and has left before it.
//!
//! Whoever has not come yet may be started by hand, at any time. A federate that has come and gone has most likely
//! failed, and the others would wait for it for ever. So they wait for a limited time from the first such loss on;
//! then the RTI names those that are missing and ends the federation. When all that have left have come back, there is
//! no limit any more.

use lf_model::time::Instant;

use super::storage::Membership;
use super::{Notice, Outcome, Outlet, Rti, Slot, id};
use crate::FederateId;

/// What is known of federates that have left before the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Barrier {
    /// A federate has left, and nobody has looked at a clock since.
    left: bool,
    deadline: Option<Instant>,
    /// The time was over: the first federate that was missing, and how many were.
    missing: Option<(FederateId, u16)>,
}

impl Barrier {
    pub(super) fn deadline(&self) -> Option<Instant> {
        self.deadline
    }

    pub(super) fn outcome(&self) -> Option<Outcome> {
        self.missing.map(|(first, missing)| Outcome::NotStarted { first, missing })
    }
}

impl Rti<'_> {
    /// The place of a federate is free again before the start.
    pub(super) fn vacate(&mut self, federate: usize) {
        self.slots[federate] = Slot { vacated: true, ..Slot::default() };
        self.barrier.left = true;
    }

    /// A federate has taken its place.
    pub(super) fn occupy(&mut self, federate: usize) {
        self.slots[federate].vacated = false;
        if !self.slots.iter().any(|slot| slot.vacated) {
            self.barrier = Barrier::default();
        }
    }

    /// Gives those that have left before the start a time to come back. To be called after everything that can make a
    /// federate leave.
    pub(super) fn limit_start(&mut self, now: Instant) {
        if core::mem::take(&mut self.barrier.left) && self.start.is_none() && !self.aborted {
            let time_out = self.config.start_barrier_time_out;
            self.barrier.deadline = self.barrier.deadline.or(time_out.map(|time_out| now + time_out));
        }
    }

    /// The time to come back is over: names those that are missing, and ends the federation.
    pub(super) fn give_up_start(&mut self, outlet: &mut impl Outlet) {
        let mut missing = None;
        for (index, slot) in self.slots.iter().enumerate() {
            if !matches!(slot.membership, Membership::Joined(_)) {
                outlet.notice(Notice::Missing(id(index)));
                let (first, count) = missing.unwrap_or((id(index), 0_u16));
                missing = Some((first, count.saturating_add(1)));
            }
        }
        self.barrier = Barrier { missing, ..Barrier::default() };
        self.abort(outlet);
    }
}
