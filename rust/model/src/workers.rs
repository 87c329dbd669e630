// SPDX-License-Identifier: Apache-2.0
//! Reactions of one level, side by side in several threads.
//!
//! Reactions of one level belong to different reactors, and none of them sets what another one sees. So generated code
//! lends each its own fields, by closures over them, and the borrow checker proves that they share nothing that one of
//! them changes. What they do to the engine's own state, they leave in notes, and these are put together when all have
//! run, in the order of the reactions. So it makes no difference which thread ran what, and when.
use core::fmt;

use crate::bits::Bits;
use crate::context::ReactionContext;
use crate::engine::{Engine, part_of};
use crate::env::{Env, Outgoing, SendError};
use crate::error::ModelError;
use crate::events::Events;
use crate::ids::{ReactionId, TriggerId};
use crate::modes::{ModeState, Modes, Transition};
use crate::outside::Outside;
use crate::program::{Part, Program};
use crate::state::{Settings, State, Tardy};
use crate::tables::{Tables, words};
use crate::time::Tag;

/// How the reactions of a program run side by side.
#[derive(Clone, Copy)]
pub struct Workers {
    pub(crate) count: usize,
    pub(crate) crew: &'static dyn Crew,
    pub(crate) run: Run,
}

impl Workers {
    /// `COUNT` workers, the event loop's own thread included, each with `WORDS` of memory for its notes:
    /// [`words`](Self::words) says how many it needs.
    ///
    /// # Panics
    /// When that is less than the tables ask for. Generated code makes the workers in a constant.
    pub const fn new<const COUNT: usize, const WORDS: usize>(crew: &'static dyn Crew, tables: &Tables) -> Self {
        assert!(Self::words(tables) <= WORDS, "a worker needs a bit for all that it may have to note");
        let run: Run = |engine, program, env, crew, level| engine.run_level::<COUNT, WORDS>(program, env, crew, level);
        Self { count: COUNT, crew, run }
    }

    /// How many words of memory a worker needs for its notes.
    pub const fn words(tables: &Tables) -> usize {
        let reactions = words(tables.reactions.len()) + words(tables.tardy_reactions());
        reactions + words(tables.ports.len()) + words(tables.triggers.len())
    }
}

impl fmt::Debug for Workers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Workers").field("count", &self.count).finish_non_exhaustive()
    }
}

/// Runs a level of a program's open tag.
type Run = fn(&mut Engine<'_>, &mut dyn Program, &dyn Env, &'static dyn Crew, u16);

/// Threads that share work.
pub trait Crew: Sync {
    /// Has the workers run the jobs, each job once and by any of them, and comes back when all have run. One of the
    /// workers may be the caller's own thread.
    fn run(&self, workers: &mut [Worker<'_>], jobs: &mut [Job<'_>]);
}

/// The body of a job: calls the method of a reaction for a part of it.
type Body<'a> = dyn FnMut(ReactionId, Part, &mut ReactionContext<'_>) + Send + 'a;

/// A reaction that can run beside others of its level; or several of one reactor, which are in different modes.
pub struct Job<'a> {
    reactions: &'static [ReactionId],
    /// The one that is ready.
    reaction: ReactionId,
    actions: &'static [TriggerId],
    body: &'a mut Body<'a>,
    /// Whether it sees what has come too late.
    tardy: bool,
    outcome: Outcome,
}

/// What a reaction has asked for.
#[derive(Clone, Copy, Debug, Default)]
struct Outcome {
    stop: Option<Tag>,
    stop_request: Option<Tag>,
    error: Option<ModelError>,
    mode: Option<Transition>,
}

impl<'a> Job<'a> {
    /// The job of a reaction, or of some that share what they change, in their order; with the actions that they can
    /// schedule, and a closure that calls their methods.
    pub const fn new(reactions: &'static [ReactionId], actions: &'static [TriggerId], body: &'a mut Body<'a>) -> Self {
        let outcome = Outcome { stop: None, stop_request: None, error: None, mode: None };
        Self { reactions, reaction: ReactionId(u16::MAX), actions, body, tardy: false, outcome }
    }
}

impl fmt::Debug for Job<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Job").field(&self.reactions).finish()
    }
}

/// What one thread needs to run jobs, and its notes of what they did.
pub struct Worker<'a> {
    seen: Seen<'a>,
    pub(crate) notes: Notes<'a>,
}

/// What the reactions of a level see of the engine: it is as it was before any of them ran.
#[derive(Clone, Copy)]
pub(crate) struct Seen<'a> {
    pub(crate) tables: &'static Tables,
    pub(crate) settings: &'a Settings,
    pub(crate) state: State,
    pub(crate) intended: &'a [Tag],
    pub(crate) outside: &'static dyn Outside,
}

/// Sets, which are the same in whatever order they are put together.
pub(crate) struct Notes<'a> {
    /// Reactions that were triggered, and of those the ones that are tardy.
    pub(crate) ready: Bits<'a>,
    pub(crate) tardy: Bits<'a>,
    /// Ports that were set.
    pub(crate) ports: Bits<'a>,
    /// Actions that may have been scheduled.
    pub(crate) actions: Bits<'a>,
}

impl<'a> Worker<'a> {
    /// With [`Workers::words`] of memory, which is clear.
    pub(crate) fn new(seen: Seen<'a>, memory: &'a mut [u32]) -> Self {
        let (ready, memory) = memory.split_at_mut(words(seen.tables.reactions.len()));
        let (tardy, memory) = memory.split_at_mut(words(seen.tables.tardy_reactions()));
        let (ports, actions) = memory.split_at_mut(words(seen.tables.ports.len()));
        Self {
            seen,
            notes: Notes { ready: Bits(ready), tardy: Bits(tardy), ports: Bits(ports), actions: Bits(actions) },
        }
    }

    /// Runs a job.
    pub fn run(&mut self, job: &mut Job<'_>) {
        let Self { seen, notes } = self;
        let info = &seen.tables.reactions[usize::from(job.reaction.0)];
        let (mut state, mut env) = (seen.state, Elsewhere(seen.outside));
        let part = part_of(info, job.tardy, state.current.time, &env);
        let mut ctx = ReactionContext {
            tables: seen.tables,
            settings: seen.settings,
            state: &mut state,
            // When all have run, the engine asks the actions themselves.
            events: Events { next: &mut [], winners: &mut [] },
            ready: Bits(notes.ready.0),
            ports: Bits(notes.ports.0),
            tardy: Bits(notes.tardy.0),
            intended: seen.intended,
            inherits_tardy: job.tardy && !info.tardy,
            mode: None,
            env: &mut env,
        };
        (job.body)(job.reaction, part, &mut ctx);
        let mode = ctx.mode;
        for action in job.actions {
            notes.actions.insert(action.0);
        }
        let stop = Some(state.stop).filter(|stop| *stop < seen.state.stop);
        job.outcome = Outcome { stop, stop_request: state.stop_request, error: state.error, mode };
    }
}

impl fmt::Debug for Worker<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Worker").field("state", &self.seen.state).finish_non_exhaustive()
    }
}

/// The surroundings of a reaction in any thread. Bodies do not send.
struct Elsewhere(&'static dyn Outside);

impl Env for Elsewhere {
    fn outside(&self) -> &'static dyn Outside {
        self.0
    }

    fn send(&mut self, _message: &Outgoing<'_>) -> Result<(), SendError> {
        Err(SendError::NoRoom)
    }
}

/// A level of the open tag, and those who run it.
pub struct Level<'a, 'w> {
    pub(crate) tables: &'static Tables,
    pub(crate) state: &'a mut State,
    pub(crate) ready: Bits<'a>,
    pub(crate) tardy: &'a Tardy<'a>,
    pub(crate) modes: &'a mut [ModeState],
    pub(crate) crew: &'static dyn Crew,
    pub(crate) workers: &'a mut [Worker<'w>],
}

impl Level<'_, '_> {
    /// Runs those jobs whose reactions are ready, if they are several. One alone is left to the engine. The jobs stand
    /// in the order of their reactions.
    pub fn run(&mut self, jobs: &mut [Job<'_>]) {
        let mut count = 0;
        for index in 0..jobs.len() {
            let ready = jobs[index].reactions.iter().find(|reaction| self.is_ready(**reaction));
            if let Some(reaction) = ready {
                jobs[index].reaction = *reaction;
                jobs.swap(count, index);
                count += 1;
            }
        }
        if count < 2 {
            return;
        }
        let jobs = &mut jobs[..count];
        for job in &mut *jobs {
            self.ready.remove(job.reaction.0);
            job.tardy = self.tardy.contains(job.reaction);
        }
        let workers = self.workers.len().min(count);
        self.crew.run(&mut self.workers[..workers], jobs);
        for job in jobs {
            self.take(&job.outcome);
        }
    }

    fn is_ready(&self, reaction: ReactionId) -> bool {
        let is_last = self.state.current == self.state.stop;
        let runs = |modes: &'static Modes| (modes.hooks.runs)(modes, self.modes, reaction, is_last);
        self.ready.contains(reaction.0) && self.tables.modes.is_none_or(runs)
    }

    /// What a reaction has asked for, after those before it.
    fn take(&mut self, outcome: &Outcome) {
        let State { stop, stop_request, .. } = self.state;
        *stop = outcome.stop.map_or(*stop, |asked| asked.min(*stop));
        *stop_request = outcome.stop_request.into_iter().chain(*stop_request).min();
        if let Some(error) = outcome.error {
            self.state.fail(error);
        }
        if let Some((modes, wanted)) = self.tables.modes.zip(outcome.mode) {
            (modes.hooks.request)(modes, self.modes, wanted);
        }
    }
}

impl fmt::Debug for Level<'_, '_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Level").field("workers", &self.workers).finish_non_exhaustive()
    }
}

/// State that any thread can have at its turn; generated code asks for it where the state is declared.
pub const fn moves_between_threads<T: Send>() {}

/// A value that several threads can see at once; generated code asks for it where the port is declared. What cannot be
/// seen by others could not be moved to them either, but for guards of locks: one question is enough.
pub const fn seen_by_threads<T: Sync>() {}
