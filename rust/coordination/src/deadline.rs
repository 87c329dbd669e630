// SPDX-License-Identifier: Apache-2.0
//! The time at which a state machine next wants to be called.

use lf_model::time::Instant;

/// The time at which a state machine next wants to be called if nothing else happens. The order is by urgency: keep the
/// minimum of several deadlines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Deadline {
    /// At once.
    Now,
    /// When the clock shows this time, or later.
    At(Instant),
    /// Never.
    Never,
}

impl Deadline {
    /// Returns the more urgent of the two.
    #[must_use]
    pub fn earliest(self, other: Self) -> Self {
        self.min(other)
    }

    /// Returns whether it is time to call.
    pub fn is_due(self, now: Instant) -> bool {
        match self {
            Self::Now => true,
            Self::At(time) => time <= now,
            Self::Never => false,
        }
    }
}

impl From<Option<Instant>> for Deadline {
    /// `None` is [`Deadline::Never`].
    fn from(time: Option<Instant>) -> Self {
        time.map_or(Self::Never, Self::At)
    }
}
