// SPDX-License-Identifier: Apache-2.0
//! Watchdogs: at most one pending event, which is postponed as long as a reaction restarts the watchdog in time.
use crate::cell::{Readable, TriggerCell};
use crate::modes::ModeCell;
use crate::tables::TriggerId;
use crate::time::Tag;

/// A watchdog, as bodies see it: `ctx.start_watchdog(poodle, delay!(0))`. Generated code makes one per trigger of this
/// kind; the trigger is a logical one, whose minimum delay is the timeout.
#[derive(Debug)]
pub struct Watchdog {
    pub(crate) id: TriggerId,
    present: bool,
    /// The tag at which it expires, while it runs.
    pub(crate) expires: Option<Tag>,
}

impl Watchdog {
    /// Returns a watchdog that does not run.
    pub const fn new(id: TriggerId) -> Self {
        Self { id, present: false, expires: None }
    }
}

impl Readable for Watchdog {
    type Value = ();
    fn is_present(&self) -> bool {
        self.present
    }
    fn value(&self) -> Option<&()> {
        self.present.then_some(&())
    }
}

impl TriggerCell for Watchdog {
    fn activate(&mut self, _tag: Tag) -> Option<Tag> {
        self.present = true;
        self.expires = None;
        None
    }
    fn clear(&mut self) {
        self.present = false;
    }
    fn pending(&self) -> Option<Tag> {
        self.expires
    }
}

impl ModeCell for Watchdog {
    fn shift(&mut self, from: Tag, to: Tag) -> Option<Tag> {
        self.expires = self.expires.map(|tag| tag.moved(from, to));
        self.expires
    }
    fn discard(&mut self) {
        self.expires = None;
    }
}
