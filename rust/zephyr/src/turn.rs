// SPDX-License-Identifier: Apache-2.0
//! Taking turns: a mutex of Zephyr that C defines statically, held for a scope.

use core::ptr::NonNull;

use crate::raw;

/// Holds a mutex until it goes out of scope.
#[derive(Debug)]
pub(crate) struct Turn(NonNull<raw::k_mutex>);

impl Turn {
    /// Waits for the console. `None` in an interrupt, which cannot wait.
    pub(crate) fn at_console() -> Option<Self> {
        let mutex = NonNull::new(&raw mut raw::lf_console_lock)?;
        // SAFETY: the mutex is static and initialised by K_MUTEX_DEFINE; it is not locked from an interrupt, which is
        // the only precondition of k_mutex_lock. Waiting for ever, it returns with the mutex held.
        unsafe {
            if raw::k_is_in_isr() || raw::k_mutex_lock(mutex.as_ptr(), raw::k_timeout_t { ticks: !0 }) != 0 {
                return None;
            }
        }
        Some(Self(mutex))
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        // SAFETY: this thread has locked the mutex when it made the value, which no other thread can have got since:
        // a pointer is not Send.
        unsafe { raw::k_mutex_unlock(self.0.as_ptr()) };
    }
}
