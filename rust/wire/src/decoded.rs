// SPDX-License-Identifier: Apache-2.0
//! The results of decoding.

use crate::{Message, MessageType};

/// The message that the bytes begin with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decoded<'a> {
    /// A complete message.
    Complete {
        /// The message; it borrows its parts of variable length.
        message: Message<'a>,
        /// Its length in bytes. The next message follows.
        len: usize,
    },
    /// The beginning of a message, or nothing.
    Incomplete {
        /// The minimum number of bytes of the message, counted from its type byte; more than there are now.
        need: usize,
        /// The type of the message, once its first byte is there.
        message_type: Option<MessageType>,
    },
}

/// The destination and the length of a payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Destination {
    /// Network input of the federate.
    pub port: u16,
    /// The federate.
    pub federate: u16,
    /// Length of the payload in bytes.
    pub payload_bytes: u32,
}
