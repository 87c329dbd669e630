// SPDX-License-Identifier: Apache-2.0
//! The pauses of the event loop: how long the kernel waits, and what is too short for it.

use lf_coordination::Deadline;

use crate::kconfig::SYS_CLOCK_TICKS_PER_SEC;
use crate::{clock, raw};

/// Waits until a deadline, by a function that waits for a number of ticks, or without end if that is negative, and
/// returns whether something has ended the wait. The wait is not longer than this many nanoseconds, and than the clock
/// and the watchdog allow.
pub(crate) fn until(deadline: Deadline, longest_ns: i64, wait: &mut dyn FnMut(i64) -> bool) {
    #[cfg(CONFIG_LF_INTERRUPTS)]
    crate::devices::report_lost();
    let remaining_ns = match deadline {
        Deadline::Now => 0,
        Deadline::At(instant) => instant.since(clock::now()).as_nanos().max(0),
        Deadline::Never => i64::MAX,
    };
    // SAFETY: it has no precondition.
    let longest_ns = longest_ns.min(clock::longest_wait_ns()).min(unsafe { raw::lf_watchdog_feed() });
    let wait_ns = remaining_ns.min(longest_ns);
    if wait_ns == i64::MAX {
        wait(-1);
        return;
    }
    let ticks = ticks(wait_ns);
    // Less than a tick is too short for the kernel's timers, so the processor spins.
    if !wait(ticks) && ticks == 0 && wait_ns > 0 {
        busy_wait(wait_ns);
    }
}

/// Returns how many whole ticks of the kernel fit into this many nanoseconds.
///
/// The kernel adds the rest of the current tick, so a wait of that many ends at most one tick too late.
fn ticks(nanoseconds: i64) -> i64 {
    const SECOND: i64 = 1_000_000_000;
    // It fits: Kconfig's type for the symbol is a C int.
    let per_second = i64::try_from(SYS_CLOCK_TICKS_PER_SEC).unwrap_or(i64::MAX);
    let whole = (nanoseconds / SECOND).saturating_mul(per_second);
    whole.saturating_add((nanoseconds % SECOND).saturating_mul(per_second) / SECOND)
}

fn busy_wait(nanoseconds: i64) {
    let microseconds = u32::try_from((nanoseconds + 999) / 1000).unwrap_or(u32::MAX);
    // SAFETY: it has no precondition.
    unsafe { raw::k_busy_wait(microseconds) };
}
