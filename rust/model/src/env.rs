// SPDX-License-Identifier: Apache-2.0
//! The engine's interface to the event loop.
use crate::ids::ReactionId;
use crate::outside::Outside;
use crate::part::Part;
use crate::payload::PayloadError;
use crate::tables::NetworkOutput;
use crate::time::{Instant, Tag};

/// A value that is being sent to another federate.
#[derive(Clone, Copy)]
pub struct Outgoing<'a> {
    /// The connection.
    pub output: &'static NetworkOutput,
    /// The tag at which it arrives: the current one with the connection's delay.
    pub tag: Tag,
    /// Writes the value into the bytes.
    pub(crate) encode: &'a dyn Fn(&mut [u8]) -> Result<usize, PayloadError>,
}

impl Outgoing<'_> {
    /// Writes the value's bytes, at most [`NetworkOutput::max_len`] of them; returns their number.
    ///
    /// # Errors
    /// When they do not fit, or the value has no form as bytes.
    pub fn encode(&self, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        (self.encode)(bytes)
    }
}

/// The reason why a value was not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SendError {
    /// The out-buffer has no room now; the engine holds the tag open, and tries again at the next `advance`.
    NoRoom,
    /// [`Outgoing::encode`] failed.
    Payload(PayloadError),
}

/// A step of a reaction, for recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReactionStep {
    /// It begins: its body, or one of its handlers.
    Begins(ReactionId, Part),
    /// It has ended.
    Ends(ReactionId),
}

/// The event loop's services for the engine while a tag runs.
pub trait Env {
    /// Returns the part that other threads may use too.
    fn outside(&self) -> &'static dyn Outside;

    /// Returns physical time on the federation's clock.
    fn physical_time(&self) -> Instant {
        self.outside().physical_time()
    }

    /// Puts a value into the out-buffer of its connection, completely or not at all.
    ///
    /// # Errors
    /// [`SendError::NoRoom`] when it does not fit now.
    fn send(&mut self, message: &Outgoing<'_>) -> Result<(), SendError>;

    /// Sends the receiver of an output with [`NetworkOutput::tells_absence`] that it has no value at `tag`, the current
    /// tag with the connection's delay. An environment without other federates has no receiver.
    ///
    /// # Errors
    /// [`SendError::NoRoom`] when the message does not fit now.
    fn send_absent(&mut self, _output: &'static NetworkOutput, _tag: Tag) -> Result<(), SendError> {
        Ok(())
    }

    /// Handles a step of a reaction, now; or one in a worker, by its number from 1, at a physical time.
    #[cfg(feature = "traces")]
    fn step(&mut self, _step: ReactionStep, _worker: Option<(u16, Instant)>) {}
}
