// SPDX-License-Identifier: Apache-2.0
//! What a federate says that no federate can know, or that would hold all others up.
//!
//! The RTI believes its federates: grants are worked out from their words alone. One that is wrong makes messages late,
//! or lets all wait for ever, so it is named. Only what is wrong for certain ends it: stock federates of other releases
//! may have their reasons for the rest.

use core::fmt;

use lf_model::time::{Instant, Interval, Tag};
use lf_texts::say;

use crate::FederateId;

/// The first time that no clock shows: the beginning of the year 2200. What comes after it in what 64 bits can count is
/// left for the programs to run.
pub const CLOCK_MAX: Instant = Instant::from_nanos(7_258_118_400_000_000_000);

/// The first time that a clock may show: the beginning of the year 1900. The clock of a board that counts from when it
/// was switched on can be behind 1970 by what a test sets it off.
pub const CLOCK_MIN: Instant = Instant::from_nanos(-2_208_988_800_000_000_000);

/// What is doubtful.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SuspectedViolation {
    /// The federate has completed a tag that it was not granted.
    NotGranted(Tag),
    /// The federate announces an event that is not later than what it has completed.
    Backwards {
        /// The event.
        next: Tag,
        /// What it has completed.
        completed: Tag,
    },
    /// The federate's clock is this much ahead of that of another one, which waits for the start meanwhile.
    Ahead {
        /// The other one.
        of: FederateId,
        /// How much.
        by: Interval,
    },
    /// The federate asks over IPv4 where the other one is, which has connected over IPv6.
    OtherFamily(FederateId),
}

impl fmt::Display for SuspectedViolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotGranted(tag) => say!(
                f,
                "says that it has completed {tag}, which it was not granted: messages to others may come too late"
            ),
            Self::Backwards { next, completed } => {
                say!(f, "announces an event at {next}, though it has completed {completed}")
            }
            Self::Ahead { of, by } => say!(
                f,
                "has a clock that is {} s ahead of that of federate {of}, which waits so long for the start: set the \
                 clocks, or use `clock-sync: init`, for federates on the RTI's computer with `local-federates-on`",
                by.as_nanos() / 1_000_000_000
            ),
            // There is one family only.
            Self::OtherFamily(_) if !cfg!(feature = "ipv6") => Ok(()),
            Self::OtherFamily(of) => say!(
                f,
                "sends to federate {of} directly, but cannot be told its IPv6 address over IPv4: start both with the \
                 RTI's address in the same family, `--rti` or `at`"
            ),
        }
    }
}
