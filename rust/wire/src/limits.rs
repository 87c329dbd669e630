// SPDX-License-Identifier: Apache-2.0
//! What the owner of a connection accepts from its peer.

/// The greatest lengths that are accepted from a peer. A length above its limit is a
/// [`DecodeError::OverLimit`](crate::DecodeError::OverLimit) as soon as it has been read, before what it announces.
///
/// How long a message they allow, and so how large a receive buffer must be, says
/// [`message_bytes_max`](crate::message_bytes_max).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Longest payload of a message, in bytes.
    pub payload_bytes_max: usize,
    /// Longest federation id, in bytes. The wire itself cannot carry more than 255.
    pub federation_id_bytes_max: usize,
    /// Most neighbors in each direction of a neighbor structure.
    pub neighbors_max: usize,
}

impl Limits {
    /// Whatever the wire can carry. For tools and tests that look at bytes which they hold already.
    pub const NONE: Self =
        Self { payload_bytes_max: usize::MAX, federation_id_bytes_max: usize::MAX, neighbors_max: usize::MAX };
}
