// SPDX-License-Identifier: Apache-2.0
//! The reasons to refuse a connection.

use core::fmt;

use lf_texts::{say, text};

/// The reason in a REJECT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RejectCode {
    /// 1: the federation id differs.
    FederationIdMismatch,
    /// 2: the id is in use: a federate with it is connected, or has left the running federation.
    IdInUse,
    /// 3: the federation has no federate with this id.
    IdOutOfRange,
    /// 4: this message is not allowed now.
    UnexpectedMessage,
    /// 5: this message is for a federate but came to the RTI, or the reverse.
    WrongServer,
    /// 6: the HMAC was made with another key.
    HmacMismatch,
    /// 7: the federate began authentication, but the RTI does not use it.
    NotInAuthenticationMode,
    /// 8: the federation does not wait for this federate any more.
    JoinsTooLate,
    /// 229: this end has keys, and the other one does not encrypt, or claims an id that does not belong to its key.
    #[cfg(feature = "security")]
    Insecure,
    /// A code that this dialect does not have. [`RejectCode::from_byte`] never makes one of a code listed above.
    Other(u8),
}

impl RejectCode {
    /// Returns the meaning of a code.
    pub const fn from_byte(byte: u8) -> Self {
        match byte {
            1 => Self::FederationIdMismatch,
            2 => Self::IdInUse,
            3 => Self::IdOutOfRange,
            4 => Self::UnexpectedMessage,
            5 => Self::WrongServer,
            6 => Self::HmacMismatch,
            7 => Self::NotInAuthenticationMode,
            8 => Self::JoinsTooLate,
            #[cfg(feature = "security")]
            229 => Self::Insecure,
            other => Self::Other(other),
        }
    }

    /// Returns the code on the wire.
    pub const fn byte(self) -> u8 {
        match self {
            Self::FederationIdMismatch => 1,
            Self::IdInUse => 2,
            Self::IdOutOfRange => 3,
            Self::UnexpectedMessage => 4,
            Self::WrongServer => 5,
            Self::HmacMismatch => 6,
            Self::NotInAuthenticationMode => 7,
            Self::JoinsTooLate => 8,
            #[cfg(feature = "security")]
            Self::Insecure => 229,
            Self::Other(byte) => byte,
        }
    }
}

impl fmt::Display for RejectCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reason = match self {
            Self::FederationIdMismatch => text!("the federation id does not match"),
            Self::IdInUse => text!("a federate with this id is connected, or has left the running federation"),
            Self::IdOutOfRange => text!("the federation has no federate with this id"),
            Self::UnexpectedMessage => text!("the message was not expected"),
            Self::WrongServer => text!("the connection went to the wrong server"),
            Self::HmacMismatch => text!("the HMAC does not match"),
            Self::NotInAuthenticationMode => text!("the RTI does not use authentication"),
            Self::JoinsTooLate => text!("the federation has begun or ended without this federate"),
            #[cfg(feature = "security")]
            Self::Insecure => text!(
                "it has keys, and takes encrypted connections only, each federate with its own key: give this end its \
                 keys, too"
            ),
            Self::Other(_) => text!("a reason that is unknown here"),
        };
        say!(f, "{reason} (code {})", self.byte())
    }
}
