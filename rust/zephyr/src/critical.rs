// SPDX-License-Identifier: Apache-2.0
//! Zephyr's interrupt lock as the critical section of the libraries that need one.

use critical_section::{Impl, RawRestoreState};

use crate::raw;

struct InterruptLock;
critical_section::set_impl!(InterruptLock);

// SAFETY: Zephyr's irq_lock() keeps out interrupts and other threads of this processor, and on several processors the
// threads of the others that also take it. It nests, and the key restores the previous state.
unsafe impl Impl for InterruptLock {
    unsafe fn acquire() -> RawRestoreState {
        // SAFETY: it has no precondition.
        unsafe { raw::lf_interrupts_lock() }
    }

    unsafe fn release(state: RawRestoreState) {
        // SAFETY: the caller promises that this is the state of the last `acquire`.
        unsafe { raw::lf_interrupts_unlock(state) };
    }
}
