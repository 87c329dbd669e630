// SPDX-License-Identifier: Apache-2.0
//! The keys that one participant has, of itself and of the others.

use core::fmt;

use crate::keys::{FederationSecret, PublicKey, StaticSecret};

/// A participant of a federation.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Participant {
    /// The RTI.
    Rti,
    /// The federate with this id.
    Federate(u16),
}

impl fmt::Display for Participant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rti => f.write_str("the RTI"),
            Self::Federate(id) => write!(f, "federate {id}"),
        }
    }
}

/// A federate and its public key, as C has them in `lf/keys.h`.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Member {
    /// The federate's id.
    pub federate: u16,
    /// Its public key.
    pub key: PublicKey,
}

/// The keys of one participant: its own secret, that of the federation, and the public keys of those that it accepts.
///
/// A participant that is not in it, such as a board that was lost, is refused.
#[derive(Clone, Debug)]
pub struct Keyring<'a> {
    own: StaticSecret,
    public: PublicKey,
    federation: FederationSecret,
    rti: PublicKey,
    federates: &'a [Member],
}

impl<'a> Keyring<'a> {
    /// Returns the keys of a participant: of the RTI with its own public key as `rti`, too. `federates` are those that
    /// connect to it or to which it connects, in any order; a federate that speaks with the RTI only needs none.
    ///
    /// Computes its own public key, which takes as long as one step of a handshake.
    pub fn new(own: StaticSecret, federation: FederationSecret, rti: PublicKey, federates: &'a [Member]) -> Self {
        let public = own.public();
        Self { own, public, federation, rti, federates }
    }

    /// Returns its own secret.
    pub(crate) fn own(&self) -> &StaticSecret {
        &self.own
    }

    /// Returns its own public key.
    pub fn public(&self) -> &PublicKey {
        &self.public
    }

    /// Returns the secret of the federation.
    pub(crate) fn federation(&self) -> &FederationSecret {
        &self.federation
    }

    /// Returns the public key of a participant, if it is known here.
    pub fn key_of(&self, participant: Participant) -> Option<&PublicKey> {
        match participant {
            Participant::Rti => Some(&self.rti),
            Participant::Federate(id) => {
                self.federates.iter().find(|member| member.federate == id).map(|member| &member.key)
            }
        }
    }

    /// Returns which participant has this key, or `None` if no known one has it.
    pub fn owner_of(&self, key: &PublicKey) -> Option<Participant> {
        if *key == self.rti {
            return Some(Participant::Rti);
        }
        let member = self.federates.iter().find(|member| member.key == *key)?;
        Some(Participant::Federate(member.federate))
    }
}
