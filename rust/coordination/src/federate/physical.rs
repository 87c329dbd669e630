// SPDX-License-Identifier: Apache-2.0
//! The bound that physical time sets on the next event of a federate whose physical actions can cause outputs.

use lf_model::time::{Instant, Interval};

use crate::clock_sync::ClockCorrection;

/// The physical actions of a federate.
#[derive(Clone, Debug)]
pub(super) struct PhysicalActions {
    /// The minimum delay from one to an output that others wait for, if there is such a path.
    delay: Option<Interval>,
    /// The time for which an announced bound is valid.
    interval: Interval,
    /// Whether something outside of the program can cause them.
    any_sources: bool,
}

impl PhysicalActions {
    pub(super) const fn new(delay: Option<Interval>, interval: Interval) -> Self {
        Self { delay, interval, any_sources: true }
    }

    pub(super) fn set_sources(&mut self, any: bool) {
        self.any_sources = any;
    }

    /// Returns the earliest physical time of an output that a physical action can cause from now on: now plus the
    /// delay.
    pub(super) fn earliest_output(&self, clock: &ClockCorrection, now: Instant) -> Option<Instant> {
        let delay = self.delay.filter(|_| self.any_sources)?;
        Some(clock.physical(now) + delay)
    }

    /// Returns when to renew the bound, by the own clock: after the interval, or when physical time no longer bounds a
    /// next event at `time`.
    pub(super) fn renewal(&self, clock: &ClockCorrection, now: Instant, time: Instant) -> Instant {
        let renewal = now + self.interval;
        match self.delay {
            Some(delay) => renewal.min(
                clock
                    .local(time + Interval::from_nanos(delay.as_nanos().saturating_neg()))
                    .max(now + Interval::from_nanos(1)),
            ),
            None => renewal,
        }
    }
}
