// SPDX-License-Identifier: Apache-2.0
//! The connection of the `log` crate with Zephyr's log.

use lf_embedded::Text;
use log::{Level, LevelFilter, Log, Metadata, Record};

use crate::kconfig::{LF_LINE_SIZE, LF_LOG_LEVEL};
use crate::raw;

struct Logger;

static LOGGER: Logger = Logger;

/// Makes Zephyr's log that of the `log` crate; does nothing the second time.
pub(crate) fn install(level: LevelFilter) {
    if log::set_logger(&LOGGER).is_ok() {
        log::set_max_level(level.min(most_detailed()));
    }
}

/// Returns the level of `CONFIG_LF_LOG_LEVEL`. Zephyr has no level for traces; they go with its debug messages.
fn most_detailed() -> LevelFilter {
    match LF_LOG_LEVEL {
        0 => LevelFilter::Off,
        1 => LevelFilter::Error,
        2 => LevelFilter::Warn,
        3 => LevelFilter::Info,
        _ => LevelFilter::Trace,
    }
}

impl Log for Logger {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() <= most_detailed()
    }

    fn log(&self, record: &Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let level = match record.level() {
            Level::Error => raw::LOG_LEVEL_ERR,
            Level::Warn => raw::LOG_LEVEL_WRN,
            Level::Info => raw::LOG_LEVEL_INF,
            Level::Debug | Level::Trace => raw::LOG_LEVEL_DBG,
        };
        let mut text = Text::<LF_LINE_SIZE>::new();
        // A line is short. Messages for users explain themselves; those for debugging also have their module.
        if record.level() >= Level::Debug {
            text.append(format_args!("{}: ", record.target()));
        }
        text.append(*record.args());
        // SAFETY: the text is terminated and lives until the call returns; Zephyr's log copies it.
        unsafe { raw::lf_log(level, text.terminated().as_ptr()) };
    }

    fn flush(&self) {}
}
