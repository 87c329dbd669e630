// SPDX-License-Identifier: Apache-2.0
//! The end of a federation in which nobody has anything to do any more.
//!
//! A federate without events leaves when nothing can come from upstream, which is so when those have left. In a cycle
//! nobody would be the first. So when no federate has had a next event for a while, all are granted FOREVER, as an
//! unfederated program without events ends. The stock RTI does not do so, and such a federation hangs; those that leave
//! by themselves do so within [`IDLE_TIME`].

use lf_model::time::{Instant, Interval, Tag};

use super::storage::Membership;
use super::{Outlet, Rti};
use crate::Deadline;

/// How long nobody has had an event before all are told that none will come.
const IDLE_TIME: Interval = Interval::from_secs(1);

/// Whether anybody has something to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) enum Idle {
    /// Somebody has, as far as is known.
    #[default]
    No,
    /// Nobody has any more, since just now.
    Begins,
    /// Nobody has, for some time; at this time all are told.
    Until(Instant),
    /// Nobody has, and all are told.
    Told,
}

impl Idle {
    pub(super) fn deadline(self) -> Deadline {
        match self {
            Self::Begins => Deadline::Now,
            Self::Until(time) => Deadline::At(time),
            Self::No | Self::Told => Deadline::Never,
        }
    }
}

impl Rti<'_> {
    /// The next event of a federate is at this tag, or it has left (FOREVER). Looks at every federate once when it has
    /// none.
    pub(super) fn note_idleness(&mut self, next_event: Tag) {
        if next_event != Tag::FOREVER {
            self.idle = Idle::No;
        } else if self.idle == Idle::No && self.is_idle() {
            self.idle = Idle::Begins;
        }
    }

    fn is_idle(&self) -> bool {
        let mut slots = (0..).zip(self.slots.iter());
        self.start.is_some()
            && slots.all(|(federate, slot)| {
                slot.membership == Membership::Departed || self.graph.next_event(federate) == Tag::FOREVER
            })
    }

    /// Waits for a while, and then grants FOREVER to all, if still nobody has an event.
    pub(super) fn tell_idleness(&mut self, now: Instant, outlet: &mut impl Outlet) {
        if self.idle == Idle::Begins {
            self.idle = Idle::Until(now + IDLE_TIME);
            return;
        }
        if !self.is_idle() {
            self.idle = Idle::No;
            return;
        }
        self.idle = Idle::Told;
        for federate in 0..self.slots.len() {
            self.advance(federate, outlet);
        }
    }
}
