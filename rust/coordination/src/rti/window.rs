// SPDX-License-Identifier: Apache-2.0
//! Flow control: a sender waits for a receiver that is too many tags behind it.
//!
//! A sender that is quicker than its receiver would fill the receiver's queues. So a message from u to c is *held*, and
//! u's connection not read on, while c has messages of `window` different tags before it that are earlier than the tag
//! at which u is. Nothing else holds a message back, however many are on their way: those that a connection's delay
//! keeps there have tags later than u's.
//!
//! **Where u is.** A message tells its own tag, but not at which tag it was sent. What counts is u's next event, as for
//! grants: what it has announced, or the first message on its way to it if that is earlier. This is not later than the
//! tag at which u has sent what is now at the front of its connection. What it has announced alone could be, as it may
//! leave out what nobody needs.
//!
//! **Nobody waits for ever.** Whoever is held has its next event after that of its receiver. So the federate with the
//! earliest next event is never held. All that it waits for is known, since the next events of those that are held are
//! later; so it gets on, as long as it has something to do at what counts as its next event, for which see
//! `in_transit`. A next event cannot come to be earlier than the tag of what is held, for that tag has been granted.
//! `PORT_ABSENT`, announcements and stops of a federate that is held wait with its message, which is harmless for the
//! same reason.
//!
//! **Stopping** is the exception. Who has named a stop tag does not go beyond it, and leaves messages from there on
//! where they are, until all have named theirs; but the answer of a federate that is held lies behind its messages. So
//! it is looked for there, and the connection read on meanwhile, until there are as many bytes as the longest message
//! has, or [`LOOK_AHEAD_BYTES_MAX`] behind the message. Then the message goes. Once the stop tag is known, messages
//! with later tags hold nothing back, for they are never taken.
//!
//! **A sender that is gone** has said all the same what is held. If its answer to a stop is not behind that, it never
//! comes, so the sender counts as agreed, as one that has left does, though it leaves only when all has been passed on.
//!
//! **What it bounds.** Per input, there are messages of less than `window` tags before the tag where the sender is, and
//! what the sender has sent from there on: as long as it announces an event after each tag at which it has sent
//! something, as ours do, this is what the connection's delay keeps on its way.

use lf_model::time::Tag;
use lf_wire::{DecodeError, Decoded, Message, decode};

use super::{ConnectionId, Outlet, Rti, Verdict};
use crate::tag::from_wire;

/// How many bytes behind a message that is held are kept to find the answer to a stop request there. The longest
/// message can be as long as memory is large, and it is not for this that memory should be used up.
const LOOK_AHEAD_BYTES_MAX: usize = 1 << 20;

impl Rti<'_> {
    /// Whether the message at the front, which is `len` bytes long, has to wait because its receiver is too far behind
    /// its sender: then what is said of it.
    pub(super) fn hold(
        &mut self,
        sender: usize,
        message: &Message<'_>,
        bytes: &[u8],
        len: usize,
        outlet: &mut impl Outlet,
    ) -> Option<Verdict> {
        let Message::TaggedMessage { federate: receiver, .. } = *message else { return None };
        let connection = self.is_behind(receiver.into(), sender)?;
        let rest = bytes.get(len..).unwrap_or_default();
        if !self.awaits_stop_tag(sender) || self.look_ahead(sender, rest, outlet) {
            return Some(Verdict::Held(connection));
        }
        let is_full = bytes.len() >= self.message_bytes_max() || rest.len() >= LOOK_AHEAD_BYTES_MAX;
        (!is_full).then_some(Verdict::HeldReadOn(connection))
    }

    /// Whether a federate is too far behind one that has a message for it: then its connection.
    fn is_behind(&mut self, receiver: usize, sender: usize) -> Option<ConnectionId> {
        self.slots.get(receiver)?;
        let connection = self.connection_of(receiver)?;
        let at = self.position(sender);
        let window = self.config.window;
        self.in_transit(receiver).has_before(at, window).then_some(connection)
    }

    /// A tag that is not later than that at which a federate has sent what is at the front of its connection.
    fn position(&self, federate: usize) -> Tag {
        self.graph.next_event(federate).min(self.stop_tag().unwrap_or(Tag::FOREVER))
    }

    /// A federate that says nothing any more behind these bytes agrees to a stop as it says there, or in silence.
    pub(super) fn conclude(&mut self, federate: usize, bytes: &[u8], outlet: &mut impl Outlet) {
        if !self.look_ahead(federate, bytes, outlet) {
            self.on_stop_reply(federate, Tag::NEVER, outlet);
        }
    }

    /// Looks for what a federate says about a stop, or for its end, behind what it has to say before. Returns whether
    /// there is something. What is found is found again in its turn, and then says nothing new.
    ///
    /// Bounded by the number of bytes.
    fn look_ahead(&mut self, federate: usize, mut bytes: &[u8], outlet: &mut impl Outlet) -> bool {
        loop {
            let tag = match decode(bytes, &self.limits) {
                Ok(Decoded::Complete { message: Message::StopReply(tag) | Message::StopRequest(tag), .. }) => {
                    from_wire(tag)
                }
                // It will leave, and names no tag.
                Ok(Decoded::Complete { message: Message::Resign | Message::Failed, .. }) => Tag::NEVER,
                Ok(Decoded::Complete { len, .. }) => {
                    bytes = &bytes[len..];
                    continue;
                }
                Err(DecodeError::UnknownType { .. }) => {
                    bytes = &bytes[1..];
                    continue;
                }
                Ok(Decoded::Incomplete { .. }) => return false,
                Err(_) => Tag::NEVER,
            };
            self.on_stop_reply(federate, tag, outlet);
            return true;
        }
    }
}
