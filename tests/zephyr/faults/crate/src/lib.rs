// SPDX-License-Identifier: Apache-2.0
//! An event loop that waits for a time without events, and then fails. `src/main.c` decides how it ends.
#![no_std]

use lf::ZephyrPlatform;
use lf::runtime::platform::Platform;
use lf_coordination::Deadline;

/// The duration of the wait in nanoseconds; longer than the watchdog's period.
const WAIT_NS: i64 = 1_000_000_000;

unsafe extern "C" {
    /// Returns whether the program is to panic instead of ending with an error.
    safe fn test_panics() -> bool;
}

fn run(platform: &mut ZephyrPlatform) -> Result<(), &'static str> {
    if test_panics() {
        panic!("the program panics");
    }
    let end = platform.now().saturating_add(lf::model::Interval::from_nanos(WAIT_NS));
    while platform.now() < end {
        platform.wait(Deadline::At(end), &mut |_, _| {});
    }
    // The event loop has waited for longer than the watchdog's period, and no watchdog expired.
    Err("the RTI has closed the connection")
}

lf::main!(run, lf::log::LevelFilter::Info);
