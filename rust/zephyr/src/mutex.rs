// SPDX-License-Identifier: Apache-2.0
//! A guard of a Zephyr mutex that C defines statically.

use core::ptr::NonNull;

use crate::raw;

/// Holds a mutex until it goes out of scope.
#[derive(Debug)]
pub(crate) struct ConsoleGuard(NonNull<raw::k_mutex>);

impl ConsoleGuard {
    /// Waits for the console. Returns `None` in an interrupt, which cannot wait.
    pub(crate) fn lock() -> Option<Self> {
        let mutex = NonNull::new(&raw mut raw::lf_console_lock)?;
        // SAFETY: the mutex is static and initialised by K_MUTEX_DEFINE; it is not locked from an interrupt, which is
        // the only precondition of k_mutex_lock. With K_FOREVER it returns with the mutex held.
        unsafe {
            if raw::k_is_in_isr() || raw::k_mutex_lock(mutex.as_ptr(), raw::k_timeout_t { ticks: !0 }) != 0 {
                return None;
            }
        }
        Some(Self(mutex))
    }
}

impl Drop for ConsoleGuard {
    fn drop(&mut self) {
        // SAFETY: this thread has locked the mutex when it made the value, and no other thread can own the value: a
        // pointer is not Send.
        unsafe { raw::k_mutex_unlock(self.0.as_ptr()) };
    }
}
