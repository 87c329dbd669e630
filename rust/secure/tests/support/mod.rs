// SPDX-License-Identifier: Apache-2.0
//! Keys for tests.

use lf_secure::StaticSecret;

pub(crate) const FEDERATION: [u8; 32] = [0x5A; 32];
pub(crate) const EPHEMERAL: [u8; 32] = [0x11; 32];
/// The seed of the RTI's secret.
pub(crate) const RTI: u8 = 1;
/// The seed of federate 3's secret.
pub(crate) const FEDERATE: u8 = 2;

/// Returns a secret that depends on a seed only.
pub(crate) fn secret(seed: u8) -> StaticSecret {
    StaticSecret::new([seed; 32])
}
