// SPDX-License-Identifier: Apache-2.0
//! A level whose reactions run side by side.
use crate::bits::Bits;
use crate::context::ReactionContext;
use crate::events::Events;
use crate::modes::ModeState;
use crate::program::Program;
use crate::tables::ReactionKind;
use crate::workers::{ASKED, Level};

impl ReactionContext<'_> {
    /// Runs the reactions of a level side by side, if the program has workers and several reactions are ready, the
    /// first of which is this one. Returns whether that one has run; the others run one by one.
    pub(super) fn share_level(&mut self, program: &mut dyn Program, modes: &mut [ModeState], first: u16) -> bool {
        if self.tables.workers < 2 {
            return false;
        }
        let reaction = |id: u16| &self.tables.reactions[usize::from(id)];
        let number = reaction(first).level;
        let is_shared = |id: u16| reaction(id).level == number && reaction(id).kind == ReactionKind::Body;
        if !is_shared(first) || !self.ready.first_from(first + 1).is_some_and(is_shared) {
            return false;
        }
        let mut level = Level {
            tables: self.tables,
            settings: self.settings,
            state: &mut *self.state,
            events: Events { next: self.events.next, winners: self.events.winners },
            ready: Bits(self.ready.0),
            ports: Bits(self.ports.0),
            tardy: Bits(self.tardy.0),
            intended: self.intended,
            modes: &mut *modes,
            outside: self.env.outside(),
            #[cfg(feature = "traces")]
            env: &mut *self.env,
        };
        program.share(number, &mut level);
        while let Some((ASKED, action)) = self.events.earliest() {
            // Reactions in other modes share the job, and the actions of those are not active.
            let cell = if self.tables.is_active(modes, action) { program.trigger(action) } else { None };
            self.events.set(action, cell.and_then(|cell| cell.pending()));
        }
        !self.ready.contains(first)
    }
}
