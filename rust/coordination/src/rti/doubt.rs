// SPDX-License-Identifier: Apache-2.0
//! What a federate says that no federate can know, or that would hold all others up.
//!
//! The RTI believes its federates: grants are worked out from their words alone. One that is wrong makes messages late,
//! or lets all wait for ever, so it is named. Only what is wrong for certain ends it: stock federates of other releases
//! may have their reasons for the rest.

use core::fmt;

use lf_model::time::{Instant, Interval, Tag};

use super::{Notice, Outlet, Rti, id};
use crate::FederateId;

/// The first time that no clock shows: the beginning of the year 2200. What comes after it in what 64 bits can count is
/// left for the programs to run.
pub const CLOCK_MAX: Instant = Instant(7_258_118_400_000_000_000);
/// How far the clocks of two federates may be apart at the start without a word.
const CLOCKS_APART_MAX: Interval = Interval::from_secs(3600);

/// What is doubtful.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
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
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotGranted(tag) => write!(
                f,
                "says that it has completed {tag}, which it was not granted: messages to others may come too late"
            ),
            Self::Backwards { next, completed } => {
                write!(f, "announces an event at {next}, though it has completed {completed}")
            }
            Self::Ahead { of, by } => write!(
                f,
                "has a clock that is {} s ahead of that of federate {of}, which waits for so long: set the clocks, or \
                 use `clock-sync: init`",
                by.as_nanos() / 1_000_000_000
            ),
        }
    }
}

impl Rti<'_> {
    /// A federate says that it has completed a tag. Those without upstream federates need no grants, and neither do
    /// those that announce nothing, as with decentralized coordination; and at a stop each goes to the stop tag.
    pub(super) fn doubt_completed(&mut self, federate: usize, tag: Tag, outlet: &mut impl Outlet) {
        let slot = &self.slots[federate];
        let asks = self.graph.upstreams(federate) > 0 && self.graph.next_event(federate) != Tag::NEVER;
        if asks && tag > slot.granted.max(slot.provisional) && self.stop_tag().is_none() {
            self.doubt(federate, Doubt::NotGranted(tag), outlet);
        }
    }

    /// A federate announces its next event.
    pub(super) fn doubt_next_event(&mut self, federate: usize, next: Tag, outlet: &mut impl Outlet) {
        let completed = self.slots[federate].completed;
        if next <= completed && completed != Tag::FOREVER && self.stop_tag().is_none() {
            self.doubt(federate, Doubt::Backwards { next, completed }, outlet);
        }
    }

    /// All have told their clocks.
    pub(super) fn doubt_clocks(&mut self, outlet: &mut impl Outlet) {
        let clocks = || (0..).zip(self.slots.iter()).filter_map(|(federate, slot)| Some((slot.clock?, federate)));
        if let (Some((earliest, of)), Some((latest, ahead))) = (clocks().min(), clocks().max()) {
            let by = latest.since(earliest);
            if by > CLOCKS_APART_MAX {
                self.doubt(ahead, Doubt::Ahead { of: id(of), by }, outlet);
            }
        }
    }

    /// Names a federate, once.
    fn doubt(&mut self, federate: usize, doubt: Doubt, outlet: &mut impl Outlet) {
        if !core::mem::replace(&mut self.slots[federate].doubted, true) {
            outlet.notice(Notice::Doubtful { federate: id(federate), doubt });
        }
    }
}
