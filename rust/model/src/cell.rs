// SPDX-License-Identifier: Apache-2.0
//! The interfaces of ports, timers, actions and inputs for the engine and bodies, independent of their value types.
use crate::error::DeliverError;
use crate::outside::Outside;
use crate::payload::PayloadError;
use crate::queue::Full;
use crate::tables::{ActionTiming, TriggerId};
use crate::time::{Instant, Interval, Tag};

/// A port, action or timer that a body can read.
pub trait Readable {
    /// The type of its values.
    type Value;

    /// Returns whether it has an event at the current tag.
    fn is_present(&self) -> bool;

    /// Returns the event's value, if there is an event and it has one.
    fn value(&self) -> Option<&Self::Value>;
}

/// A logical or physical action that a body can schedule.
pub trait Schedulable {
    /// The type of its values.
    type Value;

    /// Returns its id among the triggers.
    fn id(&self) -> TriggerId;

    /// Adds an event to its queue.
    ///
    /// # Errors
    /// When the queue is full.
    fn schedule(&mut self, value: Option<Self::Value>, context: &ScheduleContext<'_>) -> Result<(), Full>;

    /// Returns the tag of its earliest pending event.
    fn pending(&self) -> Option<Tag>;

    /// Returns the capacity of its queue.
    fn capacity(&self) -> usize;
}

/// Implements [`Schedulable`] for an action with a capacity by way of its view, so that the code exists once per type
/// of value, not once per capacity.
macro_rules! schedule_by_view {
    ($owned:ident, $view:ident, T $($bound:tt)*) => {
        impl<T $($bound)*, const N: usize> Schedulable for $owned<T, N> {
            type Value = T;
            fn id(&self) -> TriggerId {
                Schedulable::id(self as &$view<T>)
            }
            fn schedule(&mut self, value: Option<T>, context: &ScheduleContext<'_>) -> Result<(), Full> {
                Schedulable::schedule(self as &mut $view<T>, value, context)
            }
            fn pending(&self) -> Option<Tag> {
                Schedulable::pending(self as &$view<T>)
            }
            fn capacity(&self) -> usize {
                N
            }
        }
    };
}
pub(crate) use schedule_by_view;

/// The circumstances in which an event is scheduled.
#[allow(missing_debug_implementations)]
pub struct ScheduleContext<'a> {
    pub(crate) timing: &'a ActionTiming,
    pub(crate) offset: Interval,
    pub(crate) bounds: Bounds,
    pub(crate) outside: &'a dyn Outside,
}

/// The engine's interface of a trigger's queue.
pub trait TriggerCell {
    /// Makes the value of the event at `tag` visible to reactions; returns the tag of the next pending event.
    fn activate(&mut self, tag: Tag) -> Option<Tag>;

    /// Removes the value, at the end of the tag.
    fn clear(&mut self);

    /// Returns the tag of the earliest pending event.
    fn pending(&self) -> Option<Tag> {
        None
    }

    /// Returns whether another event fits.
    fn has_room(&self) -> bool {
        true
    }

    /// Returns the tag that its value at this tag was intended for, if it is tardy.
    fn intended(&self) -> Option<Tag> {
        None
    }

    /// Schedules the events that came from other threads, as many as fit.
    fn drain(&mut self, _timing: &ActionTiming, _bounds: &Bounds) {}

    /// Writes the value of its event at this tag as bytes, and returns their number; `None` if the event has no value,
    /// or none that has a form as bytes. It is for what comes from outside.
    #[cfg(feature = "traces")]
    fn encode_event(&self, _bytes: &mut [u8]) -> Option<Result<usize, PayloadError>> {
        None
    }
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
            fn drain(&mut self, timing: &crate::tables::ActionTiming, bounds: &crate::cell::Bounds) {
                TriggerCell::drain(self as &mut $view<T>, timing, bounds);
            }
            #[cfg(feature = "traces")]
            fn encode_event(&self, bytes: &mut [u8]) -> Option<Result<usize, crate::payload::PayloadError>> {
                TriggerCell::encode_event(self as &$view<T>, bytes)
            }
        }
    };
}
pub(crate) use cell_by_view;

/// Implements [`ModeCell`](crate::ModeCell) in the same way.
macro_rules! mode_by_view {
    ($owned:ident, $view:ident, T $($bound:tt)*) => {
        impl<T $($bound)*, const N: usize> ModeCell for $owned<T, N> {
            fn shift(&mut self, from: Tag, to: Tag) -> Option<Tag> {
                ModeCell::shift(self as &mut $view<T>, from, to)
            }
            fn discard(&mut self) {
                ModeCell::discard(self as &mut $view<T>);
            }
            fn forget(&mut self) {
                ModeCell::forget(self as &mut $view<T>);
            }
        }
    };
}
pub(crate) use mode_by_view;

/// The tags between which an event can be scheduled.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// The time of the program's first tag.
    pub start: Instant,
    /// The tag that is running, or was the last to run; events come after it.
    pub current: Tag,
    /// The last tag of the program; events after it are dropped.
    pub stop: Tag,
}

/// The tag that a message got in a queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placed {
    /// The tag at which it happens.
    pub tag: Tag,
    /// Whether it was intended for an earlier one.
    pub tardy: bool,
}

/// The reason why a queue did not take a message; the engine adds the queue's name.
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
