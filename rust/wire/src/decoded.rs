// SPDX-License-Identifier: Apache-2.0
//! What is read.

use crate::{Message, MessageType};

/// What the bytes at hand begin with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decoded<'a> {
    /// A whole message.
    Complete {
        /// The message; it borrows what has no fixed length.
        message: Message<'a>,
        /// Its length in bytes. What follows belongs to the next message.
        len: usize,
    },
    /// The beginning of a message, or nothing.
    Incomplete {
        /// Bytes that the message has at least, counted from its type byte; more than there are now.
        need: usize,
        /// The type of the message, once its first byte is there.
        message_type: Option<MessageType>,
    },
}

/// Where a payload goes, and how long it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Destination {
    /// Network input of the federate.
    pub port: u16,
    /// The federate.
    pub federate: u16,
    /// Length of the payload in bytes.
    pub payload_bytes: u32,
}
