// SPDX-License-Identifier: Apache-2.0
//! The target of the `log` macros on a computer: standard error.

use std::io::Write as _;

use log::LevelFilter;

/// The environment variable that overrides the program's own level, in `env_logger`'s syntax.
const VARIABLE: &str = "LF_LOG";

/// Sends log records to standard error. Does nothing when a logger has been installed before.
pub fn install(level: LevelFilter) {
    let mut builder = env_logger::Builder::new();
    builder.filter_level(level).parse_env(VARIABLE);
    builder.format(|line, record| {
        let level = record.level().as_str().to_lowercase();
        writeln!(line, "{level}: {}", record.args())
    });
    // A test may have installed one; the first is as good.
    let _ = builder.try_init();
}
