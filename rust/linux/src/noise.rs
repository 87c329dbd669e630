// SPDX-License-Identifier: Apache-2.0
//! The memory of connections that are encrypted by Noise.

use lf_runtime::{SecurePlatform, SecureSlot};
use lf_secure::{FederationSecret, Keyring, Member, PublicKey, RECORD_OVERHEAD, StaticSecret};

use crate::keys::NoiseKeys;
use crate::platform::Linux;

/// The longest content of a record: the RTI's messages go out at once, and no end waits long for the rest of a record.
const CONTENT_BYTES: usize = 1 << 14;
/// The number of such records that are read at once.
const RECORDS: usize = 4;

/// The platform of a program, whose connections are encrypted by Noise if it has keys for that.
pub(crate) type Host<'k> = SecurePlatform<'k, Linux, Vec<u8>>;

/// The memory of the connections of a program.
pub(crate) struct NoiseMemory {
    keys: Option<NoiseKeys>,
    members: Vec<Member>,
    slots: Vec<SecureSlot<Vec<u8>>>,
}

impl NoiseMemory {
    /// Returns memory for this number of connections; without keys they need none.
    pub(crate) fn new(keys: Option<NoiseKeys>, connections: usize) -> Self {
        let federates = keys.iter().flat_map(|keys| &keys.others.federates);
        let member = |(federate, key): (&u16, &_)| Member { federate: *federate, key: PublicKey::new(*key) };
        let members = federates.map(member).collect();
        // The kernel gives only what is touched.
        let buffer = |records: usize| vec![0; records * (CONTENT_BYTES + RECORD_OVERHEAD)];
        let connections = if keys.is_some() { connections } else { 0 };
        let slots = (0..connections).map(|_| SecureSlot::new(buffer(RECORDS), buffer(1))).collect();
        Self { keys, members, slots }
    }

    /// Returns the platform of a program over that of its system.
    pub(crate) fn platform(&mut self, linux: Linux) -> Host<'_> {
        let Self { keys, members, slots } = self;
        let keyring = keys.as_ref().map(|keys| {
            let (own, federation) = (StaticSecret::new(keys.own), FederationSecret::new(keys.federation));
            // The RTI's own folder has no key of the RTI but its secret one.
            let rti = keys.others.rti.map_or_else(|| own.public(), PublicKey::new);
            Keyring::new(own, federation, rti, members)
        });
        SecurePlatform::new(linux, keyring, slots)
    }
}
