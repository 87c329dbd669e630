// SPDX-License-Identifier: Apache-2.0
//! The limit of grants downstream of absent federates: the RTI's clock (see the module `transients`).

use lf_model::time::{Instant, Tag};

use crate::Deadline;

/// The limit of grants downstream of absent federates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Horizon {
    /// The RTI's clock.
    pub(super) now: Instant,
    /// The time at which the first of the grants that wait for the clock can be made.
    due: Option<Instant>,
    /// Whether transient federates may still join.
    pub(super) is_open: bool,
}

impl Default for Horizon {
    fn default() -> Self {
        Self { now: Instant::NEVER, due: None, is_open: false }
    }
}

impl Horizon {
    pub(super) fn set_now(&mut self, now: Instant) {
        self.now = self.now.max(now);
    }

    pub(super) fn deadline(&self) -> Deadline {
        self.due.into()
    }

    /// Returns whether grants that have waited for the clock can be made.
    pub(super) fn take_due(&mut self) -> bool {
        self.due.take_if(|due| *due <= self.now).is_some()
    }

    pub(super) fn has_reached(&self, tag: Tag) -> bool {
        tag.time <= self.now
    }

    pub(super) fn wait_for(&mut self, tag: Tag) {
        self.due = Some(self.due.map_or(tag.time, |due| due.min(tag.time)));
    }
}
