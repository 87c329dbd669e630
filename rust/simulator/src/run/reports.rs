// SPDX-License-Identifier: Apache-2.0
//! The reports of late messages in the event loops' logs.

use std::cell::Cell;
use std::sync::Once;

use log::{Level, LevelFilter, Log, Metadata, Record};

/// The number of reported late messages.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(crate) struct Reports {
    /// At any level.
    pub(crate) all: u64,
    /// As warnings.
    pub(crate) warnings: u64,
}

thread_local! {
    static REPORTS: Cell<Reports> = const { Cell::new(Reports { all: 0, warnings: 0 }) };
}

struct Listener;

impl Log for Listener {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target().starts_with("lf_runtime::")
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) && record.args().to_string().starts_with("late message ") {
            let before = REPORTS.get();
            let warnings = before.warnings + u64::from(record.level() == Level::Warn);
            REPORTS.set(Reports { all: before.all + 1, warnings });
        }
    }

    fn flush(&self) {}
}

/// Installs the logger.
pub(super) fn listen() {
    static LISTENING: Once = Once::new();
    LISTENING.call_once(|| {
        // If another logger is installed already, this one hears nothing, and the check reports that.
        if log::set_logger(&Listener).is_ok() {
            log::set_max_level(LevelFilter::Debug);
        }
    });
}

/// Returns the reports in this thread since the last call.
pub(super) fn take() -> Reports {
    REPORTS.take()
}
