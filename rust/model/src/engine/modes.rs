// SPDX-License-Identifier: Apache-2.0
//! The engine's access to modes.

use super::Engine;
use crate::bits::Bits;
use crate::events::Events;
use crate::modes::{Change, ModeEvent};
use crate::tables::TriggerId;

impl Engine<'_> {
    pub(super) fn is_active(&self, trigger: TriggerId) -> bool {
        self.tables.is_active(self.modes, trigger)
    }

    /// Handles an event of the modes, if there are any.
    pub(super) fn modes_at(&mut self, event: ModeEvent<'_>) {
        let Some(modes) = self.tables.modes else { return };
        let mut change = Change {
            modes,
            current: self.state.current,
            states: self.modes,
            held: self.held,
            events: Events { next: self.events.next, winners: self.events.winners },
            ready: Bits(self.ready.0),
        };
        (modes.hooks.at)(&mut change, event);
    }
}
