// SPDX-License-Identifier: Apache-2.0
//! Noise's symmetric state: the keys that a handshake has agreed upon so far.

use hmac::{Hmac, KeyInit, Mac};
use sha2::{Digest, Sha256};
use zeroize::{Zeroize, ZeroizeOnDrop};

use crate::cipher::{Cipher, Forged, TAG_BYTES};
use crate::keys::KEY_BYTES;

/// The length of a hash.
pub(crate) const HASH_BYTES: usize = 32;

/// The chaining key, the hash of all that was sent, and the key of what is sent next.
#[derive(Zeroize, ZeroizeOnDrop)]
pub(crate) struct Symmetric {
    chaining_key: [u8; HASH_BYTES],
    hash: [u8; HASH_BYTES],
    cipher: Cipher,
    has_key: bool,
}

impl Symmetric {
    pub(crate) fn new(protocol: &str) -> Self {
        let name = protocol.as_bytes();
        let mut hash = [0; HASH_BYTES];
        match hash.get_mut(..name.len()) {
            Some(front) => front.copy_from_slice(name),
            None => hash = Sha256::digest(name).into(),
        }
        Self { chaining_key: hash, hash, cipher: Cipher::new([0; KEY_BYTES]), has_key: false }
    }

    /// Returns the hash of all that was sent, which both ends have.
    pub(crate) fn hash(&self) -> &[u8; HASH_BYTES] {
        &self.hash
    }

    pub(crate) fn has_key(&self) -> bool {
        self.has_key
    }

    pub(crate) fn mix_hash(&mut self, bytes: &[u8]) {
        self.hash = Sha256::new().chain_update(self.hash).chain_update(bytes).finalize().into();
    }

    pub(crate) fn mix_key(&mut self, material: &[u8]) {
        let [chaining_key, key] = expand(&self.chaining_key, material);
        self.chaining_key = chaining_key;
        self.set_key(key);
    }

    pub(crate) fn mix_key_and_hash(&mut self, material: &[u8]) {
        let [chaining_key, hash, key] = expand(&self.chaining_key, material);
        self.chaining_key = chaining_key;
        self.mix_hash(&hash);
        self.set_key(key);
    }

    /// Encrypts in place, if there is a key, and returns the tag.
    pub(crate) fn encrypt_and_hash(&mut self, bytes: &mut [u8]) -> Option<[u8; TAG_BYTES]> {
        let hash = self.hash;
        let tag = self.has_key.then(|| self.cipher.encrypt(&hash, bytes));
        let tagged = Sha256::new().chain_update(hash).chain_update(bytes);
        self.hash = tagged.chain_update(tag.as_ref().map_or(&[][..], |tag| tag)).finalize().into();
        tag
    }

    /// Decrypts in place, if there is a key; then `bytes` end with the tag. Returns the length of the plaintext.
    pub(crate) fn decrypt_and_hash(&mut self, bytes: &mut [u8]) -> Result<usize, Forged> {
        let hash: [u8; HASH_BYTES] = Sha256::new().chain_update(self.hash).chain_update(&*bytes).finalize().into();
        let mut count = bytes.len();
        if self.has_key {
            let (text, tag) = bytes.split_last_chunk_mut().ok_or(Forged)?;
            self.cipher.decrypt(&self.hash, text, tag)?;
            count = text.len();
        }
        self.hash = hash;
        Ok(count)
    }

    /// Returns two keys that nothing else shows, for this purpose.
    pub(crate) fn split(&self, purpose: &[u8]) -> [[u8; KEY_BYTES]; 2] {
        expand(&self.chaining_key, purpose)
    }

    fn set_key(&mut self, key: [u8; KEY_BYTES]) {
        self.cipher = Cipher::new(key);
        self.has_key = true;
    }
}

/// Makes some keys of one and of further material: Noise's HKDF.
fn expand<const N: usize>(chaining_key: &[u8; HASH_BYTES], material: &[u8]) -> [[u8; HASH_BYTES]; N] {
    let mut secret = hmac(chaining_key, &[material]);
    let mut keys = [[0; HASH_BYTES]; N];
    let mut before: &[u8] = &[];
    for (number, key) in (1_u8..).zip(&mut keys) {
        *key = hmac(&secret, &[before, &[number]]);
        before = key;
    }
    secret.zeroize();
    keys
}

fn hmac(key: &[u8; HASH_BYTES], parts: &[&[u8]]) -> [u8; HASH_BYTES] {
    let mut hmac = Hmac::<Sha256>::new_from_slice(key).expect("an HMAC takes a key of any length");
    for part in parts {
        hmac.update(part);
    }
    hmac.finalize().into_bytes().into()
}
