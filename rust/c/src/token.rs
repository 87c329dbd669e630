// SPDX-License-Identifier: Apache-2.0
//! Tokens, as the model's queues hold them.
use core::fmt;
use core::ptr::{self, NonNull};

#[cfg(feature = "traces")]
use lf_model::PayloadError;

#[cfg(feature = "traces")]
use crate::ffi::lf_c_token_encode;
use crate::ffi::{RawToken, lf_c_token_release, lf_c_token_retain};

/// A share of a value in C, which is freed with its last share.
pub struct Token(NonNull<RawToken>);

// SAFETY: the shares are counted atomically, or without interrupts, and a shared value is not written: a body that
// wants to write gets a copy, or the only share.
unsafe impl Send for Token {}

impl Token {
    /// Returns the share that C passes on, or none.
    ///
    /// # Safety
    /// The pointer is null, or a token one share of which is the caller's; from now on it belongs to the result.
    pub(crate) unsafe fn from_raw(token: *mut RawToken) -> Option<Self> {
        NonNull::new(token).map(Self)
    }

    /// Passes the share to C.
    pub(crate) fn into_raw(self) -> *mut RawToken {
        let token = self.0.as_ptr();
        core::mem::forget(self);
        token
    }

    /// Writes the value to the beginning of `bytes` as it lies in memory, and returns the number of its bytes.
    ///
    /// # Errors
    /// When they do not fit.
    #[cfg(feature = "traces")]
    pub(crate) fn encode(&self, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        let available = bytes.len();
        // SAFETY: the token lives as long as `self` has a share of it, and so much room is behind the pointer.
        let needed = unsafe { lf_c_token_encode(self.0.as_ptr(), bytes.as_mut_ptr(), available) };
        if needed > available { Err(PayloadError::NoRoom { needed, available }) } else { Ok(needed) }
    }

    /// Lends the value to C; null for none.
    pub(crate) fn raw(token: Option<&Self>) -> *mut RawToken {
        token.map_or(ptr::null_mut(), |token| token.0.as_ptr())
    }
}

impl Clone for Token {
    fn clone(&self) -> Self {
        // SAFETY: the token lives as long as `self` has a share of it.
        unsafe { lf_c_token_retain(self.0.as_ptr()) };
        Self(self.0)
    }
}

impl Drop for Token {
    fn drop(&mut self) {
        // SAFETY: the share was `self`'s, which is not used any more.
        unsafe { lf_c_token_release(self.0.as_ptr()) };
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token")
    }
}
