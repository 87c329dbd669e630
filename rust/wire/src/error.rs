// SPDX-License-Identifier: Apache-2.0
//! The errors of bytes and messages. Every error has its position and the value found there.

use core::fmt;

use lf_texts::say;

use crate::MessageType;

/// Bytes that are not a message, or a message that the owner's [`Limits`](crate::Limits) exclude. Offsets count from
/// the type byte of the message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DecodeError {
    /// The type byte, at offset 0, is none of this dialect.
    UnknownType {
        /// The type byte.
        found: u8,
    },
    /// A length or count is above the owner's limit.
    OverLimit {
        /// Type of the message.
        message: MessageType,
        /// Name of the field that holds the length.
        field: &'static str,
        /// Where that field begins.
        offset: usize,
        /// The length found there.
        found: u32,
        /// The owner's limit.
        limit: usize,
    },
    /// A count is negative.
    Negative {
        /// Type of the message.
        message: MessageType,
        /// Name of the field that holds the count.
        field: &'static str,
        /// Where that field begins.
        offset: usize,
        /// The count found there.
        found: i32,
    },
    /// The message is of a type that the owner does not expect.
    Unexpected {
        /// Type of the message.
        message: MessageType,
    },
    /// The message is within the limits, but can never be complete in this buffer. The owner's limits and the capacity
    /// of its buffer contradict each other.
    LargerThanBuffer {
        /// Type of the message, if its first byte is there.
        message: Option<MessageType>,
        /// The minimum number of bytes of the message.
        needed: usize,
        /// Bytes that the buffer holds.
        capacity: usize,
    },
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            #[cfg(feature = "security")]
            Self::UnknownType { found: 0xE5 } => {
                say!(
                    f,
                    "the other end encrypts, and this one has no keys: give it its keys, or build the other one without"
                )
            }
            Self::UnknownType { found } => say!(f, "type byte {found} at offset 0 is no message of this protocol"),
            Self::OverLimit { message, field, offset, found, limit } => {
                say!(
                    f,
                    "{message}: {field} at offset {offset} is {found}, more than the {limit} that are accepted here"
                )
            }
            Self::Negative { message, field, offset, found } => {
                say!(f, "{message}: {field} at offset {offset} is {found}, but cannot be negative")
            }
            Self::Unexpected { message } => say!(f, "{message}: is not expected here"),
            Self::LargerThanBuffer { message, needed, capacity } => {
                let message = message.map_or("any message", MessageType::name);
                say!(f, "{message}: has {needed} bytes or more, but the receive buffer holds {capacity}")
            }
        }
    }
}

impl core::error::Error for DecodeError {}

/// There is less room than the message needs. Nothing has been written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoRoom {
    /// Bytes that the message needs.
    pub needed: usize,
    /// Available bytes.
    pub room: usize,
}

impl fmt::Display for NoRoom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        say!(f, "{} bytes are needed, there is room for {}", self.needed, self.room)
    }
}

impl core::error::Error for NoRoom {}

/// A length that exceeds its field on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LengthOverflow {
    /// Type of the message.
    pub message: MessageType,
    /// Name of the field that would hold the length.
    pub field: &'static str,
    /// The length.
    pub length: usize,
    /// The greatest length that the field can hold.
    pub max: u32,
}

impl fmt::Display for LengthOverflow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { message, field, length, max } = self;
        say!(f, "{message}: {field} would be {length}, but the wire carries at most {max}")
    }
}

impl core::error::Error for LengthOverflow {}

/// The reason why a message was not encoded. Nothing has been written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EncodeError {
    /// The target is too small, now or always.
    NoRoom(NoRoom),
    /// A part of the message is longer than its length field can hold.
    LengthOverflow(LengthOverflow),
}

impl From<NoRoom> for EncodeError {
    fn from(error: NoRoom) -> Self {
        Self::NoRoom(error)
    }
}

impl From<LengthOverflow> for EncodeError {
    fn from(error: LengthOverflow) -> Self {
        Self::LengthOverflow(error)
    }
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoRoom(error) => error.fmt(f),
            Self::LengthOverflow(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for EncodeError {}

/// The reason why a message whose payload is encoded in place was not pushed. The buffer is unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PushError<E> {
    /// The message cannot be written with any payload.
    Encode(EncodeError),
    /// The payload could not be encoded.
    Payload(E),
    /// The encoder of the payload returns more bytes than it had.
    PayloadOverrun {
        /// Bytes that it claims to have written.
        written: usize,
        /// Bytes that it had.
        given: usize,
    },
}

impl<E: fmt::Display> fmt::Display for PushError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Encode(error) => error.fmt(f),
            Self::Payload(error) => error.fmt(f),
            Self::PayloadOverrun { written, given } => {
                say!(f, "the payload's encoder was given {given} bytes and claims to have written {written}")
            }
        }
    }
}

impl<E: core::error::Error> core::error::Error for PushError<E> {}
