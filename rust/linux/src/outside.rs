// SPDX-License-Identifier: Apache-2.0
//! The state that the threads of a program share with its event loop.

use std::ffi::{CStr, CString};
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use lf_coordination::clock_sync::ClockCorrection;
use lf_model::time::Instant;
use lf_model::{Mailbox, Outside};

use crate::clock::Clock;
use crate::wake::WakeUp;

static PROGRAM: OnceLock<HostOutside> = OnceLock::new();

/// The clock of the federation, the wake-up of the event loop and the mailbox of this process.
#[derive(Debug)]
pub(crate) struct HostOutside {
    clock: Clock,
    /// The last reading of the clock by the event loop, in nanoseconds: it may have announced everything up to it.
    read: AtomicI64,
    physical: Mutex<Physical>,
    mailbox: Mailbox,
    /// When the program started, by this computer's clock.
    start: OnceLock<Instant>,
    /// The federation that this process has joined.
    federation_id: OnceLock<CString>,
}

/// Physical time, as the program's threads see it.
#[derive(Debug)]
struct Physical {
    correction: ClockCorrection,
    /// The latest time that any thread has received. A thread may receive the time between the event loop's reading of
    /// the clock and the change of rate that this led to; no thread receives an earlier time then.
    latest: Instant,
}

impl HostOutside {
    /// Returns the one of this process; the first call reads the wall clock.
    pub(crate) fn of_program() -> &'static Self {
        PROGRAM.get_or_init(|| Self::new(Clock::new()))
    }

    /// Makes virtual time that of this process, before anybody has read the clock.
    pub(crate) fn begin_virtual_time() {
        PROGRAM.get_or_init(|| Self::new(Clock::of_virtual_time()));
    }

    fn new(clock: Clock) -> Self {
        Self {
            clock,
            read: AtomicI64::new(i64::MIN),
            physical: Mutex::new(Physical { correction: ClockCorrection::NONE, latest: Instant::NEVER }),
            mailbox: Mailbox::new(),
            start: OnceLock::new(),
            federation_id: OnceLock::new(),
        }
    }

    /// Sets the id of the federation that this process joins. An id with a byte 0 cannot come from a command line.
    pub(crate) fn set_federation_id(&self, id: &str) {
        if let Ok(id) = CString::new(id) {
            self.federation_id.get_or_init(|| id);
        }
    }

    /// Reads the uncorrected clock of this process, for its event loop.
    pub(crate) fn read(&self) -> Instant {
        let now = self.clock.now();
        // Events are taken out later behind a lock, and so is the caller of this: see `Inbox::post`.
        self.read.store(now.as_nanos(), Ordering::Relaxed);
        now
    }

    /// Returns the uncorrected clock of this process.
    pub(crate) fn clock(&self) -> Clock {
        self.clock
    }

    /// Returns when the program started, by this computer's uncorrected clock: changes of pins have its times, as an
    /// oscilloscope is not part of the federation.
    pub(crate) fn start(&self) -> Option<Instant> {
        self.start.get().copied()
    }

    /// See [`lf_runtime::platform::Platform::set_correction`].
    pub(crate) fn set_correction(&self, correction: ClockCorrection) {
        let mut physical = self.physical.lock().unwrap_or_else(PoisonError::into_inner);
        if physical.correction.is_step(&correction) {
            physical.latest = Instant::NEVER;
        }
        physical.correction = correction;
    }
}

/// The same at a time in the past, when the system's monotonic clock showed this number of nanoseconds; or, if that is
/// later, at the last reading of the event loop.
#[cfg(feature = "devices")]
#[derive(Debug)]
pub(crate) struct HostOutsideAt(pub(crate) &'static HostOutside, pub(crate) i64);

#[cfg(feature = "devices")]
impl Outside for HostOutsideAt {
    fn physical_time(&self) -> Instant {
        let Self(host, monotonic) = self;
        let read = Instant::from_nanos(host.read.load(Ordering::Relaxed));
        let time = host.clock.at(*monotonic).max(read).min(host.clock.now());
        host.physical.lock().unwrap_or_else(PoisonError::into_inner).correction.physical(time)
    }

    fn wake(&self) {
        self.0.wake();
    }

    fn mailbox(&self) -> &Mailbox {
        self.0.mailbox()
    }
}

impl Outside for HostOutside {
    fn physical_time(&self) -> Instant {
        let mut physical = self.physical.lock().unwrap_or_else(PoisonError::into_inner);
        physical.latest = physical.correction.physical(self.clock.now()).max(physical.latest);
        physical.latest
    }

    fn wake(&self) {
        WakeUp::wake_program();
    }

    fn mailbox(&self) -> &Mailbox {
        &self.mailbox
    }

    fn federation_id(&self) -> &'static CStr {
        Self::of_program().federation_id.get().map_or(c"", CString::as_c_str)
    }

    fn starts(&self, start: Instant) {
        let (before, physical, after) = (self.clock.now(), self.physical_time(), self.clock.now());
        // If they cannot be distinguished, they are one clock.
        let is_one = (before..=after).contains(&physical);
        let by_computer = if is_one { start } else { after.saturating_add(start.since(physical)) };
        self.start.get_or_init(|| by_computer);
    }
}

#[cfg(all(test, feature = "devices"))]
mod tests {
    use super::*;

    #[test]
    fn a_time_in_the_past_is_exact_back_to_what_the_event_loop_has_read() {
        let host: &'static HostOutside = Box::leak(Box::new(HostOutside::new(Clock::new())));
        let nanoseconds = |time: Instant| time.as_nanos() - host.clock.at(0).as_nanos();
        let before = nanoseconds(host.clock.now());
        assert_eq!(HostOutsideAt(host, before).physical_time(), host.clock.at(before));
        let read = host.read();
        assert_eq!(HostOutsideAt(host, before).physical_time(), read);
        let after = nanoseconds(host.clock.now());
        assert_eq!(HostOutsideAt(host, after).physical_time(), host.clock.at(after));
        // A driver's clock may be another one: nothing comes from the future.
        let promised = HostOutsideAt(host, i64::MAX).physical_time();
        assert!(promised >= read && promised <= host.clock.now());
    }
}
