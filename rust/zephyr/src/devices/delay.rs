// SPDX-License-Identifier: Apache-2.0
//! Waits within a reaction, for driver crates.

use lf_devices::embedded_hal::delay::DelayNs;

use crate::raw;

/// The time from which on the kernel's timers are exact enough.
const SLEEP_US: u32 = 1000;

/// Waits, as driver crates require: `embedded_hal::delay::DelayNs`.
///
/// The event loop waits meanwhile, too, so that all reactions are late by it. Use an action to schedule something for
/// later.
#[derive(Clone, Copy, Debug, Default)]
pub struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        self.delay_us(ns.div_ceil(1000));
    }

    fn delay_us(&mut self, us: u32) {
        // SAFETY: neither has a precondition, because reactions run on a thread.
        unsafe {
            if us < SLEEP_US {
                raw::k_busy_wait(us);
            } else {
                // It returns the rest when another thread ends the sleep, which none does.
                raw::k_usleep(i32::try_from(us).unwrap_or(i32::MAX));
            }
        }
    }
}
