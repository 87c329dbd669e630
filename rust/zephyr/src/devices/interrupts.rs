// SPDX-License-Identifier: Apache-2.0
//! The slots of devices whose interrupts schedule actions.

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

/// A slot for a watched device.
struct WatchSlot {
    taken: AtomicBool,
    /// The action of its interrupts, and the device's name.
    watched: Mutex<RefCell<Option<(EventPoster, &'static str)>>>,
    /// The number of events without room since the last log event.
    lost: AtomicU32,
}

static SLOTS: [WatchSlot; LF_INTERRUPTS] = [const {
    WatchSlot { taken: AtomicBool::new(false), watched: Mutex::new(RefCell::new(None)), lost: AtomicU32::new(0) }
}; LF_INTERRUPTS];

/// Whether any slot has lost some.
static LOST: AtomicBool = AtomicBool::new(false);

/// The interrupts of a device, until this is dropped.
#[derive(Debug)]
pub struct Watch<S: Source> {
    slot: usize,
    source: S,
    /// Keeps the program alive for events that may still come.
    _link: PhysicalLink,
}

/// A device that has interrupts.
pub trait Source: fmt::Debug {
    /// Starts them; they call the handler with the number of the slot. Returns C's status.
    fn begin(&self, slot: usize, handler: raw::lf_device_handler) -> c_int;
    /// Ends them.
    fn end(&self, slot: usize);
}

impl<S: Source> Watch<S> {
    /// Watches the device of this name.
    pub(super) fn new(name: &'static str, source: S, link: PhysicalLink, poster: EventPoster) -> Result<Self, Problem> {
        let take = |slot: &WatchSlot| !slot.taken.swap(true, Ordering::Acquire);
        let free = SLOTS.iter().position(take).ok_or(Problem::NoInterruptLeft { interrupts: LF_INTERRUPTS })?;
        let slot = &SLOTS[free];
        critical_section::with(|section| {
            *slot.watched.borrow_ref_mut(section) = Some((poster, name));
        });
        match outcome(source.begin(free, Some(happened))) {
            Ok(_) => Ok(Self { slot: free, source, _link: link }),
            Err(problem) => {
                slot.give_back();
                Err(problem)
            }
        }
    }
}

impl<S: Source> Drop for Watch<S> {
    fn drop(&mut self) {
        self.source.end(self.slot);
        // Afterwards the device is unknown.
        report_lost();
        SLOTS[self.slot].give_back();
    }
}

impl WatchSlot {
    fn name(&self) -> Option<&'static str> {
        critical_section::with(|section| self.watched.borrow_ref(section).as_ref().map(|(_, name)| *name))
    }

    fn give_back(&self) {
        critical_section::with(|section| *self.watched.borrow_ref_mut(section) = None);
        self.taken.store(false, Ordering::Release);
    }
}

/// Handles an event. C calls it, usually in the interrupt.
unsafe extern "C" fn happened(slot: usize, value: u8) {
    let slot = &SLOTS[slot];
    // It is copied, because the event loop must not be woken while interrupts are locked.
    let poster = critical_section::with(|section| slot.watched.borrow_ref(section).as_ref().map(|(it, _)| it.clone()));
    if poster.is_some_and(|poster| poster.post(value).is_err()) {
        slot.lost.fetch_add(1, Ordering::Relaxed);
        LOST.store(true, Ordering::Release);
    }
}

/// Logs how many interrupts have had no room since the last call.
pub(crate) fn report_lost() {
    if !LOST.load(Ordering::Relaxed) || !LOST.swap(false, Ordering::Acquire) {
        return;
    }
    for slot in &SLOTS {
        let events = slot.lost.swap(0, Ordering::Relaxed);
        if let (1.., Some(device)) = (events, slot.name()) {
            report(Level::Warn, &DeviceEvent::EventsLost { device, events });
        }
    }
}
