// SPDX-License-Identifier: Apache-2.0
//! Authentication: a federate and the RTI prove to each other that they know the key, without sending it.
//!
//! Each side sends a nonce, and the other one answers with the HMAC-SHA256 of that nonce; the key is the federation id.
//! The first authenticated byte is the type of the message that carries the proof, so a proof of one side cannot be
//! sent back as the other's. Nonces have to be unpredictable and new for each connection: that alone makes a recorded
//! proof worthless. The owner supplies them, because state machines draw no random numbers.
//!
//! Authentication protects the handshake only. What follows is neither encrypted nor authenticated.

use hmac::{Hmac, KeyInit, Mac};
use lf_wire::{HMAC_BYTES, MessageType, NONCE_BYTES};
use sha2::Sha256;

/// A random number that is used for one connection only.
pub type Nonce = [u8; NONCE_BYTES];
/// An HMAC-SHA256 that shows knowledge of the key.
pub type Proof = [u8; HMAC_BYTES];

/// A function that checks the RTI's proof and makes the federate's own. It takes the key, the federate's id, its nonce,
/// the RTI's proof and the RTI's nonce, and returns `None` if the RTI's proof is wrong.
///
/// A federate receives it as a pointer, so that one without authentication does not carry the algorithm.
pub type Answer = fn(key: &[u8], federate: u16, own: Nonce, proof: &Proof, rti: Nonce) -> Option<Proof>;

/// The functions by which an RTI authenticates itself and federates. They are pointers for the same reason.
#[derive(Clone, Copy, Debug)]
pub struct Authenticator {
    /// Returns the RTI's proof for the key, the id that a federate claims, and its nonce.
    pub rti_proof: fn(key: &[u8], federate: u16, nonce: Nonce) -> Proof,
    /// Returns whether a federate's proof is right for the key and the RTI's nonce.
    pub is_federate_proof: fn(key: &[u8], nonce: Nonce, proof: &Proof) -> bool,
}

/// The [`Authenticator`] of the stock programs, by HMAC-SHA256.
pub const AUTHENTICATOR: Authenticator = Authenticator { rti_proof, is_federate_proof };

/// Answers the RTI as the stock programs do, by HMAC-SHA256: an [`Answer`].
pub fn answer_rti(key: &[u8], federate: u16, own: Nonce, proof: &Proof, rti: Nonce) -> Option<Proof> {
    is_rti_proof(key, federate, own, proof).then(|| federate_proof(key, rti))
}

/// Returns the RTI's proof for the nonce of a federate that claims this id.
pub fn rti_proof(key: &[u8], federate: u16, nonce: Nonce) -> Proof {
    of_rti(key, federate, nonce).finalize().into_bytes().into()
}

/// Returns whether the RTI's proof for a federate's nonce was made with this key. Takes the same time for every wrong
/// proof.
pub fn is_rti_proof(key: &[u8], federate: u16, nonce: Nonce, proof: &Proof) -> bool {
    of_rti(key, federate, nonce).verify_slice(proof).is_ok()
}

/// Returns the federate's proof for the RTI's nonce.
pub fn federate_proof(key: &[u8], nonce: Nonce) -> Proof {
    of_federate(key, nonce).finalize().into_bytes().into()
}

/// Returns whether a federate's proof for the RTI's nonce was made with this key. Takes the same time for every wrong
/// proof.
pub fn is_federate_proof(key: &[u8], nonce: Nonce, proof: &Proof) -> bool {
    of_federate(key, nonce).verify_slice(proof).is_ok()
}

fn of_rti(key: &[u8], federate: u16, nonce: Nonce) -> Hmac<Sha256> {
    hmac(key, MessageType::RtiResponse).chain_update(federate.to_le_bytes()).chain_update(nonce)
}

fn of_federate(key: &[u8], nonce: Nonce) -> Hmac<Sha256> {
    hmac(key, MessageType::FedResponse).chain_update(nonce)
}

fn hmac(key: &[u8], carrier: MessageType) -> Hmac<Sha256> {
    let hmac = Hmac::<Sha256>::new_from_slice(key).expect("an HMAC takes a key of any length");
    hmac.chain_update([carrier.byte()])
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEY: &[u8] = b"a secret federation";
    const NONCE: Nonce = [1, 2, 3, 4, 5, 6, 7, 8];

    #[test]
    fn a_proof_is_for_one_key_one_nonce_one_federate_and_one_side() {
        let proof = rti_proof(KEY, 0, NONCE);
        assert!(is_rti_proof(KEY, 0, NONCE, &proof));
        assert!(!is_rti_proof(b"a wrong key", 0, NONCE, &proof));
        assert!(!is_rti_proof(KEY, 1, NONCE, &proof));
        assert!(!is_rti_proof(KEY, 0, [0; 8], &proof));
        assert!(!is_federate_proof(KEY, NONCE, &proof));
        assert_eq!(answer_rti(KEY, 0, NONCE, &proof, [9; 8]), Some(federate_proof(KEY, [9; 8])));
        assert_eq!(answer_rti(KEY, 1, NONCE, &proof, [9; 8]), None);
        let proof = federate_proof(KEY, NONCE);
        assert!(is_federate_proof(KEY, NONCE, &proof));
        assert!(!is_federate_proof(b"", NONCE, &proof));
        assert!(!is_federate_proof(KEY, [0; 8], &proof));
    }

    /// A change of any bit is noticed.
    #[test]
    fn a_proof_counts_as_a_whole() {
        let proof = federate_proof(KEY, NONCE);
        for bit in 0..8 * HMAC_BYTES {
            let mut changed = proof;
            changed[bit / 8] ^= 1 << (bit % 8);
            assert!(!is_federate_proof(KEY, NONCE, &changed), "bit {bit}");
        }
    }
}
