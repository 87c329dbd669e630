// SPDX-License-Identifier: Apache-2.0
//! What the threads of a program share with its event loop.

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
    correction: Mutex<ClockCorrection>,
    mailbox: Mailbox,
}

impl HostOutside {
    /// The one of this process; the first call reads the wall clock.
    pub(crate) fn of_program() -> &'static Self {
        PROGRAM.get_or_init(|| Self {
            clock: Clock::new(),
            correction: Mutex::new(ClockCorrection::NONE),
            mailbox: Mailbox::new(),
        })
    }

    /// The uncorrected clock of this process.
    pub(crate) fn clock(&self) -> Clock {
        self.clock
    }

    /// See [`lf_runtime::platform::Platform::set_correction`].
    pub(crate) fn set_correction(&self, correction: ClockCorrection) {
        *self.correction.lock().unwrap_or_else(PoisonError::into_inner) = correction;
    }
}

impl Outside for HostOutside {
    fn physical_time(&self) -> Instant {
        let correction = *self.correction.lock().unwrap_or_else(PoisonError::into_inner);
        correction.physical(self.clock.now())
    }

    fn wake(&self) {
        WakeUp::wake_program();
    }

    fn mailbox(&self) -> &Mailbox {
        &self.mailbox
    }
}
