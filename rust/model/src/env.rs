// SPDX-License-Identifier: Apache-2.0
//! The side of the engine on which the event loop is.
use crate::ids::ReactionId;
use crate::outside::Outside;
use crate::part::Part;
use crate::payload::PayloadError;
use crate::tables::NetworkOutput;
use crate::time::{Instant, Tag};

/// A value on its way to another federate.
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
    /// Writes the value's bytes, at most [`NetworkOutput::max_len`] of them; gives their number.
    ///
    /// # Errors
    /// When they do not fit, or the value has no form as bytes.
    pub fn encode(&self, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        (self.encode)(bytes)
    }
}

/// Why a value was not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SendError {
    /// The out-buffer has no room now; the engine holds the tag open, and tries again at the next `advance`.
    NoRoom,
    /// [`Outgoing::encode`] failed.
    Payload(PayloadError),
}

/// What a reaction does, for those who write down what happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReactionStep {
    /// It begins: its body, or one of its handlers.
    Begins(ReactionId, Part),
    /// It has ended.
    Ends(ReactionId),
}

/// What the event loop provides to the engine while a tag runs.
pub trait Env {
    /// The part that other threads may use too.
    fn outside(&self) -> &'static dyn Outside;

    /// Physical time on the federation's clock.
    fn physical_time(&self) -> Instant {
        self.outside().physical_time()
    }

    /// Puts a value into the out-buffer of its connection, whole or not at all.
    ///
    /// # Errors
    /// [`SendError::NoRoom`] when it does not fit now.
    fn send(&mut self, message: &Outgoing<'_>) -> Result<(), SendError>;

    /// Tells the receiver that an output with [`NetworkOutput::tells_absence`] has no value at `tag`, the current tag
    /// with the connection's delay. An environment without other federates has nobody to tell.
    ///
    /// # Errors
    /// [`SendError::NoRoom`] when the word does not fit now.
    fn send_absent(&mut self, _output: &'static NetworkOutput, _tag: Tag) -> Result<(), SendError> {
        Ok(())
    }

    /// Is told what a reaction does, now; or what one has done in a worker, by its number from 1, at a physical time.
    #[cfg(feature = "traces")]
    fn step(&mut self, _step: ReactionStep, _worker: Option<(u16, Instant)>) {}
}
