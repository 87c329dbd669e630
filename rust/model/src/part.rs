// SPDX-License-Identifier: Apache-2.0
//! The part of a ready reaction that runs.
use crate::tables::ReactionInfo;
use crate::time::{Instant, Interval};

/// The part of a reaction that runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The body.
    Body,
    /// The deadline's handler.
    MissedDeadline,
    /// The handler of a tardy input.
    Tardy,
}

impl Part {
    /// Returns the part that runs at this logical time: a handler of tardy inputs has no deadline, and only a deadline
    /// needs physical time.
    pub(crate) fn of(info: &ReactionInfo, tardy: bool, time: Instant, physical_time: impl FnOnce() -> Instant) -> Self {
        if tardy && info.tardy {
            return Self::Tardy;
        }
        // A deadline of zero is always missed, as in the C runtime.
        let missed =
            info.deadline.is_some_and(|deadline| deadline <= Interval::ZERO || physical_time() > time + deadline);
        if missed { Self::MissedDeadline } else { Self::Body }
    }
}
