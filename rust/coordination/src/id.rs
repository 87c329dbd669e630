// SPDX-License-Identifier: Apache-2.0
//! The ids that both state machines use.

use core::fmt;

/// The number of a federate: its index among the federates of its federation, as it stands on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FederateId(pub u16);

impl FederateId {
    /// Returns this id as an index into tables with one entry per federate.
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

impl From<u16> for FederateId {
    fn from(id: u16) -> Self {
        Self(id)
    }
}

impl fmt::Display for FederateId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
