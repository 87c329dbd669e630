// SPDX-License-Identifier: Apache-2.0
//! A key with a counter: Noise's cipher state.

use chacha20poly1305::aead::inout::InOutBuf;
use chacha20poly1305::{AeadInOut, ChaCha20Poly1305, KeyInit};
use zeroize::{Zeroize, ZeroizeOnDrop};

use crate::keys::KEY_BYTES;

/// The length of what makes a change of a ciphertext evident.
pub(crate) const TAG_BYTES: usize = 16;
/// The nonce that is reserved for [`Cipher::rekey`].
const NONCE_OF_REKEY: u64 = u64::MAX;

/// The message was not encrypted with this key and this number, or was changed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Forged;

/// A key with a counter of messages, which is their nonce.
#[derive(Clone, Zeroize, ZeroizeOnDrop)]
pub(crate) struct Cipher {
    key: [u8; KEY_BYTES],
    count: u64,
}

impl Cipher {
    pub(crate) fn new(key: [u8; KEY_BYTES]) -> Self {
        Self { key, count: 0 }
    }

    /// Returns the number of messages so far.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    /// Encrypts the next message in place.
    pub(crate) fn encrypt(&mut self, associated: &[u8], bytes: &mut [u8]) -> [u8; TAG_BYTES] {
        let tag = encrypt(&self.key, self.count, associated, bytes);
        // At a million messages in a second the counter lasts for half a million years.
        self.count = self.count.saturating_add(1);
        tag
    }

    /// Decrypts the next message in place. The bytes are unchanged if it is not authentic, and so is the counter.
    pub(crate) fn decrypt(&mut self, associated: &[u8], bytes: &mut [u8], tag: &[u8; TAG_BYTES]) -> Result<(), Forged> {
        decrypt(&self.key, self.count, associated, bytes, tag)?;
        self.count = self.count.saturating_add(1);
        Ok(())
    }

    /// Replaces the key by one from which it cannot be computed.
    pub(crate) fn rekey(&mut self) {
        let mut next = [0; KEY_BYTES];
        encrypt(&self.key, NONCE_OF_REKEY, &[], &mut next);
        self.key.zeroize();
        self.key = next;
    }
}

/// Encrypts a message with any number in place.
pub(crate) fn encrypt(key: &[u8; KEY_BYTES], number: u64, associated: &[u8], bytes: &mut [u8]) -> [u8; TAG_BYTES] {
    let cipher = ChaCha20Poly1305::new(key.into());
    let tag = cipher.encrypt_inout_detached(&nonce(number).into(), associated, InOutBuf::from(bytes));
    tag.expect("a message of this crate is far shorter than 256 GiB").into()
}

/// Decrypts a message with any number in place.
pub(crate) fn decrypt(
    key: &[u8; KEY_BYTES],
    number: u64,
    associated: &[u8],
    bytes: &mut [u8],
    tag: &[u8; TAG_BYTES],
) -> Result<(), Forged> {
    let cipher = ChaCha20Poly1305::new(key.into());
    let opened = cipher.decrypt_inout_detached(&nonce(number).into(), associated, InOutBuf::from(bytes), tag.into());
    opened.map_err(|_| Forged)
}

/// Returns the nonce of Noise for ChaCha20-Poly1305.
fn nonce(number: u64) -> [u8; 12] {
    let mut nonce = [0; 12];
    nonce[4..].copy_from_slice(&number.to_le_bytes());
    nonce
}
