// SPDX-License-Identifier: Apache-2.0
//! The places of devices whose interrupts schedule actions.

use core::cell::RefCell;
use core::ffi::c_int;
use core::fmt;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use critical_section::Mutex;
use lf_devices::{EventPoster, Problem};
use lf_model::PhysicalLink;
use lf_runtime::{DeviceEvent, report};
use log::Level;

use super::spec::outcome;
use crate::kconfig::LF_INTERRUPTS;
use crate::raw;

/// A device that is watched, or could be.
struct WatchPlace {
    taken: AtomicBool,
    /// What its interrupts do, and whose they are.
    watched: Mutex<RefCell<Option<(EventPoster, &'static str)>>>,
    /// How many of them found no room since the event loop has told of it.
    lost: AtomicU32,
}

static PLACES: [WatchPlace; LF_INTERRUPTS] = [const {
    WatchPlace { taken: AtomicBool::new(false), watched: Mutex::new(RefCell::new(None)), lost: AtomicU32::new(0) }
}; LF_INTERRUPTS];

/// Whether any place has lost some.
static LOST: AtomicBool = AtomicBool::new(false);

/// The interrupts of a device, until this is dropped.
#[derive(Debug)]
pub struct Watch<S: Source> {
    place: usize,
    source: S,
    /// Keeps the program going for what may still come.
    _link: PhysicalLink,
}

/// A device that has interrupts.
pub trait Source: fmt::Debug {
    /// Begins them; they call the handler with the number of the place. Returns what C does.
    fn begin(&self, place: usize, handler: raw::lf_device_handler) -> c_int;
    /// Ends them.
    fn end(&self, place: usize);
}

impl<S: Source> Watch<S> {
    /// Watches the device of this name.
    pub(super) fn new(name: &'static str, source: S, link: PhysicalLink, poster: EventPoster) -> Result<Self, Problem> {
        let take = |place: &WatchPlace| !place.taken.swap(true, Ordering::Acquire);
        let free = PLACES.iter().position(take).ok_or(Problem::NoInterruptLeft { interrupts: LF_INTERRUPTS })?;
        let place = &PLACES[free];
        critical_section::with(|section| {
            *place.watched.borrow_ref_mut(section) = Some((poster, name));
        });
        match outcome(source.begin(free, Some(happened))) {
            Ok(_) => Ok(Self { place: free, source, _link: link }),
            Err(problem) => {
                place.give_back();
                Err(problem)
            }
        }
    }
}

impl<S: Source> Drop for Watch<S> {
    fn drop(&mut self) {
        self.source.end(self.place);
        // Afterwards nobody knows whose they were.
        tell_of_lost();
        PLACES[self.place].give_back();
    }
}

impl WatchPlace {
    fn name(&self) -> Option<&'static str> {
        critical_section::with(|section| self.watched.borrow_ref(section).as_ref().map(|(_, name)| *name))
    }

    fn give_back(&self) {
        critical_section::with(|section| *self.watched.borrow_ref_mut(section) = None);
        self.taken.store(false, Ordering::Release);
    }
}

/// What C calls at an event, from the interrupt as a rule.
unsafe extern "C" fn happened(place: usize, value: u8) {
    let place = &PLACES[place];
    // It is copied out, because the event loop must not be woken while interrupts are locked.
    let poster = critical_section::with(|section| place.watched.borrow_ref(section).as_ref().map(|(it, _)| it.clone()));
    if poster.is_some_and(|poster| poster.post(value).is_err()) {
        place.lost.fetch_add(1, Ordering::Relaxed);
        LOST.store(true, Ordering::Release);
    }
}

/// Says how many interrupts have found no room since the last call.
pub(crate) fn tell_of_lost() {
    if !LOST.load(Ordering::Relaxed) || !LOST.swap(false, Ordering::Acquire) {
        return;
    }
    for place in &PLACES {
        let events = place.lost.swap(0, Ordering::Relaxed);
        if let (1.., Some(device)) = (events, place.name()) {
            report(Level::Warn, &DeviceEvent::EventsLost { device, events });
        }
    }
}
