// SPDX-License-Identifier: Apache-2.0
//! The watch that posts the events of a device.

use std::fmt;

use lf_model::ScheduleError;
use lf_runtime::{DeviceEvent, report};
use log::Level;

/// The interrupts of a device, until this is dropped.
#[derive(Debug)]
pub struct Watch {
    _ends: Box<dyn WatchGuard>,
}

impl Watch {
    /// Returns a watch that ends its source when it is dropped.
    pub(super) fn until_dropped(ends: impl WatchGuard + 'static) -> Self {
        Self { _ends: Box::new(ends) }
    }
}

/// A value that a reactor can keep, whichever thread runs it.
pub(super) trait WatchGuard: fmt::Debug + Send + Sync {}

impl<T: fmt::Debug + Send + Sync> WatchGuard for T {}

/// Events of a device that had no room in the queue of its action, and that were not logged yet.
#[derive(Debug)]
pub(super) struct Lost {
    device: &'static str,
    events: u32,
}

impl Lost {
    pub(super) fn of(device: &'static str) -> Self {
        Self { device, events: 0 }
    }

    /// Counts an event that was posted, or was not. Earlier losses are logged when there is room again.
    pub(super) fn count(&mut self, posted: Result<(), ScheduleError>) {
        if posted.is_err() {
            self.events += 1;
        } else {
            self.report();
        }
    }

    fn report(&mut self) {
        if let events @ 1.. = std::mem::take(&mut self.events) {
            report(Level::Warn, &DeviceEvent::EventsLost { device: self.device, events });
        }
    }
}

impl Drop for Lost {
    fn drop(&mut self) {
        self.report();
    }
}
