// SPDX-License-Identifier: Apache-2.0
//! The two sides of the engine: the generated program, and the event loop that runs it.
use crate::context::ReactionContext;
use crate::error::DeliverError;
use crate::payload::PayloadError;
use crate::physical::Outside;
use crate::queue::Full;
use crate::tables::{ActionTiming, InputId, NetworkOutput, OutputId, PortId, ReactionId, Tables, TriggerId};
use crate::time::{Instant, Tag};

/// A federate's program, as the compiler generates it: one struct that owns all state, ports and queues.
///
/// Each method is one `match` over the ids that it concerns; ids it does not know are answered as the methods here do,
/// which are those of a program without such parts. `tests/as_generated.rs` of this crate shows a whole one.
pub trait Program {
    /// The program's constant part.
    fn tables(&self) -> &'static Tables;

    /// Runs the body of a reaction. Never called for reactions that send.
    fn react(&mut self, _reaction: ReactionId, _ctx: &mut ReactionContext<'_>) {}

    /// Runs the deadline's handler in place of the body. Never called for reactions without a deadline.
    fn miss_deadline(&mut self, _reaction: ReactionId, _ctx: &mut ReactionContext<'_>) {}

    /// Runs the handler of a tardy input in place of the body. Never called for reactions without one.
    fn handle_tardy(&mut self, _reaction: ReactionId, _ctx: &mut ReactionContext<'_>) {}

    /// The port, to clear it at the end of a tag.
    fn port(&mut self, _port: PortId) -> Option<&mut dyn PortCell> {
        None
    }

    /// The trigger, to move its event's value to where reactions see it. Startup and shutdown have no cell.
    fn trigger(&mut self, _trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
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

    /// Writes the value of an output's source port as bytes: `self.SOURCE_PORT.encode(bytes)`. Gives their number.
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

    /// Puts a message into the queue of an input with [`NetworkInput::tardy`](crate::NetworkInput::tardy), to happen at
    /// `tag`; if it was intended for an earlier one, it is tardy: `self.TARDY_INPUT.deliver_tardy(tag, intended,
    /// bytes)`.
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
}

/// Where a message stands in a queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placed {
    /// The tag at which it happens.
    pub tag: Tag,
    /// Whether it was intended for an earlier one.
    pub tardy: bool,
}

/// Why a queue did not take a message; the engine adds which one it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Undelivered {
    /// It is full.
    Full(Full),
    /// The bytes are not a value.
    Payload(PayloadError),
    /// The program has no such input.
    NoSuchPort,
}

impl Undelivered {
    pub(crate) fn at(self, input: &'static str, port: u16) -> DeliverError {
        match self {
            Self::Full(Full { capacity }) => DeliverError::Full { input, capacity },
            Self::Payload(error) => DeliverError::Payload { input, error },
            Self::NoSuchPort => DeliverError::NoSuchPort { port },
        }
    }
}

/// What the engine needs of a port.
pub trait PortCell {
    /// Whether it has a value at this tag.
    fn is_present(&self) -> bool;

    /// Drops the value, at the end of the tag.
    fn clear(&mut self);
}

/// What the engine needs of a trigger's queue.
pub trait TriggerCell {
    /// Makes the value of the event at `tag` visible to reactions; gives the tag of the next pending event.
    fn activate(&mut self, tag: Tag) -> Option<Tag>;

    /// Takes the value back, at the end of the tag.
    fn clear(&mut self);

    /// The tag of the earliest pending event.
    fn pending(&self) -> Option<Tag> {
        None
    }

    /// Whether another event fits.
    fn has_room(&self) -> bool {
        true
    }

    /// The tag that its value at this tag was intended for, if it is tardy.
    fn intended(&self) -> Option<Tag> {
        None
    }

    /// Schedules the events that came from other threads, as many as fit.
    fn drain(&mut self, _timing: &ActionTiming, _bounds: &Bounds) {}
}

/// Implements [`TriggerCell`] for a queue with a capacity by way of its view, so that the code exists once per type of
/// value, not once per capacity.
macro_rules! cell_by_view {
    ($owned:ident, $view:ident, T $($bound:tt)*) => {
        impl<T $($bound)*, const N: usize> TriggerCell for $owned<T, N> {
            fn activate(&mut self, tag: Tag) -> Option<Tag> {
                TriggerCell::activate(self as &mut $view<T>, tag)
            }
            fn clear(&mut self) {
                TriggerCell::clear(self as &mut $view<T>);
            }
            fn pending(&self) -> Option<Tag> {
                TriggerCell::pending(self as &$view<T>)
            }
            fn has_room(&self) -> bool {
                TriggerCell::has_room(self as &$view<T>)
            }
            fn intended(&self) -> Option<Tag> {
                TriggerCell::intended(self as &$view<T>)
            }
            fn drain(&mut self, timing: &crate::tables::ActionTiming, bounds: &crate::program::Bounds) {
                TriggerCell::drain(self as &mut $view<T>, timing, bounds);
            }
        }
    };
}
pub(crate) use cell_by_view;

/// The tags between which an event can be scheduled.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// The start of the program.
    pub start: Instant,
    /// The tag that is running, or was the last to run; events come after it.
    pub current: Tag,
    /// The last tag of the program; events after it are dropped.
    pub stop: Tag,
}

/// A value on its way to another federate.
#[derive(Clone, Copy)]
pub struct Outgoing<'a> {
    /// The connection.
    pub output: &'static NetworkOutput,
    /// The tag at which it arrives: the current one with the connection's delay.
    pub tag: Tag,
    pub(crate) id: OutputId,
    pub(crate) program: &'a dyn Program,
}

impl Outgoing<'_> {
    /// Writes the value's bytes, at most [`NetworkOutput::max_len`] of them; gives their number.
    ///
    /// # Errors
    /// When they do not fit, or the value has no form as bytes.
    pub fn encode(&self, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        self.program.encode(self.id, bytes)
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
}
