// SPDX-License-Identifier: Apache-2.0
//! The last byte of an ADDRESS_QUERY, where it comes later than the others.

use crate::Message;
use crate::bytes::Reader;

/// Finds the last byte of an ADDRESS_QUERY in a stream of messages. [`decode`](crate::decode) takes the question for
/// whole without that byte, because not all releases of LF send it, and those that do not wait for the answer.
///
/// No federate that has joined sends a message whose type byte could be taken for that byte, so it is found for sure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct QueryEnd {
    /// The last message was such a question, and nothing has come behind it.
    is_open: bool,
}

impl QueryEnd {
    /// The state of a stream of which nothing has been read.
    pub const NONE: Self = Self { is_open: false };

    /// A message has been taken from the stream.
    pub fn follow(&mut self, message: &Message<'_>) {
        self.is_open = matches!(message, Message::AddressQuery { is_transient: None, .. });
    }

    /// How many of the bytes that come next still belong to the message before: one or none.
    pub fn take(&mut self, next: &[u8]) -> usize {
        if next.is_empty() || !core::mem::take(&mut self.is_open) {
            return 0;
        }
        usize::from(Reader::new(next).flag().is_some())
    }
}
