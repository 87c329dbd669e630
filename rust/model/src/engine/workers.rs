// SPDX-License-Identifier: Apache-2.0
//! A level whose reactions run side by side.
use super::Engine;
use crate::bits::Bits;
use crate::env::Env;
use crate::program::Program;
use crate::tables::{ReactionKind, TriggerId};
use crate::workers::{Crew, Level, Seen, Worker};

impl Engine<'_> {
    /// Runs the reactions of a level side by side, if the program has workers and several reactions are ready, the
    /// first of which is this one. Gives whether that one has run.
    pub(super) fn share_level(&mut self, program: &mut dyn Program, env: &dyn Env, first: u16) -> bool {
        let Some(workers) = self.tables.workers else { return false };
        let reaction = |id: u16| &self.tables.reactions[usize::from(id)];
        let level = reaction(first).level;
        let is_shared = |id: u16| reaction(id).level == level && reaction(id).kind == ReactionKind::Body;
        if !is_shared(first) || !self.ready.first_from(first + 1).is_some_and(is_shared) {
            return false;
        }
        (workers.run)(self, program, env, workers.crew, level);
        !self.ready.contains(first)
    }

    pub(crate) fn run_level<const COUNT: usize, const WORDS: usize>(
        &mut self,
        program: &mut dyn Program,
        env: &dyn Env,
        crew: &'static dyn Crew,
        level: u16,
    ) {
        let mut memory = [[0; WORDS]; COUNT];
        let seen = Seen {
            tables: self.tables,
            settings: &self.settings,
            state: self.state,
            intended: self.tardy.intended,
            outside: env.outside(),
        };
        let mut workers = memory.each_mut().map(|memory| Worker::new(seen, memory));
        let mut shared = Level {
            tables: self.tables,
            state: &mut self.state,
            ready: Bits(self.ready.0),
            tardy: &self.tardy,
            modes: self.modes,
            crew,
            workers: &mut workers,
        };
        program.share(level, &mut shared);
        for mut notes in workers.map(|worker| worker.notes) {
            self.ready.insert_all(&notes.ready);
            self.ports.insert_all(&notes.ports);
            self.tardy.reactions.insert_all(&notes.tardy);
            while let Some(action) = notes.actions.pop_first() {
                let action = TriggerId(action);
                // Reactions in other modes share the job, and what those could have scheduled stands still.
                if self.is_active(action) {
                    self.events.set(action, program.trigger(action).and_then(|cell| cell.pending()));
                }
            }
        }
    }
}
