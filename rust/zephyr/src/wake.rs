// SPDX-License-Identifier: Apache-2.0
//! The wake-up of the program's event loop. With sockets it is an event descriptor, which is polled together with them;
//! without a network a semaphore. An RTI has none, because it receives everything over its sockets.

#[cfg(not(CONFIG_LF_NETWORK))]
use crate::raw;

#[cfg(CONFIG_LF_NETWORK)]
pub use descriptor::wake;
#[cfg(CONFIG_LF_NETWORK)]
pub(crate) use descriptor::{clear, descriptor};

/// Ends the event loop's wait, now or at its next start. May be called from any thread and from interrupts.
#[cfg(not(CONFIG_LF_NETWORK))]
pub fn wake() {
    // SAFETY: it has no precondition.
    unsafe { raw::lf_wake() };
}

#[cfg(CONFIG_LF_NETWORK)]
mod descriptor {
    use core::ffi::c_int;
    use core::sync::atomic::{AtomicI32, Ordering};

    use lf_runtime::platform::NetError;

    use crate::address::integer;
    use crate::{net, raw};

    /// The descriptor, negative before there is one. It is never closed, so that any thread can use it at any time.
    static DESCRIPTOR: AtomicI32 = AtomicI32::new(-1);

    /// Ends the event loop's wait, now or at its next start. May be called from any thread and from interrupts; does
    /// nothing before there is an event loop.
    pub fn wake() {
        let descriptor = DESCRIPTOR.load(Ordering::Acquire);
        if descriptor >= 0 {
            // SAFETY: it takes any descriptor, and holds only a spin lock, because the descriptor does not block.
            // It fails only when the counter is full: then the loop is being woken anyway.
            let _ = unsafe { raw::zvfs_eventfd_write(descriptor, 1) };
        }
    }

    /// Returns the descriptor to poll; the first call makes it.
    pub(crate) fn descriptor() -> Result<c_int, NetError> {
        let descriptor = DESCRIPTOR.load(Ordering::Acquire);
        if descriptor >= 0 {
            return Ok(descriptor);
        }
        // SAFETY: it has no precondition.
        let descriptor = unsafe { raw::zvfs_eventfd(0, integer(raw::ZVFS_EFD_NONBLOCK)) };
        if descriptor < 0 {
            return Err(net::last_error());
        }
        DESCRIPTOR.store(descriptor, Ordering::Release);
        Ok(descriptor)
    }

    /// Clears the wake-ups, so that the next wait waits.
    pub(crate) fn clear(descriptor: c_int) {
        let mut count = 0;
        // SAFETY: it takes any descriptor, and the pointer is that of a local. It fails only when there is no wake-up.
        let _ = unsafe { raw::zvfs_eventfd_read(descriptor, &raw mut count) };
    }
}
