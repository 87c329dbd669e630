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
    physical: Mutex<Physical>,
    mailbox: Mailbox,
}

/// Physical time, as the program's threads see it.
#[derive(Debug)]
struct Physical {
    correction: ClockCorrection,
    /// The latest that anybody was told. A thread may be told the time between the event loop's reading of the clock
    /// and the change of rate that this led to; nobody is told an earlier time then.
    latest: Instant,
}

impl HostOutside {
    /// The one of this process; the first call reads the wall clock.
    pub(crate) fn of_program() -> &'static Self {
        PROGRAM.get_or_init(|| Self {
            clock: Clock::new(),
            physical: Mutex::new(Physical { correction: ClockCorrection::NONE, latest: Instant::NEVER }),
            mailbox: Mailbox::new(),
        })
    }

    /// The uncorrected clock of this process.
    pub(crate) fn clock(&self) -> Clock {
        self.clock
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
}
