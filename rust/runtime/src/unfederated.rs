// SPDX-License-Identifier: Apache-2.0
//! The event loop of a program that is not federated.

use core::fmt;

use lf_coordination::Deadline;
#[cfg(feature = "traces")]
use lf_model::ReactionStep;
#[cfg(feature = "traces")]
use lf_model::time::Instant;
use lf_model::time::Tag;
use lf_model::{Engine, Env, Outgoing, Outside, Program, Progress, SendError};

use crate::error::RunError;
use crate::platform::Platform;
use crate::trace::{Event, Role};
use crate::tracing;
use crate::turn::Turn;

/// Runs an unfederated main reactor from its start, which is now, to its end.
///
/// # Errors
/// The reason why it ended early.
pub fn run_unfederated<P: Platform>(
    platform: &mut P,
    program: &mut dyn Program,
    engine: Engine<'_>,
) -> Result<(), RunError> {
    let mut alone = UnfederatedLoop::new(platform, program, engine);
    loop {
        match alone.turn() {
            Turn::Wait(until) => alone.wait(until),
            Turn::Ended(result) => return result,
        }
    }
}

/// The event loop of an unfederated main reactor. Call [`UnfederatedLoop::turn`] and [`UnfederatedLoop::wait`]
/// alternately to drive it.
pub struct UnfederatedLoop<'a, 's, P> {
    platform: &'a mut P,
    program: &'a mut dyn Program,
    engine: Engine<'s>,
    world: IdleEnv,
    asked_to_stop: bool,
}

impl<P> fmt::Debug for UnfederatedLoop<'_, '_, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("UnfederatedLoop").field("asked_to_stop", &self.asked_to_stop).finish_non_exhaustive()
    }
}

impl<'a, 's, P: Platform> UnfederatedLoop<'a, 's, P> {
    /// Returns a program that starts now.
    pub fn new(platform: &'a mut P, program: &'a mut dyn Program, mut engine: Engine<'s>) -> Self {
        tracing::begin(platform, Role::Program, Some(engine.tables()));
        let world = IdleEnv(platform.outside());
        let start = world.0.physical_time();
        platform.starts(start);
        engine.start(start);
        tracing::note(platform, Event::Starts(start, engine.settings().fast));
        Self { platform, program, engine, world, asked_to_stop: false }
    }

    /// Runs at most one tag, the next one if it is due.
    pub fn turn(&mut self) -> Turn<Result<(), RunError>> {
        if self.engine.is_done() {
            tracing::note(self.platform, Event::Ends(self.asked_to_stop));
            return Turn::Ended(if self.asked_to_stop { Err(RunError::Interrupted) } else { Ok(()) });
        }
        if !self.asked_to_stop && self.platform.interrupted() {
            // The shutdown reactions still run, so that the program can clean up.
            self.asked_to_stop = true;
            self.engine.set_stop_tag(Tag::NEVER);
        }
        self.engine.drain_physical(self.program, &self.world);
        let Some(tag) = self.engine.next_tag() else {
            let stops = self.engine.stop_if_idle(&self.world);
            return Turn::Wait(if stops { Deadline::Now } else { Deadline::Never });
        };
        if !self.engine.settings().fast && !self.asked_to_stop && self.platform.now() < tag.time {
            return Turn::Wait(Deadline::At(tag.time));
        }
        match self.run(tag) {
            Ok(()) => Turn::Wait(Deadline::Now),
            Err(error) => {
                tracing::note(self.platform, Event::Ends(true));
                Turn::Ended(Err(error))
            }
        }
    }

    /// Waits until another thread has something for the program, or the deadline of the last [`UnfederatedLoop::turn`]
    /// has come.
    pub fn wait(&mut self, until: Deadline) {
        if until != Deadline::Now {
            let next = self.engine.next_tag();
            let waits = tracing::waits(None, None, next, until != Deadline::Never);
            tracing::note(self.platform, Event::WaitBegins(waits));
            self.platform.wait(until, &mut |_, _| {});
            tracing::note(self.platform, Event::WaitEnds);
        }
    }

    fn run(&mut self, tag: Tag) -> Result<(), RunError> {
        self.engine.begin(self.program, tag)?;
        tracing::note(self.platform, Event::TagBegins(tag));
        let progress = self.engine.advance(self.program, &mut UnfederatedEnv(self.platform), None);
        tracing::note(self.platform, Event::TagEnds(tag));
        match progress {
            Progress::Complete => Ok(()),
            Progress::Failed(error) => Err(error.into()),
            Progress::OutputFull { .. } | Progress::LevelLimit { .. } => {
                unreachable!("there is no output to be full, and no limit was given")
            }
        }
    }
}

/// The environment of a tag in a program without neighbors.
struct UnfederatedEnv<'a, P>(&'a mut P);

impl<P: Platform> Env for UnfederatedEnv<'_, P> {
    fn outside(&self) -> &'static dyn Outside {
        self.0.outside()
    }

    fn send(&mut self, _message: &Outgoing<'_>) -> Result<(), SendError> {
        // The compiler makes outputs for federates only; without a connection nothing is lost.
        Ok(())
    }

    #[cfg(feature = "traces")]
    fn step(&mut self, step: ReactionStep, worker: Option<(u16, Instant)>) {
        // The clock of a program that is not federated has no correction.
        let at = worker.map_or_else(|| self.0.now(), |(_, at)| at);
        self.0.trace(at, tracing::step_event(step, worker.map_or(0, |(worker, _)| worker)));
    }
}

/// The environment of a program while no tag is open.
pub(crate) struct IdleEnv(pub(crate) &'static dyn Outside);

impl Env for IdleEnv {
    fn outside(&self) -> &'static dyn Outside {
        self.0
    }

    fn send(&mut self, _message: &Outgoing<'_>) -> Result<(), SendError> {
        // The compiler makes outputs for federates only; without a connection nothing is lost.
        Ok(())
    }
}
