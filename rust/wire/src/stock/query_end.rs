// SPDX-License-Identifier: Apache-2.0
//! The last byte of an ADDRESS_QUERY, if it comes later than the others.

use crate::Message;
use crate::bytes::Reader;

/// Finds the last byte of an ADDRESS_QUERY in a stream of messages. [`decode`](crate::decode) treats the question as
/// complete without that byte, because not all releases of LF send it, and those that do not wait for the answer.
///
/// No federate that has joined sends a message whose type byte could be taken for that byte, so the result is certain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct QueryEnd {
    /// Whether the last message was such a question, and nothing has followed it.
    is_open: bool,
}

impl QueryEnd {
    /// The state of a stream before its first message.
    pub const NONE: Self = Self { is_open: false };

    /// Records that a message has been taken from the stream.
    pub fn follow(&mut self, message: &Message<'_>) {
        self.is_open = matches!(message, Message::AddressQuery { is_transient: None, .. });
    }

    /// Returns how many of the next bytes still belong to the message before: one or none.
    pub fn take(&mut self, next: &[u8]) -> usize {
        if next.is_empty() || !core::mem::take(&mut self.is_open) {
            return 0;
        }
        usize::from(Reader::new(next).flag().is_some())
    }
}
