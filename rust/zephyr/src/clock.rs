// SPDX-License-Identifier: Apache-2.0
//! Physical time: Zephyr's cycle counter, extended to 64 bits and converted exactly in integers.

use core::sync::atomic::{AtomicU32, Ordering};

use lf_model::time::Instant;

use crate::raw;

const NANOSECONDS_PER_SECOND: u64 = 1_000_000_000;

/// Returns the time since boot. May be called from any thread; it never runs backwards.
pub fn now() -> Instant {
    Instant::from_nanos(nanoseconds(cycles(), frequency()))
}

/// Returns the nanoseconds of this many cycles of a counter of this frequency, rounded down; `i64::MAX` if more.
///
/// Whole seconds are converted apart from the rest, whose product with 10⁹ fits 64 bits for each frequency of 32 bits.
/// So the result is exact, without floats and without 128-bit division.
pub const fn nanoseconds(cycles: u64, frequency: u32) -> i64 {
    // A counter that does not count would be a division by zero; its time stands still.
    let frequency = if frequency == 0 { u64::MAX } else { frequency as u64 };
    let seconds = cycles / frequency;
    let rest = cycles % frequency * NANOSECONDS_PER_SECOND / frequency;
    match seconds.checked_mul(NANOSECONDS_PER_SECOND) {
        Some(nanoseconds) if nanoseconds <= i64::MAX as u64 - rest => (nanoseconds + rest).cast_signed(),
        _ => i64::MAX,
    }
}

/// Extends a counter of 32 bits to 64 bits.
///
/// It counts the half periods of the counter. The lowest bit of that count distinguishes a reading of the last half
/// period from one of the next; so it must be read at least once per half period, which the event loop does because it
/// never waits longer ([`longest_wait_ns`]).
#[derive(Debug, Default)]
pub struct Extension {
    half_turns: AtomicU32,
}

impl Extension {
    /// Returns an extension before the first reading.
    pub const fn new() -> Self {
        Self { half_turns: AtomicU32::new(0) }
    }

    /// Reads the counter and extends the reading. Several threads may do so at once.
    pub fn extend(&self, read: impl Fn() -> u32) -> u64 {
        loop {
            let half_turns = self.half_turns.load(Ordering::Acquire);
            let low = read();
            // A reading that belongs to an older count than the one that it is compared with would be put into the
            // future.
            if self.half_turns.load(Ordering::Acquire) != half_turns {
                continue;
            }
            let since = low ^ ((half_turns & 1) << 31);
            let extended = (u64::from(half_turns) << 31) + u64::from(since);
            // Half periods are counted in 32 bits, so the extended counter has 63.
            let seen = u32::try_from(extended >> 31).unwrap_or(u32::MAX);
            self.half_turns.fetch_max(seen, Ordering::AcqRel);
            return extended;
        }
    }
}

/// Returns the longest time that the event loop may wait without reading the clock.
pub(crate) fn longest_wait_ns() -> i64 {
    if cfg!(CONFIG_TIMER_HAS_64BIT_CYCLE_COUNTER) { i64::MAX } else { nanoseconds(1 << 30, frequency()) }
}

/// Returns the number of cycles per second.
pub fn frequency() -> u32 {
    // SAFETY: it has no precondition.
    unsafe { raw::lf_cycles_per_second() }
}

#[cfg(CONFIG_TIMER_HAS_64BIT_CYCLE_COUNTER)]
fn cycles() -> u64 {
    // SAFETY: it has no precondition.
    unsafe { raw::k_cycle_get_64() }
}

#[cfg(not(CONFIG_TIMER_HAS_64BIT_CYCLE_COUNTER))]
fn cycles() -> u64 {
    static EXTENSION: Extension = Extension::new();
    // SAFETY: it has no precondition.
    EXTENSION.extend(|| unsafe { raw::k_cycle_get_32() })
}
