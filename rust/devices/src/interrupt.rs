// SPDX-License-Identifier: Apache-2.0
//! Physical actions that interrupts schedule.

use lf_model::{Outside, PhysicalActionRef, PhysicalLink, Poster, ReactionContext, ScheduleError};

use crate::error::DeviceError;

/// The changes of an input that schedule an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// It becomes active, like a pressed button.
    ToActive,
    /// It becomes inactive, like a released button.
    ToInactive,
    /// Both.
    Both,
}

impl Edge {
    /// Returns whether a change to `active` is one of them.
    pub fn is(self, active: bool) -> bool {
        match self {
            Self::ToActive => active,
            Self::ToInactive => !active,
            Self::Both => true,
        }
    }
}

/// A type of values of an action that a device's events schedule: that of the event, `bool` for edges and `u8` for
/// received bytes, or none at all.
pub trait EventValue<Event>: sealed::Sealed<Event> + Sized + 'static {
    /// Returns a poster of such events.
    #[doc(hidden)]
    fn poster(link: &PhysicalLink, action: &PhysicalActionRef<Self>) -> EventPoster;
}

mod sealed {
    pub trait Sealed<Event> {}
    impl Sealed<bool> for bool {}
    impl Sealed<u8> for u8 {}
    impl<Event> Sealed<Event> for () {}
}

impl EventValue<bool> for bool {
    fn poster(link: &PhysicalLink, action: &PhysicalActionRef<Self>) -> EventPoster {
        EventPoster::Level(link.poster(action))
    }
}

impl EventValue<u8> for u8 {
    fn poster(link: &PhysicalLink, action: &PhysicalActionRef<Self>) -> EventPoster {
        EventPoster::Byte(link.poster(action))
    }
}

impl<Event> EventValue<Event> for () {
    fn poster(link: &PhysicalLink, action: &PhysicalActionRef<Self>) -> EventPoster {
        EventPoster::Bare(link.poster(action))
    }
}

/// Ends a watch, and begins another one that posts this action. The old one ends first, so that its slot is free.
pub(crate) fn begin<T: EventValue<Event>, Event, W>(
    watch: &mut Option<W>,
    ctx: &ReactionContext<'_>,
    action: &PhysicalActionRef<T>,
    start: impl FnOnce(PhysicalLink, EventPoster) -> Result<W, DeviceError>,
) -> Result<(), DeviceError> {
    *watch = None;
    let link = ctx.physical_link();
    let poster = T::poster(&link, action);
    *watch = Some(start(link, poster)?);
    Ok(())
}

/// Schedules the action of a device.
#[derive(Clone, Debug)]
pub enum EventPoster {
    /// It has no value.
    Bare(Poster<()>),
    /// Its value is whether the input is active.
    Level(Poster<bool>),
    /// Its value is the received byte.
    Byte(Poster<u8>),
}

impl EventPoster {
    /// Schedules the action now, with the value of the event: a level, 0 or 1, or a byte. Callable from interrupts.
    ///
    /// # Errors
    /// When the inbox is full; the event is then not scheduled.
    pub fn post(&self, value: u8) -> Result<(), ScheduleError> {
        match self {
            Self::Bare(poster) => poster.post(None),
            Self::Level(poster) => poster.post(Some(value != 0)),
            Self::Byte(poster) => poster.post(Some(value)),
        }
    }

    /// Schedules the action at the time that this clock shows: see [`Poster::post_by`].
    ///
    /// # Errors
    /// When the inbox is full; the event is then not scheduled.
    pub fn post_by(&self, clock: &dyn Outside, value: u8) -> Result<(), ScheduleError> {
        match self {
            Self::Bare(poster) => poster.post_by(clock, None),
            Self::Level(poster) => poster.post_by(clock, Some(value != 0)),
            Self::Byte(poster) => poster.post_by(clock, Some(value)),
        }
    }
}
