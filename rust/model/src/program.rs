// SPDX-License-Identifier: Apache-2.0
//! The engine's interface to the generated program.
use crate::cell::{Placed, TriggerCell, Undelivered};
use crate::context::ReactionContext;
use crate::modes::ModeCells;
use crate::payload::PayloadError;
use crate::queue::Full;
use crate::tables::{InputId, OutputId, PortId, ReactionId, Tables, TriggerId};
use crate::time::Tag;

/// A federate's program, as the compiler generates it: one struct that owns all state, ports and queues.
///
/// Each method is one `match` over the ids that it concerns; unknown ids have the default behaviour here, which is that
/// of a program without such parts. `tests/bench` of this crate has a complete one.
pub trait Program {
    /// Returns the program's constant part.
    fn tables(&self) -> &'static Tables;

    /// Runs the body of a reaction. Never called for reactions that send.
    fn react(&mut self, _reaction: ReactionId, _ctx: &mut ReactionContext<'_>) {}

    /// Runs the deadline's handler instead of the body. Never called for reactions without a deadline.
    fn miss_deadline(&mut self, _reaction: ReactionId, _ctx: &mut ReactionContext<'_>) {}

    /// Runs the handler of a tardy input instead of the body. Never called for reactions without one.
    fn handle_tardy(&mut self, _reaction: ReactionId, _ctx: &mut ReactionContext<'_>) {}

    /// Lends the reactions of a level that can run side by side, each with a closure over the fields that it uses:
    ///
    /// ```text
    /// level.run::<4, { TABLES.note_words() }>(&lf::Threads::<4>, &mut [
    ///     Job::new(&[ReactionId(0)], &[TriggerId(1)], &mut |id, part, ctx| self.sensor.reaction_1(ctx, &mut self.y)),
    /// ])
    /// ```
    #[cfg(feature = "workers")]
    fn share(&mut self, _number: u16, _level: &mut crate::workers::Level<'_>) {}

    /// Makes a port that was set absent, at the end of a tag: `self.PORT.clear()`.
    fn clear_port(&mut self, _port: PortId) {}

    /// Returns the trigger, to move its event's value to where reactions see it. Startup and shutdown have no cell.
    fn trigger(&mut self, _trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
        None
    }

    /// Returns the parts in modes; nothing in a program without any.
    fn modes(&mut self) -> Option<&mut dyn ModeCells> {
        None
    }

    /// Copies the value of a delayed connection's source port to the connection's queue:
    /// `self.QUEUED_PORT.capture(tag, &self.SOURCE_PORT)`.
    ///
    /// # Errors
    /// When the queue is full.
    fn capture(&mut self, _trigger: TriggerId, _tag: Tag) -> Result<(), Full> {
        Ok(())
    }

    /// Writes the value of an output's source port as bytes: `self.SOURCE_PORT.encode(bytes)`. Returns their number.
    ///
    /// # Errors
    /// When there is no value, or it does not fit.
    fn encode(&self, _output: OutputId, _bytes: &mut [u8]) -> Result<usize, PayloadError> {
        Err(PayloadError::Absent)
    }

    /// Puts a message into an input's queue: `self.QUEUED_PORT.deliver(tag, bytes)`.
    ///
    /// # Errors
    /// When the queue is full, or the bytes are not a value.
    fn deliver(&mut self, _input: InputId, _tag: Tag, _bytes: &[u8]) -> Result<(), Undelivered> {
        Err(Undelivered::NoSuchPort)
    }

    /// Puts a message into the queue of an input with [`NetworkInput::tardy`](crate::NetworkInput::tardy), to take
    /// effect at `tag`; if it was intended for an earlier one, it is tardy: `self.TARDY_INPUT.deliver_tardy(tag,
    /// intended, bytes)`.
    ///
    /// # Errors
    /// When the queue is full, or the bytes are not a value.
    fn deliver_tardy(
        &mut self,
        _input: InputId,
        _tag: Tag,
        _intended: Tag,
        _bytes: &[u8],
    ) -> Result<Placed, Undelivered> {
        Err(Undelivered::NoSuchPort)
    }

    /// Writes the value of a state of [`Tables::handed_over`] as bytes. Returns their number.
    ///
    /// # Errors
    /// When it does not fit, or has no form as bytes.
    #[cfg(feature = "transients")]
    fn hand_over(&self, _state: u16, _bytes: &mut [u8]) -> Result<usize, PayloadError> {
        Err(PayloadError::Absent)
    }

    /// Sets a state of [`Tables::handed_over`] to the value that the instance before this one had.
    ///
    /// # Errors
    /// When the bytes are not a value of its type.
    #[cfg(feature = "transients")]
    fn take_over(&mut self, _state: u16, _bytes: &[u8]) -> Result<(), PayloadError> {
        Err(PayloadError::Absent)
    }
}
