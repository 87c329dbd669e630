// SPDX-License-Identifier: Apache-2.0
//! The log lines of participants: each runs on a thread of its own, so each thread keeps its lines.

use std::cell::RefCell;
use std::sync::Once;

use log::{LevelFilter, Log, Metadata, Record};

thread_local! {
    static LINES: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

struct Lines;

impl Log for Lines {
    fn enabled(&self, _: &Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &Record<'_>) {
        LINES.with_borrow_mut(|lines| lines.push(record.args().to_string()));
    }

    fn flush(&self) {}
}

/// Begins to keep lines.
pub(crate) fn keep() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Another logger would only show more.
        let _ = log::set_logger(&Lines);
        log::set_max_level(LevelFilter::Info);
    });
}

/// Takes the lines of this thread.
pub(crate) fn take() -> Vec<String> {
    LINES.take()
}
