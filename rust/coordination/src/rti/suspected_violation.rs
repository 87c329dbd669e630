// SPDX-License-Identifier: Apache-2.0
//! Suspected violations: claims of a federate that no federate can make, or that would hold up all others.
//!
//! The RTI believes its federates: grants follow from their claims alone. A wrong claim makes messages late, or lets
//! all wait without end, so the RTI logs the federate. It expels a federate only for a certain violation: stock
//! federates of other releases may have their reasons for the rest.

use core::fmt;

use lf_model::time::{Instant, Interval, Tag};
use lf_texts::say;

use crate::FederateId;

/// The first time that no clock shows: the beginning of the year 2200. The later times of 64 bits are reserved for the
/// programs to run.
pub const CLOCK_MAX: Instant = Instant::from_nanos(7_258_118_400_000_000_000);

/// The first time that a clock may show: the beginning of the year 1900. The clock of a board that counts from its
/// start can be behind 1970 by the offset of a test.
pub const CLOCK_MIN: Instant = Instant::from_nanos(-2_208_988_800_000_000_000);

/// A violation that a federate is suspected of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SuspectedViolation {
    /// The federate has completed a tag that it was not granted.
    NotGranted(Tag),
    /// The federate announces an event that is not later than what it has completed.
    Backwards {
        /// The event.
        next: Tag,
        /// The tag that it has completed.
        completed: Tag,
    },
    /// The federate's clock is this much ahead of that of another one, which waits for the start meanwhile.
    Ahead {
        /// The other one.
        of: FederateId,
        /// The difference.
        by: Interval,
    },
    /// The federate asks over IPv4 for the address of the other one, which has connected over IPv6.
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
