// SPDX-License-Identifier: Apache-2.0
//! The engine's access to modes.

use super::Engine;
use crate::bits::Bits;
use crate::events::Events;
use crate::modes::{Change, ModeEvent};
use crate::tables::{ReactionId, TriggerId};

impl Engine<'_> {
    pub(super) fn runs(&self, reaction: ReactionId) -> bool {
        self.tables.runs(self.modes, reaction, self.state.is_last())
    }

    pub(super) fn is_active(&self, trigger: TriggerId) -> bool {
        self.tables.modes.is_none_or(|modes| (modes.hooks.is_active)(modes, self.modes, trigger))
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
