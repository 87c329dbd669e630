// SPDX-License-Identifier: Apache-2.0
//! The keys of an image, and its platforms with encrypted connections. With `CONFIG_LF_SECURITY`.

use core::slice;

use lf_embedded::SecureMemory;
use lf_runtime::SecurePlatform;
use lf_secure::{
    FederationSecret, HANDSHAKE_BYTES, KEY_BYTES, Keyring, Member, PublicKey, RECORD_OVERHEAD, StaticSecret,
};

use crate::kconfig::{LF_SECURITY_RECORD_SIZE, LF_SOCKETS};
use crate::platform::ZephyrPlatform;
use crate::raw;

/// The length of a buffer: that of the longest record.
const BYTES: usize = LF_SECURITY_RECORD_SIZE + RECORD_OVERHEAD;
const _: () = assert!(BYTES >= HANDSHAKE_BYTES, "CONFIG_LF_SECURITY_RECORD_SIZE is too small for a handshake");

/// A platform with encrypted connections.
pub type EncryptedPlatform<const SOCKETS: usize = LF_SOCKETS> =
    SecurePlatform<'static, ZephyrPlatform<SOCKETS>, [u8; BYTES]>;

/// Returns the federate's platform with encrypted connections, to the first caller.
pub(crate) fn of_federate(platform: ZephyrPlatform) -> EncryptedPlatform {
    static MEMORY: SecureMemory<LF_SOCKETS, BYTES> = SecureMemory::new();
    SecurePlatform::new(platform, Some(keyring(false)), MEMORY.take())
}

/// Returns the RTI's platform with encrypted connections, to the first caller.
#[cfg(CONFIG_LF_RTI)]
pub(crate) fn of_rti<const SOCKETS: usize>(platform: ZephyrPlatform<SOCKETS>) -> EncryptedPlatform<SOCKETS> {
    use crate::kconfig::LF_RTI_CONNECTIONS;
    static MEMORY: SecureMemory<LF_RTI_CONNECTIONS, BYTES> = SecureMemory::new();
    SecurePlatform::new(platform, Some(keyring(true)), MEMORY.take())
}

/// Returns the keys of the RTI or of the federate.
fn keyring(is_rti: bool) -> Keyring<'static> {
    // SAFETY: zephyr/src/keys.c returns a structure that never changes and lives forever.
    let keys = unsafe { &*raw::lf_keys() };
    let own = if is_rti { keys.rti_own } else { keys.own };
    // A `Member` has the layout of C, of a number and the bytes of a key.
    const { assert!(size_of::<Member>() == size_of::<raw::lf_member>() && KEY_BYTES == 32) };
    // SAFETY: they are constants beside that structure, as many as it says; a `Member` has their layout, and any bytes
    // are one.
    let federates = unsafe { slice::from_raw_parts(keys.federates.cast::<Member>(), keys.federates_count) };
    let federation = FederationSecret::new(keys.federation);
    Keyring::new(StaticSecret::new(own), federation, PublicKey::new(keys.rti), federates)
}
