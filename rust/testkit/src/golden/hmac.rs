// SPDX-License-Identifier: Apache-2.0
//! The proofs that a tester has to compute itself, because they depend on a nonce that varies.

use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;

/// Returns the HMAC-SHA256 of bytes.
///
/// # Panics
/// Never: an HMAC takes a key of any length.
pub fn hmac(key: &str, bytes: &[u8]) -> [u8; 32] {
    let hmac = Hmac::<Sha256>::new_from_slice(key.as_bytes()).expect("an HMAC takes a key of any length");
    hmac.chain_update(bytes).finalize().into_bytes().into()
}

#[cfg(test)]
mod tests {
    /// Computes a recorded answer of the stock RTI: its type, then the federate's id and nonce.
    #[test]
    fn the_recorded_proof_comes_out() {
        let bytes = [101, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8];
        let proof = super::hmac("a secret federation", &bytes);
        let hex = proof.map(|byte| format!("{byte:02x}")).concat();
        assert_eq!(hex, "6e50e87dfc94fb250a17d907a91ca4f1e951324a5115dd1d34f7f3cd6e868afa");
    }
}
