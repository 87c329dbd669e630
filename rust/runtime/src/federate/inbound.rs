// SPDX-License-Identifier: Apache-2.0
//! A connection from a federate that sends to this one directly. What does not fit into its input's queue stays in its
//! buffer, and then unread, so that TCP slows the sender down.

use lf_coordination::{FederateId, from_wire};
use lf_model::time::Tag;
use lf_wire::{Limits, MessageType, tag_in_header};

use super::receiver::Receiver;
use crate::connection::{Connection, Reading};
use crate::description::TAGGED_MESSAGE_HEADER_BYTES;
use crate::platform::{Platform, SocketId};

/// A connection from a federate that sends to this one directly, with its memory.
#[derive(Debug)]
pub struct Inbound<'s> {
    pub(super) receiver: Receiver<'s>,
    /// The sender, once it is known.
    pub(super) from: Option<FederateId>,
    /// Whether the sender has ended its physical connections.
    pub(super) physical_over: bool,
    /// Whether the sender has connected and nobody has noted it.
    #[cfg(feature = "transients")]
    pub(super) is_new: bool,
}

impl<'s> Inbound<'s> {
    /// Returns a slot for a connection that is still to come, with a receive buffer in this memory.
    pub fn new(input: &'s mut [u8]) -> Self {
        let payload_bytes_max = input.len().saturating_sub(TAGGED_MESSAGE_HEADER_BYTES);
        let limits = Limits { payload_bytes_max, ..Limits::NONE };
        Self {
            receiver: Receiver::new(Connection::new(input, &mut []), limits),
            from: None,
            physical_over: false,
            #[cfg(feature = "transients")]
            is_new: false,
        }
    }

    /// Returns the capacity of the receive buffer in bytes.
    pub(super) fn capacity(&self) -> usize {
        self.receiver.connection.input.capacity()
    }

    /// Opens the connection of this federate.
    pub(super) fn open<P: Platform>(&mut self, platform: &mut P, from: FederateId, socket: SocketId) {
        (self.from, self.physical_over) = (Some(from), false);
        #[cfg(feature = "transients")]
        {
            self.is_new = true;
        }
        self.receiver.connection.open(socket);
        // The first byte of a connection always has room.
        let _ = platform.write(socket, &[MessageType::Ack.byte()]);
    }

    /// Reads once, if a wait has reported input.
    pub(super) fn fill<P: Platform>(&mut self, platform: &mut P) {
        self.receiver.connection.fill(platform);
    }

    /// Reads once. Returns `true` when there was something to read, or the end.
    pub(super) fn fill_now<P: Platform>(&mut self, platform: &mut P) -> bool {
        let has_space = !self.receiver.connection.input.space().is_empty();
        if has_space {
            self.receiver.connection.mark_readable();
        }
        has_space && self.receiver.connection.fill(platform) != Reading::Nothing
    }

    /// Returns whether nothing more comes, apart from what has come.
    pub(super) fn has_ended(&self) -> bool {
        self.receiver.connection.has_ended()
    }

    /// Returns whether a message for an earlier tag than this is incomplete. The rest of one that has no room in the
    /// receive buffer, behind held messages, comes only when a tag has made some.
    pub(super) fn awaits_rest_before(&mut self, tag: Tag) -> bool {
        let rest = self.receiver.rest();
        let is_earlier = tag_in_header(rest).is_some_and(|earlier| from_wire(earlier) < tag);
        is_earlier && self.from.is_some() && !self.has_ended() && !self.receiver.connection.input.space().is_empty()
    }

    /// Returns whether there is something to read, and space for it.
    pub(super) fn is_due(&mut self) -> bool {
        self.from.is_some() && self.receiver.connection.is_due()
    }

    /// Frees the slot. What is left is the beginning of a message that will not be completed.
    pub(super) fn close<P: Platform>(&mut self, platform: &mut P) {
        self.from = None;
        self.receiver.close(platform);
    }
}
