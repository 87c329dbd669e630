// SPDX-License-Identifier: Apache-2.0
//! What the threads of a program share with its event loop.

use core::cell::Cell;

use critical_section::Mutex;
use lf_coordination::clock_sync::ClockCorrection;
use lf_model::time::Instant;
use lf_model::{Mailbox, Outside};

use crate::{clock, wake};

static PROGRAM: ZephyrOutside =
    ZephyrOutside { correction: Mutex::new(Cell::new(ClockCorrection::NONE)), mailbox: Mailbox::new() };

/// The federation's clock, the wake-up of the event loop and the mailbox of this image.
#[derive(Debug)]
pub(crate) struct ZephyrOutside {
    correction: Mutex<Cell<ClockCorrection>>,
    mailbox: Mailbox,
}

impl ZephyrOutside {
    /// The one of this image.
    pub(crate) fn of_program() -> &'static Self {
        &PROGRAM
    }

    /// See [`lf_runtime::platform::Platform::set_correction`].
    pub(crate) fn set_correction(&self, correction: ClockCorrection) {
        critical_section::with(|section| self.correction.borrow(section).set(correction));
    }
}

impl Outside for ZephyrOutside {
    fn physical_time(&self) -> Instant {
        let correction = critical_section::with(|section| self.correction.borrow(section).get());
        correction.physical(clock::now())
    }

    fn wake(&self) {
        wake::wake();
    }

    fn mailbox(&self) -> &Mailbox {
        &self.mailbox
    }
}
