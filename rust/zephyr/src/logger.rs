// SPDX-License-Identifier: Apache-2.0
//! The `log` crate's messages to Zephyr's log.

use core::ffi::CStr;
use core::fmt::{self, Write};

use log::{Level, LevelFilter, Log, Metadata, Record};

use crate::console::whole_characters;
use crate::kconfig::{LF_LINE_SIZE, LF_LOG_LEVEL};
use crate::raw;

struct Logger;

static LOGGER: Logger = Logger;

/// Makes Zephyr's log that of the `log` crate; a second time is a no-op.
pub(crate) fn install(level: LevelFilter) {
    if log::set_logger(&LOGGER).is_ok() {
        log::set_max_level(level.min(most_detailed()));
    }
}

/// What `CONFIG_LF_LOG_LEVEL` lets through. Zephyr has no level for traces; they go with its debug messages.
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
        let mut text = Text::new();
        // A line is short, and what is for users speaks for itself; what is for debugging also says where it is from.
        if record.level() >= Level::Debug {
            text.append(format_args!("{}: ", record.target()));
        }
        text.append(*record.args());
        // SAFETY: the text is terminated and lives until the call returns; Zephyr's log copies it.
        unsafe { raw::lf_log(level, text.terminated().as_ptr()) };
    }

    fn flush(&self) {}
}

/// Text for C: cut when it is too long, which three dots at its end then show.
pub(crate) struct Text {
    bytes: [u8; LF_LINE_SIZE],
    length: usize,
    cut: bool,
}

impl Text {
    const DOTS: &'static [u8; 3] = b"...";
    /// How many bytes there are for text, beside the dots and the terminating zero.
    const ROOM: usize = LF_LINE_SIZE - Self::DOTS.len() - 1;

    pub(crate) const fn new() -> Self {
        Self { bytes: [0; LF_LINE_SIZE], length: 0, cut: false }
    }

    pub(crate) fn append(&mut self, text: fmt::Arguments<'_>) {
        // It fails only when the text is cut, which the dots say.
        let _ = self.write_fmt(text);
    }

    pub(crate) fn terminated(&mut self) -> &CStr {
        if self.cut {
            self.bytes[self.length..][..Self::DOTS.len()].copy_from_slice(Self::DOTS);
        }
        CStr::from_bytes_until_nul(&self.bytes).unwrap_or_default()
    }
}

impl Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        if self.cut {
            return Err(fmt::Error);
        }
        let count = whole_characters(text.as_bytes(), Self::ROOM - self.length);
        self.bytes[self.length..][..count].copy_from_slice(&text.as_bytes()[..count]);
        self.length += count;
        self.cut = count < text.len();
        if self.cut { Err(fmt::Error) } else { Ok(()) }
    }
}
