// SPDX-License-Identifier: Apache-2.0
//! Keys of the participants of a federation in virtual time, and their platforms.

use lf_runtime::{SecurePlatform, SecureSlot};
use lf_secure::{FederationSecret, HANDSHAKE_BYTES, Keyring, Member, StaticSecret};
use lf_testkit::world::Virtual;

use super::federation::{Plan, RTI};

/// The platform of a participant, which has keys if the plan says so.
pub(crate) type Host<'k> = SecurePlatform<'k, Virtual, Vec<u8>>;

/// Returns the secret of a participant, by its number.
pub(crate) fn secret(participant: usize) -> StaticSecret {
    StaticSecret::new([u8::try_from(participant).unwrap() + 1; 32])
}

/// Calls `with` with the platform of a participant.
pub(crate) fn with_host<R>(plan: &Plan, virtual_: Virtual, with: impl FnOnce(&mut Host<'_>) -> R) -> R {
    let members: Vec<_> = (0..u16::try_from(plan.nodes.len()).unwrap())
        .map(|federate| Member { federate, key: secret(usize::from(federate) + 1).public() })
        .collect();
    let own = plan.keys.get(&virtual_.number()).copied();
    let keyring =
        own.map(|own| Keyring::new(secret(own), FederationSecret::new([0xF5; 32]), secret(RTI).public(), &members));
    // Most messages are longer than a record.
    let buffer = || vec![0; HANDSHAKE_BYTES];
    let mut slots: Vec<_> = (0..2 * plan.nodes.len() + 8).map(|_| SecureSlot::new(buffer(), buffer())).collect();
    with(&mut SecurePlatform::new(virtual_, keyring, &mut slots))
}
