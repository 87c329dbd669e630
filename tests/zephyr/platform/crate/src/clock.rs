// SPDX-License-Identifier: Apache-2.0
//! The clock and waiting for it.

use core::cell::Cell;

use lf::clock::{self, Extension};
use lf::kconfig::SYS_CLOCK_TICKS_PER_SEC;
use lf::runtime::platform::Platform;
use lf_coordination::Deadline;
use lf_model::Interval;

use crate::{Outcome, ensure, platform};

/// Frequencies of real counters: a slow one, native_sim's, ones that do not divide 10⁹, and the largest.
const FREQUENCIES: [u32; 6] = [32_768, 1_000_000, 12_000_000, 996_000_000, 1_000_000_007, u32::MAX];

pub(crate) fn clock_never_runs_backwards() -> Outcome {
    let mut last = clock::now();
    for _ in 0..10_000 {
        let now = clock::now();
        ensure!(now >= last);
        last = now;
    }
    Ok(())
}

/// Compares with the definition in 128 bits, around each power of two and so around the wrap of 32 bits.
pub(crate) fn conversion_is_exact() -> Outcome {
    for frequency in FREQUENCIES {
        for power in 0..64 {
            for offset in [-2, -1, 0, 1, 2] {
                let cycles = (1_u64 << power).wrapping_add_signed(offset);
                let exact = u128::from(cycles) * 1_000_000_000 / u128::from(frequency);
                let expected = i64::try_from(exact).unwrap_or(i64::MAX);
                ensure!(clock::nanoseconds(cycles, frequency) == expected);
            }
        }
    }
    ensure!(clock::nanoseconds(u64::MAX, 1) == i64::MAX);
    Ok(())
}

/// Reads a counter at uneven steps of less than half a turn, through several turns.
pub(crate) fn extension_carries_over_the_wrap() -> Outcome {
    const STEPS: [u64; 10] = [0, 1, 0x7fff_fffe, 1, 1, 0x7fff_fffe, 2, 0x4000_0000, 0x4000_0000, 0x7fff_ffff];
    let extension = Extension::new();
    let mut counter = 0_u64;
    for step in core::iter::repeat_n(STEPS, 8).flatten() {
        counter += step;
        let low = u32::try_from(counter & 0xffff_ffff).unwrap_or(0);
        ensure!(extension.extend(|| low) == counter);
    }
    ensure!(counter > 4 << 32);
    Ok(())
}

/// Another reader sees the next half turn between this reader's two reads; this one must not jump ahead.
pub(crate) fn extension_is_shared_by_readers() -> Outcome {
    let extension = Extension::new();
    let first = Cell::new(true);
    let read = || {
        if first.replace(false) {
            // Interrupted right after reading: the interrupt reads 0x8000_0001.
            let _ = extension.extend(|| 0x8000_0001);
            0x7fff_ffff
        } else {
            0x8000_0002
        }
    };
    ensure!(extension.extend(read) == 0x8000_0002);
    Ok(())
}

pub(crate) fn wait_ends_at_its_time() -> Outcome {
    let mut platform = platform()?;
    for nanoseconds in [-1, 0, 1, 999, 1_000, 50_001, 3_000_000] {
        let until = platform.now() + Interval::from_nanos(nanoseconds);
        // A wait may end early, so the test repeats it as the event loop does; it must end at last.
        while platform.now() < until {
            platform.wait(Deadline::At(until), &mut |_, _| {});
        }
    }
    Ok(())
}

/// Waits until the counter of 32 bits has wrapped, and compares with the kernel's own count of ticks, which comes from
/// the same counter: the time lies within the tick, before and after the wrap.
///
/// Where the board's driver counts in 64 bits there is no wrap to wait for; then the comparison is made once.
pub(crate) fn time_is_exact_over_the_wrap() -> Outcome {
    let mut platform = platform()?;
    let frequency = clock::frequency();
    let cycles_per_tick = u64::from(frequency) / u64::try_from(SYS_CLOCK_TICKS_PER_SEC).unwrap_or(1);
    let ns_per_tick = clock::nanoseconds(cycles_per_tick, frequency);
    // The step is a multiple of no tick, and a little shorter than the event loop's longest wait.
    let step = Interval::from_nanos(clock::nanoseconds(1 << 29, frequency) + 1);
    let steps = if has_counter_of_64_bits() { 1 } else { 10 };
    for _ in 0..steps {
        // A time between two reads of the ticks lies in these ticks.
        let before = uptime_ticks();
        let now = platform.now().as_nanos();
        let after = uptime_ticks();
        ensure!(now >= before * ns_per_tick);
        ensure!(now < (after + 1) * ns_per_tick);
        if steps > 1 {
            let until = platform.now() + step;
            while platform.now() < until {
                platform.wait(Deadline::At(until), &mut |_, _| {});
            }
        }
    }
    let end = platform.now().as_nanos();
    ensure!(steps == 1 || end > clock::nanoseconds(1 << 32, frequency));
    Ok(())
}

unsafe extern "C" {
    /// Returns the kernel's ticks since the boot.
    #[link_name = "test_uptime_ticks"]
    safe fn uptime_ticks() -> i64;

    /// Returns whether the board's driver extends the counter itself.
    #[link_name = "test_has_counter_of_64_bits"]
    safe fn has_counter_of_64_bits() -> bool;
}
