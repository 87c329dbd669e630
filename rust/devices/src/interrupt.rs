// SPDX-License-Identifier: Apache-2.0
//! From an interrupt to a physical action.

use lf_model::{PhysicalActionRef, PhysicalLink, Poster, ScheduleError};

/// Which changes of an input schedule an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// It becomes active, as a button that is pressed.
    ToActive,
    /// It becomes inactive, as a button that is let go.
    ToInactive,
    /// Both.
    Both,
}

impl Edge {
    /// Whether a change to this is one of them.
    pub fn is(self, active: bool) -> bool {
        match self {
            Self::ToActive => active,
            Self::ToInactive => !active,
            Self::Both => true,
        }
    }
}

/// What values an action can have that edges schedule: `bool`, whether the input is active now, or none at all.
pub trait EdgeValue: sealed::Sealed + Sized + 'static {
    /// What posts them.
    #[doc(hidden)]
    fn poster(link: &PhysicalLink, action: &PhysicalActionRef<Self>) -> EdgePoster;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for bool {}
    impl Sealed for () {}
}

impl EdgeValue for bool {
    fn poster(link: &PhysicalLink, action: &PhysicalActionRef<Self>) -> EdgePoster {
        EdgePoster::Level(link.poster(action))
    }
}

impl EdgeValue for () {
    fn poster(link: &PhysicalLink, action: &PhysicalActionRef<Self>) -> EdgePoster {
        EdgePoster::Bare(link.poster(action))
    }
}

/// Schedules the action of an input.
#[derive(Clone, Debug)]
pub enum EdgePoster {
    /// It has no value.
    Bare(Poster<()>),
    /// Its value is whether the input is active.
    Level(Poster<bool>),
}

impl EdgePoster {
    /// Schedules the action now. Callable from interrupts.
    ///
    /// # Errors
    /// When as many events wait as there is room for; the event is then not scheduled.
    pub fn post(&self, active: bool) -> Result<(), ScheduleError> {
        match self {
            Self::Bare(poster) => poster.post(None),
            Self::Level(poster) => poster.post(Some(active)),
        }
    }
}
