// SPDX-License-Identifier: Apache-2.0
//! The reasons why a connection is not secure, in words that say which end has which key and what to do.

use core::fmt;

use lf_texts::{say, text};

use crate::keyring::Participant;
use crate::keys::PublicKey;

/// The error of a single message of a handshake.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum HandshakeError {
    /// It is the other end's turn.
    Turn,
    /// The memory for the message is too short.
    Room,
    /// The message was made with other keys, changed on the way, or is too short.
    Forged,
    /// A key of the other end is none, or is missing.
    Key,
}

impl fmt::Display for HandshakeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Turn => say!(f, "it is the other end's turn in the handshake"),
            Self::Room => say!(f, "the memory for a message of the handshake is too short"),
            Self::Forged => say!(f, "a message of the handshake is not authentic"),
            Self::Key => say!(f, "a public key of the other end is no key"),
        }
    }
}

impl core::error::Error for HandshakeError {}

/// A reason that an end says, without proof, when it refuses a connection. It is of use to people only: a man in the
/// middle can forge it, and end the connection in other ways, too.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Hint {
    /// The first message was not readable: the federation's secret differs.
    Secret,
    /// The public key is not among those that it knows, or belongs to another participant than was expected.
    Key,
    /// Anything else.
    Other,
}

impl Hint {
    /// Returns the meaning of a byte.
    pub const fn from_byte(byte: u8) -> Self {
        match byte {
            1 => Self::Secret,
            2 => Self::Key,
            _ => Self::Other,
        }
    }

    /// Returns the byte on the wire.
    pub const fn byte(self) -> u8 {
        match self {
            Self::Secret => 1,
            Self::Key => 2,
            Self::Other => 0,
        }
    }
}

/// The reason why a connection cannot be used, or no more.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ChannelError {
    /// The other end does not encrypt: the first byte that came.
    Plain(u8),
    /// The other end speaks another version of this protocol.
    Version(u8),
    /// A message of the handshake could not be read.
    Handshake,
    /// The other end has a key that is not known here.
    UnknownKey(PublicKey),
    /// The other end is not the participant that was expected here.
    Other {
        /// The participant that was expected.
        expected: Participant,
        /// The one to which the key belongs that it has proved to have.
        found: Participant,
    },
    /// A record was changed, repeated, left out or moved, or comes from another connection.
    Forged,
    /// The length of a record is none that is possible here.
    Length(u16),
    /// The other end has refused the connection, as it says without proof.
    Refused(Hint),
}

impl ChannelError {
    /// Returns whether this end refuses the other one before it knows who that is.
    pub fn ends_handshake(&self) -> bool {
        !matches!(self, Self::Forged | Self::Length(_) | Self::Refused(_))
    }

    /// Returns what to tell the other end, without proof.
    pub(crate) fn hint(&self) -> Option<Hint> {
        match self {
            Self::Plain(_) | Self::Refused(_) => None,
            Self::Handshake => Some(Hint::Secret),
            Self::UnknownKey(_) | Self::Other { .. } => Some(Hint::Key),
            Self::Version(_) | Self::Forged | Self::Length(_) => Some(Hint::Other),
        }
    }
}

impl fmt::Display for ChannelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plain(byte) => say!(
                f,
                "the other end does not encrypt (its first byte is {byte}), and this federation has keys: give that \
                 end its keys, too"
            ),
            Self::Version(byte) => {
                say!(
                    f,
                    "the other end encrypts by version {byte} of the protocol, this one by version 1: build both \
                         with the same lf-zephyr-rs"
                )
            }
            Self::Handshake => say!(
                f,
                "the other end's handshake is not readable: it has another federation's secret, or its bytes were \
                 changed on the way"
            ),
            Self::UnknownKey(key) => say!(
                f,
                "the other end has the public key {key}, which is not among those that this end trusts: add it, or \
                 leave it shut out"
            ),
            Self::Other { expected, found } => say!(
                f,
                "the other end has the key of {found}, but {expected} was expected there: each participant needs its \
                 own key"
            ),
            Self::Forged => say!(f, "a record is not authentic: it was changed, repeated, left out or moved"),
            Self::Length(bytes) => say!(f, "a record of {bytes} bytes is none that is possible here"),
            Self::Refused(hint) => {
                let reason = match hint {
                    Hint::Secret => text!("it cannot read the handshake: compare the federation's secret of both ends"),
                    Hint::Key => text!("it does not accept the public key of this end: compare it with what it trusts"),
                    Hint::Other => text!("its log has the reason"),
                };
                say!(f, "the other end refuses the connection, as it says without proof; {reason}")
            }
        }
    }
}

impl core::error::Error for ChannelError {}
