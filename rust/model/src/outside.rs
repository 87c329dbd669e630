// SPDX-License-Identifier: Apache-2.0
//! The parts of a participant that other threads may use.
use core::cell::Cell;
#[cfg(feature = "transients")]
use core::ffi::CStr;
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering, fence};

use critical_section::Mutex;

use crate::time::Instant;

/// The parts of a participant that other threads may use: its clock and the wake-up of its event loop. One static per
/// program.
pub trait Outside: Sync {
    /// Returns physical time on the federation's clock. It never runs backwards.
    fn physical_time(&self) -> Instant;

    /// Makes the event loop look for new events, now or when it next waits. Callable from interrupts on Zephyr.
    fn wake(&self);

    /// Returns the mailbox for requests about the whole program.
    fn mailbox(&self) -> &Mailbox;

    /// Returns the id of the federation; empty where the program is not federated.
    #[cfg(feature = "transients")]
    fn federation_id(&self) -> &'static CStr {
        c""
    }

    /// Is told at which physical time the program starts, before its first tag begins: what runs beside the program,
    /// such as a script for its devices, counts from there.
    fn starts(&self, _start: Instant) {}
}

/// The requests of threads to the event loop besides events, and the number of threads that could still make one.
#[derive(Debug)]
pub struct Mailbox {
    pub(crate) links: AtomicUsize,
    /// Whether the event loop has looked into the inboxes of physical actions, and at `stop`, since the last change.
    seen: AtomicBool,
    stop: Mutex<Cell<Option<Instant>>>,
}

impl Mailbox {
    /// Returns an empty mailbox.
    pub const fn new() -> Self {
        Self { links: AtomicUsize::new(0), seen: AtomicBool::new(false), stop: Mutex::new(Cell::new(None)) }
    }

    /// Returns the number of living [`PhysicalLink`](crate::PhysicalLink)s: while there is one, an unfederated program
    /// without events does not end.
    pub fn links(&self) -> usize {
        self.links.load(Ordering::Acquire)
    }

    /// Makes the event loop look for events when it next drains them. A thread calls it while the event loop cannot
    /// take events out, and before it reads the clock.
    pub(crate) fn announce(&self) {
        self.seen.store(false, Ordering::Release);
        // With that of `take_news`: if the event loop has read a later time than the thread will, it sees this.
        fence(Ordering::SeqCst);
    }

    /// Returns whether something was announced since the last call, or this is the first call. What is announced from
    /// then on counts for the next call; it may have been seen already.
    pub(crate) fn take_news(&self) -> bool {
        fence(Ordering::SeqCst);
        // Not a swap: nearly all calls find nothing, and then only read.
        let has_news = !self.seen.load(Ordering::Acquire);
        if has_news {
            self.seen.store(true, Ordering::Release);
        }
        has_news
    }

    /// Returns the time at which a thread asked the program to stop, if one did since the last call.
    pub(crate) fn take_stop(&self) -> Option<Instant> {
        critical_section::with(|cs| self.stop.borrow(cs).take())
    }

    pub(crate) fn request_stop(&self, time: Instant) {
        critical_section::with(|cs| {
            let stop = self.stop.borrow(cs);
            stop.set(Some(stop.get().map_or(time, |other| other.min(time))));
        });
        self.announce();
    }
}

impl Default for Mailbox {
    fn default() -> Self {
        Self::new()
    }
}
