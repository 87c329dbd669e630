// SPDX-License-Identifier: Apache-2.0
//! The end of a federation in which no federate has an event any more.
//!
//! A federate without events leaves when nothing can come from upstream, that is, when those upstream have left. In a
//! cycle none would be the first. So when no federate has had a next event for a while, all are granted FOREVER, just
//! as an unfederated program without events ends. The stock RTI does not do so, and such a federation hangs; federates
//! that leave by themselves do so within [`IDLE_TIME`].

use lf_model::time::{Instant, Interval, Tag};

use crate::Deadline;

/// The time without any event after which all federates are granted FOREVER.
const IDLE_TIME: Interval = Interval::from_secs(1);

/// Whether any federate has an event.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) enum Idle {
    /// One has, as far as is known.
    #[default]
    No,
    /// None has, since just now.
    Begins,
    /// None has, for some time; at this time all are granted FOREVER.
    Until(Instant),
    /// None has, and all are granted FOREVER.
    Told,
}

impl Idle {
    /// Records that the next event of a federate is at this tag, or that it has left (FOREVER). `all` returns whether
    /// no federate has one.
    pub(super) fn note(&mut self, next_event: Tag, all: impl FnOnce() -> bool) {
        if next_event != Tag::FOREVER {
            *self = Self::No;
        } else if *self == Self::No && all() {
            *self = Self::Begins;
        }
    }

    /// Handles the deadline. Waits for a while; returns whether to grant FOREVER to all, because there is still no
    /// event.
    pub(super) fn handle_timeout(&mut self, now: Instant, all: impl FnOnce() -> bool) -> bool {
        *self = match self {
            Self::Begins => Self::Until(now + IDLE_TIME),
            _ if all() => Self::Told,
            _ => Self::No,
        };
        *self == Self::Told
    }

    /// Returns the time at which to call [`Idle::handle_timeout`].
    pub(super) fn deadline(self) -> Deadline {
        match self {
            Self::Begins => Deadline::Now,
            Self::Until(time) => Deadline::At(time),
            Self::No | Self::Told => Deadline::Never,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_are_told_when_nobody_has_had_an_event_for_a_while() {
        let (now, mut idle) = (Instant::from_nanos(5), Idle::default());
        idle.note(Tag::FOREVER, || false);
        assert_eq!(idle.deadline(), Deadline::Never);
        idle.note(Tag::FOREVER, || true);
        assert_eq!(idle.deadline(), Deadline::Now);
        assert!(!idle.handle_timeout(now, || true));
        assert_eq!(idle.deadline(), Deadline::At(now + IDLE_TIME));
        assert!(idle.handle_timeout(now + IDLE_TIME, || true));
        assert_eq!(idle.deadline(), Deadline::Never);
    }

    #[test]
    fn a_federate_with_an_event_ends_the_idle_state() {
        let mut idle = Idle::Until(Instant::from_nanos(5));
        idle.note(Tag::at(Instant::from_nanos(7)), || false);
        assert_eq!(idle, Idle::No);
        let mut idle = Idle::Until(Instant::from_nanos(5));
        assert!(!idle.handle_timeout(Instant::from_nanos(5), || false));
        assert_eq!(idle, Idle::No);
    }
}
