// SPDX-License-Identifier: Apache-2.0
//! The life of a tag: it begins, its reactions run, and it ends.

use super::{Engine, Progress};
use crate::bits::Bits;
use crate::context::ReactionContext;
#[cfg(feature = "traces")]
use crate::env::ReactionStep;
use crate::env::{Env, Outgoing, SendError};
use crate::error::ModelError;
use crate::events::Events;
use crate::modes::ModeEvent;
use crate::part::Part;
use crate::program::Program;
use crate::queue::Full;
use crate::state::{Phase, is_tardy};
use crate::tables::{OutputId, PortId, ReactionId, ReactionInfo, ReactionKind, TriggerId, TriggerKind};
use crate::time::{Interval, Tag};

impl Engine<'_> {
    /// Opens a tag: its events take effect, and trigger reactions, which [`advance`](Self::advance) runs. It need not
    /// have events: messages may come for it while it is open, and receivers may need the absence of values.
    ///
    /// # Errors
    /// When it is not the time for this tag.
    pub fn begin(&mut self, program: &mut dyn Program, tag: Tag) -> Result<(), ModelError> {
        if self.state.phase != Phase::BetweenTags {
            return Err(ModelError::NotReady { tag });
        }
        if tag <= self.state.current {
            return Err(ModelError::TagOrder { tag, against: self.state.current });
        }
        if let Some(next) = self.next_tag().filter(|next| *next < tag) {
            return Err(ModelError::TagOrder { tag, against: next });
        }
        self.state.phase = Phase::InTag;
        self.state.current = tag;
        self.state.network_input = false;
        self.state.untouched = 0;
        self.ready.insert_reactions(self.tables.absence);
        while let Some((_, trigger)) = self.events.earliest().filter(|(pending, _)| *pending == tag) {
            self.activate(program, trigger);
        }
        if tag == self.state.stop {
            for (id, trigger) in (0..).map(TriggerId).zip(self.tables.triggers) {
                if trigger.kind == TriggerKind::Shutdown {
                    self.trigger_reactions(id);
                }
            }
        }
        Ok(())
    }

    /// Runs reactions of the open tag in order until none is left, and completes the tag; or until one cannot run yet.
    ///
    /// With `max_level`, only reactions below that level run, and the tag is not completed, because reactions from that
    /// level on see inputs that are not known yet. Without an open tag it returns [`Progress::Complete`].
    pub fn advance(&mut self, program: &mut dyn Program, env: &mut dyn Env, max_level: Option<u16>) -> Progress {
        if self.state.phase != Phase::InTag {
            return self.outcome();
        }
        let progress = self.run_reactions(program, env, max_level);
        if progress != Progress::Complete {
            return progress;
        }
        self.complete(program, env);
        self.outcome()
    }

    /// Returns the progress of a tag in which nothing is left to do.
    fn outcome(&self) -> Progress {
        if self.state.error.is_none() { Progress::Complete } else { self.failure() }
    }

    // Not a part of the code above: it would copy an error before it looks for one.
    #[cold]
    fn failure(&self) -> Progress {
        self.state.error.map_or(Progress::Complete, Progress::Failed)
    }

    /// Runs ready reactions. The tag is complete if none is left, or if one has failed.
    fn run_reactions(&mut self, program: &mut dyn Program, env: &mut dyn Env, max_level: Option<u16>) -> Progress {
        // Between two reactions levels are limited or shared among workers, steps are told, and marks are read.
        let runs_in_turn = max_level.is_none() && self.tardy.reactions.0.is_empty();
        #[cfg(feature = "workers")]
        let runs_in_turn = runs_in_turn && self.tables.workers < 2;
        #[cfg(feature = "traces")]
        let runs_in_turn = runs_in_turn && !self.state.records_steps;
        // One context serves all reactions.
        let mut ctx = ReactionContext {
            tables: self.tables,
            settings: &self.settings,
            state: &mut self.state,
            events: Events { next: self.events.next, winners: self.events.winners },
            ready: Bits(self.ready.0),
            ports: Bits(self.ports.0),
            tardy: Bits(self.tardy.reactions.0),
            intended: self.tardy.intended,
            inherits_tardy: false,
            runs_in_turn,
            mode: None,
            env,
        };
        // A reaction triggers only later ones, except in modes that are not active, so the search goes on where it was.
        let mut from = 0;
        while let Some(first) = ctx.ready.first_from(from) {
            from = first;
            let info = &ctx.tables.reactions[usize::from(first)];
            if let Some(level) = max_level.filter(|limit| info.level >= *limit) {
                return Progress::LevelLimit { level };
            }
            if !ctx.tables.runs(self.modes, ReactionId(first), ctx.state.is_last()) {
                ctx.ready.remove(first);
                continue;
            }
            #[cfg(feature = "workers")]
            let has_run = ctx.share_level(program, self.modes, first);
            #[cfg(not(feature = "workers"))]
            let has_run = false;
            if let ReactionKind::Send(output) = info.kind
                && !ctx.send(program, output)
            {
                return Progress::OutputFull { output };
            }
            // Those that run after this one, in turn, change it again.
            ctx.state.untouched = info.level.saturating_add(1);
            if !has_run {
                ctx.ready.remove(first);
                if info.kind == ReactionKind::Body {
                    ctx.run(program, ReactionId(first), info);
                    if let Some(mode) = ctx.mode.take() {
                        ctx.tables.request_mode(self.modes, mode);
                    }
                }
            }
            if ctx.state.error.is_some() {
                return Progress::Complete;
            }
        }
        while let Some(inactive) = ctx.ready.pop_first() {
            let runs = ctx.tables.runs(self.modes, ReactionId(inactive), ctx.state.is_last());
            debug_assert!(!runs, "a reaction has triggered one that is before it");
        }
        max_level.map_or(Progress::Complete, |level| Progress::LevelLimit { level })
    }

    pub(super) fn activate(&mut self, program: &mut dyn Program, id: TriggerId) {
        let tag = self.state.current;
        let mut next = program.trigger(id).and_then(|cell| cell.activate(tag));
        match self.tables.triggers[usize::from(id.0)].kind {
            TriggerKind::Startup | TriggerKind::Shutdown => {}
            TriggerKind::Reset => {
                self.events.set(id, None);
                self.modes_at(ModeEvent::Entry);
                return;
            }
            TriggerKind::Logical(_) | TriggerKind::Physical(_) => {
                self.active.insert(id.0);
            }
            TriggerKind::Timer { period, .. } => {
                self.active.insert(id.0);
                next = (period > Interval::ZERO).then(|| Tag::at(tag.time + period));
            }
            TriggerKind::Delay { fills, .. } | TriggerKind::PhysicalDelay { fills, .. } => self.fill(fills),
            TriggerKind::NetworkInput { fills } => {
                self.state.network_input = true;
                self.fill(fills);
                self.note_tardy(program, id, fills);
            }
        }
        self.events.set(id, next);
        self.trigger_reactions(id);
    }

    fn trigger_reactions(&mut self, id: TriggerId) {
        self.ready.insert_reactions(self.tables.triggers[usize::from(id.0)].reactions);
    }

    fn fill(&mut self, port: PortId) {
        self.ports.insert(port.0);
        self.ready.insert_reactions(self.tables.ports[usize::from(port.0)].reactions);
    }

    /// Closes the tag: delayed connections take their values, and present values become absent.
    fn complete(&mut self, program: &mut dyn Program, env: &dyn Env) {
        let mut from = 0;
        while let Some(port) = self.ports.first_from(from) {
            from = port;
            let info = &self.tables.ports[usize::from(port)];
            for delay in info.delays {
                self.capture(program, env, *delay);
            }
            self.ports.remove(port);
            program.clear_port(PortId(port));
        }
        while let Some(trigger) = self.active.pop_first() {
            if let Some(cell) = program.trigger(TriggerId(trigger)) {
                cell.clear();
            }
        }
        self.tardy.clear();
        let over = self.state.error.is_some() || self.state.current >= self.state.stop;
        self.state.phase = if over { Phase::Done } else { Phase::BetweenTags };
        if let Some(cells) = program.modes().filter(|_| !over) {
            self.modes_at(ModeEvent::Complete(cells));
        }
    }

    fn capture(&mut self, program: &mut dyn Program, env: &dyn Env, id: TriggerId) {
        let info = &self.tables.triggers[usize::from(id.0)];
        let (fills, tag) = match info.kind {
            TriggerKind::Delay { fills, delay } => (fills, self.state.current.after(delay)),
            TriggerKind::PhysicalDelay { fills, delay } => (fills, self.physical_tag(env.physical_time(), delay)),
            _ => return,
        };
        if tag > self.state.stop || !tag.is_finite() || !self.is_active(id) {
            return;
        }
        if let Err(Full { capacity }) = program.capture(id, tag) {
            let connection = self.tables.ports[usize::from(fills.0)].name;
            self.state.fail(ModelError::DelayFull { connection, capacity });
        }
        self.events.set(id, program.trigger(id).and_then(|cell| cell.pending()));
    }
}

impl ReactionContext<'_> {
    /// Runs the body or a handler of a reaction.
    fn run(&mut self, program: &mut dyn Program, id: ReactionId, info: &ReactionInfo) {
        let tardy = is_tardy(&self.tardy, id);
        let part = Part::of(info, tardy, self.state.current.time, || self.env.outside().physical_time());
        // A handler has dealt with it.
        self.inherits_tardy = tardy && !info.tardy;
        #[cfg(feature = "traces")]
        let records_steps = self.state.records_steps;
        #[cfg(feature = "traces")]
        if records_steps {
            self.env.step(ReactionStep::Begins(id, part), None);
        }
        match part {
            Part::Body => program.react(id, self),
            Part::MissedDeadline => program.miss_deadline(id, self),
            Part::Tardy => program.handle_tardy(id, self),
        }
        #[cfg(feature = "traces")]
        if records_steps {
            self.env.step(ReactionStep::Ends(id), None);
        }
    }

    /// Sends the value of an output, or its absence. Returns whether it was sent, or has no receiver.
    fn send(&mut self, program: &mut dyn Program, id: OutputId) -> bool {
        let output = &self.tables.outputs[usize::from(id.0)];
        let tag = self.state.current.delayed(output.delay);
        if tag > self.state.sends_until || !tag.is_finite() {
            return true;
        }
        let result = if self.ports.contains(output.source.0) {
            self.env.send(&Outgoing { output, tag, encode: &|bytes| program.encode(id, bytes) })
        } else {
            self.env.send_absent(output, tag)
        };
        match result {
            Ok(()) => true,
            Err(SendError::NoRoom) => false,
            Err(SendError::Payload(error)) => {
                self.state.fail(ModelError::Encode { output: output.name, error });
                true
            }
        }
    }
}
