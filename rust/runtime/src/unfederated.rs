// SPDX-License-Identifier: Apache-2.0
//! The event loop of a program that is not federated.

use core::fmt;

use lf_coordination::Deadline;
#[cfg(feature = "traces")]
use lf_model::ReactionStep;
use lf_model::time::{Instant, Tag};
use lf_model::{Engine, Env, Outgoing, Outside, Program, Progress, SendError};

use crate::error::RunError;
use crate::platform::Platform;
#[cfg(feature = "traces")]
use crate::trace::step_event;
use crate::trace::{Event, Recording, Role, waits};
use crate::turn::Turn;

/// The event loop of an unfederated main reactor. Call [`UnfederatedLoop::turn`] and [`UnfederatedLoop::wait`]
/// alternately to drive it.
pub struct UnfederatedLoop<'a, 's, P> {
    platform: &'a mut P,
    program: &'a mut dyn Program,
    engine: Engine<'s>,
    world: IdleEnv,
    recording: Recording<'a>,
    asked_to_stop: bool,
    /// The last reading of the platform's clock, which never runs backwards.
    now: Instant,
}

impl<P> fmt::Debug for UnfederatedLoop<'_, '_, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("UnfederatedLoop").field("asked_to_stop", &self.asked_to_stop).finish_non_exhaustive()
    }
}

impl<'a, 's, P: Platform> UnfederatedLoop<'a, 's, P> {
    /// Returns a program that starts now.
    pub fn new(platform: &'a mut P, program: &'a mut dyn Program, mut engine: Engine<'s>) -> Self {
        let world = IdleEnv(platform.outside());
        let start = world.0.physical_time();
        world.0.starts(start);
        engine.start(start);
        Self { platform, program, engine, world, recording: Recording::OFF, asked_to_stop: false, now: Instant::NEVER }
    }

    /// Tells what happens from now on.
    pub fn record<'r: 'a>(&mut self, recording: Recording<'r>) {
        self.recording = recording.for_less();
        self.recording.begin(self.platform, Role::Program, Some(self.engine.tables()));
        let start = Event::Starts(self.engine.start_time(), self.engine.settings().fast);
        self.recording.note(self.platform, start);
        #[cfg(feature = "traces")]
        self.engine.record_steps(self.recording.is_on());
    }

    /// Runs the program to its end.
    ///
    /// # Errors
    /// Why it ended early.
    pub fn run(&mut self) -> Result<(), RunError> {
        loop {
            match self.turn() {
                Turn::Wait(until) => self.wait(until),
                Turn::Ended(result) => return result,
            }
        }
    }

    /// Runs at most one tag, the next one if it is due.
    pub fn turn(&mut self) -> Turn<Result<(), RunError>> {
        if self.engine.is_done() {
            self.recording.note(self.platform, Event::Ends(self.asked_to_stop));
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
        if !self.engine.settings().fast && !self.asked_to_stop && !self.has_come(tag.time) {
            return Turn::Wait(Deadline::At(tag.time));
        }
        match self.run_tag(tag) {
            Ok(()) => Turn::Wait(Deadline::Now),
            Err(error) => {
                self.recording.note(self.platform, Event::Ends(true));
                Turn::Ended(Err(error))
            }
        }
    }

    /// Waits until another thread has something for the program, or the deadline of the last [`UnfederatedLoop::turn`]
    /// has come.
    pub fn wait(&mut self, until: Deadline) {
        if until != Deadline::Now {
            if self.recording.is_on() {
                let waits = waits(None, None, self.engine.next_tag(), until != Deadline::Never);
                self.recording.note(self.platform, Event::WaitBegins(waits));
            }
            self.platform.wait(until, &mut |_, _| {});
            self.recording.note(self.platform, Event::WaitEnds);
        }
    }

    /// Returns whether a time has come. Tags of one time need one reading of the clock.
    fn has_come(&mut self, time: Instant) -> bool {
        if self.now < time {
            self.now = self.platform.now();
        }
        self.now >= time
    }

    fn run_tag(&mut self, tag: Tag) -> Result<(), RunError> {
        self.engine.begin(self.program, tag)?;
        self.recording.note_tag(self.platform, &self.engine, self.program);
        let mut alone = UnfederatedEnv { platform: self.platform, recording: &mut self.recording };
        let progress = self.engine.advance(self.program, &mut alone, None);
        self.recording.note(self.platform, Event::TagEnds(tag));
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
struct UnfederatedEnv<'x, 'a, P> {
    platform: &'x mut P,
    #[cfg_attr(not(feature = "traces"), expect(dead_code, reason = "nothing is recorded"))]
    recording: &'x mut Recording<'a>,
}

impl<P: Platform> Env for UnfederatedEnv<'_, '_, P> {
    fn outside(&self) -> &'static dyn Outside {
        self.platform.outside()
    }

    fn send(&mut self, _message: &Outgoing<'_>) -> Result<(), SendError> {
        // The compiler makes outputs for federates only; without a connection nothing is lost.
        Ok(())
    }

    #[cfg(feature = "traces")]
    fn step(&mut self, step: ReactionStep, worker: Option<(u16, Instant)>) {
        // The clock of a program that is not federated has no correction.
        let at = worker.map_or_else(|| self.platform.now(), |(_, at)| at);
        self.recording.note_at(at, step_event(step, worker.map_or(0, |(worker, _)| worker)));
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
