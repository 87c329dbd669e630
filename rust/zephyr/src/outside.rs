// SPDX-License-Identifier: Apache-2.0
//! The state that the threads of a program share with its event loop.

use core::cell::Cell;

use critical_section::Mutex;
use lf_coordination::clock_sync::ClockCorrection;
use lf_model::time::Instant;
use lf_model::{Mailbox, Outside};

use crate::{clock, wake};

static PROGRAM: ZephyrOutside = ZephyrOutside::new();

/// The federation's clock, the wake-up of the event loop and the mailbox of the program.
#[derive(Debug)]
pub(crate) struct ZephyrOutside {
    physical: Mutex<Cell<Physical>>,
    mailbox: Mailbox,
}

/// Physical time, as the program's threads see it.
#[derive(Clone, Copy, Debug)]
struct Physical {
    correction: ClockCorrection,
    /// The latest time that any thread has received. A thread may receive the time between the event loop's reading of
    /// the clock and the change of rate that this led to; no thread receives an earlier time then.
    latest: Instant,
}

impl ZephyrOutside {
    const fn new() -> Self {
        Self {
            physical: Mutex::new(Cell::new(Physical { correction: ClockCorrection::NONE, latest: Instant::NEVER })),
            mailbox: Mailbox::new(),
        }
    }

    /// Returns that of the program of this image.
    pub(crate) fn of_program() -> &'static Self {
        &PROGRAM
    }

    /// See [`lf_runtime::platform::Platform::set_correction`].
    pub(crate) fn set_correction(&self, correction: ClockCorrection) {
        critical_section::with(|section| {
            let physical = self.physical.borrow(section);
            let Physical { correction: before, latest } = physical.get();
            let latest = if before.is_step(&correction) { Instant::NEVER } else { latest };
            physical.set(Physical { correction, latest });
        });
    }
}

impl Outside for ZephyrOutside {
    fn physical_time(&self) -> Instant {
        critical_section::with(|section| {
            let physical = self.physical.borrow(section);
            let Physical { correction, latest } = physical.get();
            let latest = correction.physical(clock::now()).max(latest);
            physical.set(Physical { correction, latest });
            latest
        })
    }

    fn wake(&self) {
        wake::wake();
    }

    fn mailbox(&self) -> &Mailbox {
        &self.mailbox
    }

    #[cfg(feature = "transients")]
    fn federation_id(&self) -> &'static core::ffi::CStr {
        crate::settings::federation_id_text()
    }

    #[cfg(CONFIG_LF_OSCILLOSCOPE)]
    fn starts(&self, start: Instant) {
        let left = start.since(self.physical_time());
        // SAFETY: it has no precondition.
        unsafe { crate::raw::lf_oscilloscope_starts(left.as_nanos()) };
    }
}
