// SPDX-License-Identifier: Apache-2.0
//! The static memory of encrypted connections.

use lf_runtime::SecureSlot;

use crate::cell::{Once, StaticSlot};

/// The memory of this number of encrypted connections with buffers of this size, two for each. It is all zero at first,
/// so it takes no flash.
pub struct SecureMemory<const CONNECTIONS: usize, const BYTES: usize>(
    Once<[StaticSlot<SecureSlot<[u8; BYTES]>>; CONNECTIONS]>,
);

impl<const CONNECTIONS: usize, const BYTES: usize> SecureMemory<CONNECTIONS, BYTES> {
    /// Returns memory before its first use.
    #[expect(clippy::new_without_default, reason = "it is for statics, which cannot use Default")]
    pub const fn new() -> Self {
        Self(Once::new([const { StaticSlot::EMPTY }; CONNECTIONS]))
    }

    /// Returns the connections, all of them vacant, to the first caller, and none to all others.
    pub fn take(&'static self) -> &'static mut [SecureSlot<[u8; BYTES]>] {
        let slots: &mut [_] = self.0.take().map_or(&mut [], |slots| slots);
        StaticSlot::fill_all(slots, core::iter::repeat_with(|| SecureSlot::new([0; BYTES], [0; BYTES])))
    }
}
