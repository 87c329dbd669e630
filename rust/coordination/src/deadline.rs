// SPDX-License-Identifier: Apache-2.0
//! When a state machine next wants to be called.

use lf_model::time::Instant;

/// When a state machine next wants to be called if nothing else happens. The order is that of urgency: the least of
/// several deadlines is the one to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Deadline {
    /// Without delay.
    Now,
    /// When the clock shows this time, or later.
    At(Instant),
    /// Not at all.
    Never,
}

impl Deadline {
    /// The more urgent of the two.
    #[must_use]
    pub fn earliest(self, other: Self) -> Self {
        self.min(other)
    }

    /// Whether it is time to call.
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
