// SPDX-License-Identifier: Apache-2.0
//! What other threads may use of a participant.
use core::cell::Cell;
use core::sync::atomic::{AtomicUsize, Ordering};

use critical_section::Mutex;

use crate::time::Instant;

/// What other threads may use of a participant: its clock and the wake-up of its event loop. One static per program.
pub trait Outside: Sync {
    /// Physical time on the federation's clock. It never runs backwards.
    fn physical_time(&self) -> Instant;

    /// Makes the event loop look for new events, now or when it next waits. Callable from interrupts on Zephyr.
    fn wake(&self);

    /// Where threads leave what concerns the whole program.
    fn mailbox(&self) -> &Mailbox;

    /// Is told at which physical time the program starts, before its first tag begins: what runs beside the program,
    /// such as a script for its devices, counts from there.
    fn starts(&self, _start: Instant) {}
}

/// What threads leave for the event loop besides events, and how many could still leave something.
#[derive(Debug)]
pub struct Mailbox {
    pub(crate) links: AtomicUsize,
    stop: Mutex<Cell<Option<Instant>>>,
}

impl Mailbox {
    /// An empty one.
    pub const fn new() -> Self {
        Self { links: AtomicUsize::new(0), stop: Mutex::new(Cell::new(None)) }
    }

    /// How many [`PhysicalLink`](crate::PhysicalLink)s live: as long as one does, an unfederated program without
    /// events does not end.
    pub fn links(&self) -> usize {
        self.links.load(Ordering::Acquire)
    }

    /// The time at which a thread asked the program to stop, if one did since the last call.
    pub(crate) fn take_stop(&self) -> Option<Instant> {
        critical_section::with(|cs| self.stop.borrow(cs).take())
    }

    pub(crate) fn request_stop(&self, time: Instant) {
        critical_section::with(|cs| {
            let stop = self.stop.borrow(cs);
            stop.set(Some(stop.get().map_or(time, |other| other.min(time))));
        });
    }
}

impl Default for Mailbox {
    fn default() -> Self {
        Self::new()
    }
}
