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
    /// The federate in the last message, if that was such a question and nothing has followed it.
    open: Option<u16>,
}

impl QueryEnd {
    /// The state of a stream before its first message.
    pub const NONE: Self = Self { open: None };

    /// Records that a message has been taken from the stream.
    pub fn follow(&mut self, message: &Message<'_>) {
        self.open = match *message {
            Message::AddressQuery { federate, is_transient: None } => Some(federate),
            _ => None,
        };
    }

    /// Returns the federate in the question before, and whether it is transient, if the next byte still belongs to the
    /// question and says so.
    pub fn take(&mut self, next: &[u8]) -> Option<(u16, bool)> {
        if next.is_empty() {
            return None;
        }
        let federate = self.open.take()?;
        Some((federate, Reader::new(next).flag()?))
    }
}
