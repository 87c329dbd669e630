// SPDX-License-Identifier: Apache-2.0
//! The keys of participants. Secret ones are erased when they are dropped, compared in constant time, and never
//! displayed.

use core::fmt;

use subtle::ConstantTimeEq;
use x25519_dalek::{X25519_BASEPOINT_BYTES, x25519};
use zeroize::{Zeroize, ZeroizeOnDrop};

/// The length of every key, in bytes.
pub const KEY_BYTES: usize = 32;

/// The secret half of a participant's identity, for X25519: any 32 random bytes.
#[derive(Clone, Zeroize, ZeroizeOnDrop)]
pub struct StaticSecret([u8; KEY_BYTES]);

impl StaticSecret {
    /// Returns the secret of these bytes, which have to be random.
    pub const fn new(bytes: [u8; KEY_BYTES]) -> Self {
        Self(bytes)
    }

    /// Returns the bytes, to store them.
    pub const fn bytes(&self) -> &[u8; KEY_BYTES] {
        &self.0
    }

    /// Computes the public half.
    pub fn public(&self) -> PublicKey {
        PublicKey(x25519(self.0, X25519_BASEPOINT_BYTES))
    }

    /// Returns what this and the secret of a public key have in common, or `None` if the public key is one of the few
    /// that make it the same for every secret.
    pub(crate) fn shared_with(&self, public: &PublicKey) -> Option<[u8; KEY_BYTES]> {
        let shared = x25519(self.0, public.0);
        let is_zero: bool = shared.ct_eq(&[0; KEY_BYTES]).into();
        (!is_zero).then_some(shared)
    }
}

impl ConstantTimeEq for StaticSecret {
    fn ct_eq(&self, other: &Self) -> subtle::Choice {
        self.0.ct_eq(&other.0)
    }
}

impl PartialEq for StaticSecret {
    fn eq(&self, other: &Self) -> bool {
        self.ct_eq(other).into()
    }
}

impl Eq for StaticSecret {}

impl fmt::Debug for StaticSecret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("StaticSecret")
    }
}

/// The public half of a participant's identity, which everybody may know. It is displayed as 64 hexadecimal digits.
#[repr(transparent)]
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PublicKey([u8; KEY_BYTES]);

impl PublicKey {
    /// Returns the key of these bytes.
    pub const fn new(bytes: [u8; KEY_BYTES]) -> Self {
        Self(bytes)
    }

    /// Returns the bytes.
    pub const fn bytes(&self) -> &[u8; KEY_BYTES] {
        &self.0
    }
}

impl fmt::Display for PublicKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for PublicKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PublicKey({self})")
    }
}

/// The secret that all participants of a federation share: 32 random bytes. Who does not have it gets no answer.
#[derive(Clone, Zeroize, ZeroizeOnDrop)]
pub struct FederationSecret([u8; KEY_BYTES]);

impl FederationSecret {
    /// Returns the secret of these bytes, which have to be random.
    pub const fn new(bytes: [u8; KEY_BYTES]) -> Self {
        Self(bytes)
    }

    /// Returns the bytes, to store them.
    pub const fn bytes(&self) -> &[u8; KEY_BYTES] {
        &self.0
    }
}

impl PartialEq for FederationSecret {
    fn eq(&self, other: &Self) -> bool {
        self.0.ct_eq(&other.0).into()
    }
}

impl Eq for FederationSecret {}

impl fmt::Debug for FederationSecret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("FederationSecret")
    }
}
