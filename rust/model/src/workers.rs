// SPDX-License-Identifier: Apache-2.0
//! Reactions of one level, side by side in several threads.
//!
//! Reactions of one level belong to different reactors, and none of them sets what another one sees. So generated code
//! lends each its own fields, by closures over them, and the borrow checker proves that they share nothing that one of
//! them changes. They write their changes of the engine's own state to notes, and the engine merges these when all have
//! run, in the order of the reactions. So the thread and the time of each reaction make no difference.
use core::fmt;

use crate::bits::Bits;
use crate::context::ReactionContext;
#[cfg(feature = "traces")]
use crate::env::ReactionStep;
use crate::env::{Env, Outgoing, SendError};
use crate::error::ModelError;
use crate::events::Events;
use crate::ids::{ReactionId, TriggerId};
use crate::modes::{ModeState, Transition};
use crate::outside::Outside;
use crate::part::Part;
use crate::state::{Settings, State, is_tardy};
use crate::tables::{Tables, words};
#[cfg(feature = "traces")]
use crate::time::Instant;
use crate::time::Tag;

/// The next tag of an action that may have been scheduled: before all others, until the engine has asked the action.
pub(crate) const ASKED: Tag = Tag::NEVER;

/// A pool of threads that share work.
pub trait WorkerPool: Sync {
    /// Makes the workers run the jobs, each job once and by any of them, and returns when all have run. One of the
    /// workers may be the caller's own thread.
    fn run(&self, workers: &mut [Worker<'_>], jobs: &mut [Job<'_>]);
}

/// The body of a job: calls the method of a reaction for a part of it.
type Body<'a> = dyn FnMut(ReactionId, Part, &mut ReactionContext<'_>) + Send + 'a;

/// A reaction that can run beside others of its level; or several of one reactor, which are in different modes.
pub struct Job<'a> {
    reactions: &'static [ReactionId],
    /// The ready reaction.
    reaction: ReactionId,
    actions: &'static [TriggerId],
    body: &'a mut Body<'a>,
    /// Whether it sees a tardy value.
    tardy: bool,
    outcome: Outcome,
}

/// The requests of a reaction.
#[derive(Clone, Copy, Debug, Default)]
struct Outcome {
    stop: Option<Tag>,
    stop_request: Option<Tag>,
    error: Option<ModelError>,
    mode: Option<Transition>,
    /// The part that has run, its worker, and the times of its begin and end.
    #[cfg(feature = "traces")]
    ran: Option<(Part, u16, [Instant; 2])>,
}

impl<'a> Job<'a> {
    /// Returns the job of a reaction, or of some that share what they change, in their order; with the actions that
    /// they can schedule, and a closure that calls their methods.
    pub fn new(reactions: &'static [ReactionId], actions: &'static [TriggerId], body: &'a mut Body<'a>) -> Self {
        let (reaction, outcome) = (ReactionId(u16::MAX), Outcome::default());
        Self { reactions, reaction, actions, body, tardy: false, outcome }
    }
}

impl fmt::Debug for Job<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Job").field(&self.reactions).finish()
    }
}

/// The state of one thread that runs jobs, and its notes about them.
pub struct Worker<'a> {
    #[cfg(feature = "traces")]
    number: u16,
    seen: Seen<'a>,
    notes: Notes<'a>,
}

/// The engine as the reactions of a level see it: as it was before any of them ran.
#[derive(Clone, Copy)]
struct Seen<'a> {
    tables: &'static Tables,
    settings: &'a Settings,
    state: State,
    intended: &'a [Tag],
    outside: &'static dyn Outside,
}

/// Sets, whose union does not depend on the order.
struct Notes<'a> {
    /// Triggered reactions, and those of them that are tardy.
    ready: Bits<'a>,
    tardy: Bits<'a>,
    /// Ports that were set.
    ports: Bits<'a>,
}

impl<'a> Worker<'a> {
    /// Returns notes in memory of [`Tables::note_words`], which is clear.
    fn new(seen: Seen<'a>, memory: &'a mut [u32]) -> Self {
        let (ready, memory) = memory.split_at_mut(words(seen.tables.reactions.len()));
        let (tardy, ports) = memory.split_at_mut(words(seen.tables.tardy_reactions()));
        Self {
            #[cfg(feature = "traces")]
            number: 0,
            seen,
            notes: Notes { ready: Bits(ready), tardy: Bits(tardy), ports: Bits(ports) },
        }
    }

    /// Runs a job.
    pub fn run(&mut self, job: &mut Job<'_>) {
        let Self { seen, notes, .. } = self;
        let info = &seen.tables.reactions[usize::from(job.reaction.0)];
        let (mut state, mut env) = (seen.state, WorkerEnv(seen.outside));
        let part = Part::of(info, job.tardy, state.current.time, || seen.outside.physical_time());
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
            runs_in_turn: false,
            mode: None,
            env: &mut env,
        };
        #[cfg(feature = "traces")]
        let begin = seen.state.records_steps.then(|| seen.outside.physical_time());
        (job.body)(job.reaction, part, &mut ctx);
        let mode = ctx.mode;
        let stop = Some(state.stop).filter(|stop| *stop < seen.state.stop);
        job.outcome = Outcome {
            stop,
            stop_request: state.stop_request,
            error: state.error,
            mode,
            #[cfg(feature = "traces")]
            ran: begin.map(|begin| (part, self.number, [begin, seen.outside.physical_time()])),
        };
    }
}

impl fmt::Debug for Worker<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Worker").field("state", &self.seen.state).finish_non_exhaustive()
    }
}

/// The environment of a reaction in any thread. Bodies do not send.
struct WorkerEnv(&'static dyn Outside);

impl Env for WorkerEnv {
    fn outside(&self) -> &'static dyn Outside {
        self.0
    }

    fn send(&mut self, _message: &Outgoing<'_>) -> Result<(), SendError> {
        Err(SendError::NoRoom)
    }
}

/// A level of the open tag, several reactions of which may be ready.
pub struct Level<'a> {
    pub(crate) tables: &'static Tables,
    pub(crate) settings: &'a Settings,
    pub(crate) state: &'a mut State,
    pub(crate) events: Events<'a>,
    pub(crate) ready: Bits<'a>,
    pub(crate) ports: Bits<'a>,
    pub(crate) tardy: Bits<'a>,
    pub(crate) intended: &'a [Tag],
    pub(crate) modes: &'a mut [ModeState],
    pub(crate) outside: &'static dyn Outside,
    #[cfg(feature = "traces")]
    pub(crate) env: &'a mut dyn Env,
}

impl Level<'_> {
    /// Makes `COUNT` workers, with `WORDS` of memory each, run the jobs whose reactions are ready, if they are several.
    /// A single one is left to the engine. The jobs are in the order of their reactions.
    ///
    /// # Panics
    /// When the memory is less than [`Tables::note_words`].
    pub fn run<const COUNT: usize, const WORDS: usize>(&mut self, pool: &dyn WorkerPool, jobs: &mut [Job<'_>]) {
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
            job.tardy = is_tardy(&self.tardy, job.reaction);
        }
        let mut memory = [[0; WORDS]; COUNT];
        let seen = Seen {
            tables: self.tables,
            settings: self.settings,
            state: *self.state,
            intended: self.intended,
            outside: self.outside,
        };
        let mut workers = memory.each_mut().map(|memory| Worker::new(seen, memory));
        #[cfg(feature = "traces")]
        for (number, worker) in (1..).zip(&mut workers) {
            worker.number = number;
        }
        pool.run(&mut workers[..COUNT.min(count)], jobs);
        for Worker { notes, .. } in workers {
            self.ready.insert_all(&notes.ready);
            self.ports.insert_all(&notes.ports);
            self.tardy.insert_all(&notes.tardy);
        }
        for job in jobs {
            self.take(&job.outcome);
            #[cfg(feature = "traces")]
            if let Some((part, worker, [begin, end])) = job.outcome.ran {
                self.env.step(ReactionStep::Begins(job.reaction, part), Some((worker, begin)));
                self.env.step(ReactionStep::Ends(job.reaction), Some((worker, end)));
            }
            for action in job.actions {
                self.events.set(*action, Some(ASKED));
            }
        }
    }

    fn is_ready(&self, reaction: ReactionId) -> bool {
        self.ready.contains(reaction.0) && self.tables.runs(self.modes, reaction, self.state.is_last())
    }

    /// Takes the requests of a reaction, after those before it.
    fn take(&mut self, outcome: &Outcome) {
        for (asked, is_federated) in [(outcome.stop, false), (outcome.stop_request, true)] {
            if let Some(tag) = asked {
                self.state.request_stop(tag, is_federated);
            }
        }
        if let Some(error) = outcome.error {
            self.state.fail(error);
        }
        if let Some(mode) = outcome.mode {
            self.tables.request_mode(self.modes, mode);
        }
    }
}

impl fmt::Debug for Level<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Level").field("state", &self.state).finish_non_exhaustive()
    }
}

/// Asserts that any thread can have this state at a time; generated code calls it where the state is declared.
pub const fn moves_between_threads<T: Send>() {}

/// Asserts that several threads can see a value at once; generated code calls it where the port is declared. A value
/// that others cannot see could not be moved to them either, except for guards of locks: one assertion is enough.
pub const fn seen_by_threads<T: Sync>() {}
