// SPDX-License-Identifier: Apache-2.0
//! The end of a federation.

use core::fmt;

use lf_texts::say;

use super::log_event::Cause;
use crate::FederateId;

/// The outcome of a federation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All federates have resigned.
    Complete,
    /// A federate left otherwise; this was the first.
    Lost {
        /// The federate.
        federate: FederateId,
        /// The reason.
        cause: Cause,
    },
    /// A federate has left before the start and has not come back in time.
    NotStarted {
        /// The first federate that was missing.
        first: FederateId,
        /// The number of missing federates, this one included.
        missing: u16,
    },
    /// The owner ended it.
    Aborted,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Complete => say!(f, "all federates have resigned"),
            Self::Lost { federate, cause } => {
                say!(f, "the federation has failed: federate {federate} is lost: {cause}")
            }
            Self::NotStarted { first, missing } => {
                say!(f, "the federation has not started: federate {first}")?;
                if *missing > 1 {
                    say!(f, " and {} more", missing - 1)?;
                }
                say!(f, " did not come back in time after a loss")
            }
            Self::Aborted => say!(f, "the RTI was told to end before its federation was over"),
        }
    }
}

/// Whether there is something left to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Federates are expected, or are there.
    Running,
    /// All federates have left. Once everything pending is sent, the owner may end.
    Finished(Outcome),
}

/// The end of a federation, beyond the departures of members.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct End {
    /// Whether the RTI has ended it.
    pub(super) aborted: bool,
    /// The first federate that was lost after the start.
    pub(super) loss: Option<(FederateId, Cause)>,
}

impl End {
    /// Returns the outcome of the federation, if it has ended; `not_started` if the start was given up.
    pub(super) fn status(&self, all_departed: bool, not_started: Option<Outcome>) -> Status {
        let otherwise = match (self.aborted, all_departed) {
            (true, _) => Outcome::Aborted,
            (false, true) => Outcome::Complete,
            (false, false) => return Status::Running,
        };
        let lost = self.loss.map(|(federate, cause)| Outcome::Lost { federate, cause });
        Status::Finished(lost.or(not_started).unwrap_or(otherwise))
    }
}
