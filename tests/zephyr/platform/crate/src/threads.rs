// SPDX-License-Identifier: Apache-2.0
//! Threads, the wake-up, and the console that they share.

use core::ffi::CStr;
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use lf::kconfig::{LF_LINE_SIZE, LF_USER_THREADS};
use lf::runtime::platform::Platform;
use lf::thread::spawn;
use lf_coordination::Deadline;
use lf_model::ModelError;

use crate::{Outcome, ensure, platform};

const NO_THREAD: &CStr = c"there is no thread";

pub(crate) fn another_thread_ends_a_wait() -> Outcome {
    static BEGAN: AtomicBool = AtomicBool::new(false);
    let mut platform = platform()?;
    // The thread's priority is below this one's, so it runs when this one waits.
    spawn(|| {
        BEGAN.store(true, Ordering::Release);
        lf::wake();
    })
    .map_err(|_| NO_THREAD)?;
    while !BEGAN.load(Ordering::Acquire) {
        platform.wait(Deadline::Never, &mut |_, _| {});
    }
    Ok(())
}

pub(crate) fn a_wake_up_is_not_lost_before_a_wait() -> Outcome {
    let mut platform = platform()?;
    lf::wake();
    lf::wake();
    platform.wait(Deadline::Never, &mut |_, _| {});
    Ok(())
}

pub(crate) fn an_interrupt_ends_a_wait() -> Outcome {
    let mut platform = platform()?;
    FROM_INTERRUPT.store(false, Ordering::Release);
    wake_from_interrupt();
    while !FROM_INTERRUPT.load(Ordering::Acquire) {
        platform.wait(Deadline::Never, &mut |_, _| {});
    }
    Ok(())
}

static FROM_INTERRUPT: AtomicBool = AtomicBool::new(false);

/// Handles the timer's interrupt.
#[unsafe(no_mangle)]
extern "C" fn test_interrupted() {
    FROM_INTERRUPT.store(true, Ordering::Release);
    lf::wake();
}

unsafe extern "C" {
    /// Schedules an interrupt that calls [`test_interrupted`].
    #[link_name = "test_wake_from_interrupt"]
    safe fn wake_from_interrupt();
}

pub(crate) fn threads_are_reused_and_limited() -> Outcome {
    static ENDED: AtomicUsize = AtomicUsize::new(0);
    let mut platform = platform()?;
    for round in 1..=3 {
        for number in 0..LF_USER_THREADS {
            // The captured values have to arrive in the thread.
            let captured = [number; 4];
            let body = move || {
                if captured == [number; 4] {
                    ENDED.fetch_add(1, Ordering::AcqRel);
                }
                lf::wake();
            };
            spawn(body).map_err(|_| NO_THREAD)?;
        }
        ensure!(spawn(|| {}) == Err(ModelError::NoThreadLeft { threads: LF_USER_THREADS }));
        while ENDED.load(Ordering::Acquire) < round * LF_USER_THREADS {
            platform.wait(Deadline::Never, &mut |_, _| {});
        }
        wait_for_a_free_thread(&mut platform);
    }
    Ok(())
}

/// Waits for a free thread: a thread frees its slot only after its body, so the next one may still find it taken.
fn wait_for_a_free_thread(platform: &mut impl Platform) {
    static FREE: AtomicUsize = AtomicUsize::new(0);
    FREE.store(0, Ordering::Release);
    let body = || {
        FREE.fetch_add(1, Ordering::AcqRel);
        lf::wake();
    };
    while FREE.load(Ordering::Acquire) < 1 {
        // The wait is long enough to let other threads run: the platform spins for less than a tick.
        let soon = platform.now() + lf_model::Interval::from_millis(1);
        let _ = spawn(body);
        platform.wait(Deadline::At(soon), &mut |_, _| {});
    }
}

/// Prints a line with characters across every border of its buffer; printing must not panic or lose the end.
pub(crate) fn long_lines_keep_whole_characters() -> Outcome {
    for shift in 0..4 {
        lf::println!("{:shift$}{:→<width$}|", "", "", width = LF_LINE_SIZE);
    }
    Ok(())
}
