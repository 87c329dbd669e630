// SPDX-License-Identifier: Apache-2.0
//! The event loop of a program that is not federated.

use lf_coordination::Deadline;
use lf_model::time::Tag;
use lf_model::{Engine, Env, Outgoing, Outside, Program, Progress, SendError};

use crate::error::RunError;
use crate::platform::Platform;

/// Runs an unfederated main reactor from its start, which is now, to its end.
///
/// # Errors
/// Why it ended early.
pub fn run_unfederated<P: Platform>(
    platform: &mut P,
    program: &mut dyn Program,
    mut engine: Engine<'_>,
) -> Result<(), RunError> {
    let mut world = World(platform.outside());
    engine.start(world.0.physical_time());
    let mut asked_to_stop = false;
    while !engine.is_done() {
        if !asked_to_stop && platform.interrupted() {
            // The shutdown reactions still run, so that the program leaves its surroundings in order.
            asked_to_stop = true;
            engine.set_stop_tag(Tag::NEVER);
        }
        engine.drain_physical(program, &world);
        let Some(tag) = engine.next_tag() else {
            if !engine.stop_if_idle(&world) {
                platform.wait(Deadline::Never, &mut |_, _| {});
            }
            continue;
        };
        if !engine.settings().fast && !asked_to_stop && platform.now() < tag.time {
            platform.wait(Deadline::At(tag.time), &mut |_, _| {});
            continue;
        }
        engine.begin(program, tag)?;
        match engine.advance(program, &mut world, None) {
            Progress::Complete => {}
            Progress::Failed(error) => return Err(error.into()),
            Progress::OutputFull { .. } | Progress::LevelLimit { .. } => {
                unreachable!("there is no output to be full, and no limit was given")
            }
        }
    }
    if asked_to_stop { Err(RunError::Interrupted) } else { Ok(()) }
}

/// The world of a program without neighbors.
struct World(&'static dyn Outside);

impl Env for World {
    fn outside(&self) -> &'static dyn Outside {
        self.0
    }

    fn send(&mut self, _message: &Outgoing<'_>) -> Result<(), SendError> {
        // The compiler gives outputs to federates only; without a connection nothing is lost by saying that it went.
        Ok(())
    }
}
