// SPDX-License-Identifier: Apache-2.0
//! The header of a recording: 32 bytes with its participant and the version of the format.

use core::fmt;

/// Bytes of a record, and of a header.
pub const RECORD_BYTES: usize = 32;

/// The first bytes of a header.
pub const MAGIC: [u8; 8] = *b"lftrace\n";

/// The version of the format.
pub const FORMAT: u16 = 2;

/// The participant of the records that follow.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Header {
    /// The role of the participant.
    pub role: Role,
    /// The numbers of reactions, inputs and outputs in its tables, which identify the matching table of names.
    pub sizes: [u16; 3],
}

/// A participant.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Role {
    /// The federate with this id.
    Federate(u16),
    /// The RTI.
    Rti,
    /// A program that is not federated.
    Program,
}

/// The reason why bytes are no record or header.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Damage {
    /// They do not begin as a header does.
    Foreign,
    /// They are of another version of the format.
    Version(u16),
    /// The kind is unknown.
    Kind(u8),
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Foreign => f.write_str("it does not begin as a trace does"),
            Self::Version(version) => write!(f, "it is of version {version} of the format, and not of {FORMAT}"),
            Self::Kind(kind) => write!(f, "it has a record of a kind {kind} that is not known"),
        }
    }
}

impl Header {
    /// Returns the header as bytes.
    pub fn to_bytes(self) -> [u8; RECORD_BYTES] {
        let (role, id) = match self.role {
            Role::Federate(id) => (0, id),
            Role::Rti => (1, 0),
            Role::Program => (2, 0),
        };
        let mut bytes = Bytes([0; RECORD_BYTES]);
        bytes.put(0, MAGIC);
        bytes.put(8, FORMAT.to_le_bytes());
        bytes.put(10, [role]);
        bytes.put(12, id.to_le_bytes());
        for (index, size) in self.sizes.into_iter().enumerate() {
            bytes.put(14 + 2 * index, size.to_le_bytes());
        }
        bytes.0
    }

    /// Reads a header.
    ///
    /// # Errors
    /// Returns the defect.
    pub fn from_bytes(bytes: &[u8; RECORD_BYTES]) -> Result<Self, Damage> {
        let bytes = Bytes(*bytes);
        if bytes.get::<8>(0) != MAGIC {
            return Err(Damage::Foreign);
        }
        let number = |at| u16::from_le_bytes(bytes.get(at));
        if number(8) != FORMAT {
            return Err(Damage::Version(number(8)));
        }
        let role = match bytes.0[10] {
            0 => Role::Federate(number(12)),
            1 => Role::Rti,
            2 => Role::Program,
            other => return Err(Damage::Kind(other)),
        };
        Ok(Self { role, sizes: [number(14), number(16), number(18)] })
    }
}

/// Bytes at positions that are all constants within the record.
pub(super) struct Bytes(pub(super) [u8; RECORD_BYTES]);

impl Bytes {
    pub(super) fn put<const N: usize>(&mut self, at: usize, value: [u8; N]) {
        self.0[at..at + N].copy_from_slice(&value);
    }

    pub(super) fn get<const N: usize>(&self, at: usize) -> [u8; N] {
        let mut value = [0; N];
        value.copy_from_slice(&self.0[at..at + N]);
        value
    }
}
