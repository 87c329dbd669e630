// SPDX-License-Identifier: Apache-2.0
//! Flow control: a sender waits for a receiver that is too many tags behind it.
//!
//! A sender that is faster than its receiver would fill the receiver's queues. So the RTI *holds* a message from u to
//! c, and does not read u's connection on, while c has messages of `window` different tags before it that are earlier
//! than the tag at which u is. Nothing else holds a message back, however many are in transit: those that a
//! connection's delay keeps there have tags later than u's.
//!
//! **The position of u.** A message has its own tag, but not the tag at which it was sent. The position is u's next
//! event, as for grants: what it has announced, or the first message in transit to it if that is earlier. This is not
//! later than the tag at which u has sent the message at the front of its connection. The announcement alone could be
//! later, as u may leave out announcements that no federate needs.
//!
//! **No sender is held forever.** A held sender has its next event after that of its receiver. So the federate with the
//! earliest next event is never held. Everything that it waits for is known, since the next events of those that are
//! held are later; so it proceeds, as long as it has something to do at its next event (see `in_transit`). A next event
//! cannot become earlier than the tag of a held message, because that tag has been granted. `PORT_ABSENT`,
//! announcements and stops of a held federate wait with its message, which is harmless for the same reason.
//!
//! **Room** on its receiver's connection is the other thing that a message waits for. A receiver reads on as long as
//! its receive buffer is not full of messages for queues that are full, so this wait ends, too, if no queue is smaller
//! than the bound below. If one is, federates can wait in a circle: the first for room at the second, which can empty
//! its queue only after a tag whose output is held, because a third is behind, which waits for the first. The RTI does
//! not let such output go. It cannot tell a receiver that is full from one that is slow, and in a circle with a slow
//! one, which proceeds by itself, the output would break the bound for queues that are large enough. The second
//! federate can tell, and ends with an error that names the input: at once if it waits for a grant, and after a minute
//! if its tag waits for room for output.
//!
//! **Stopping** is the exception. A federate that has named a stop tag does not go beyond it, and leaves messages from
//! there on where they are, until all have named theirs; but the answer of a held federate lies behind its messages. So
//! the RTI looks for the answer there, and reads the connection on meanwhile, until there are as many bytes as the
//! longest message has, or [`LOOK_AHEAD_BYTES_MAX`] behind the message. Then the message goes. Once the stop tag is
//! known, messages with later tags hold nothing back, because they are never taken.
//!
//! **A sender that is gone** has still sent what is held. If its answer to a stop is not behind that, it never comes,
//! so the sender counts as agreed, like one that has left, though it leaves only when everything has been passed on.
//!
//! **A larger window.** A batch of 16 messages on its way through three processes costs more switches between them than
//! work. So a federate whose receive buffer has memory for more messages offers a larger window (module `flow`): each
//! of its inputs finds room for twice as many tags there, for this module's share and for those that a sender is ahead
//! of the RTI. Once all federates that take part have offered one, the smallest counts, here and for senders. A board
//! offers none, and neither does a federate of another runtime, so the usual window stays where one takes part.
//!
//! **The bound.** Per input, there are messages of less than `window` tags before the position of the sender, and the
//! messages that the sender has sent from there on: if it announces an event after each tag at which it has sent
//! something, as ours do, these are the messages that the connection's delay keeps in transit.

use lf_model::time::Tag;
use lf_wire::{DecodeError, Decoded, Limits, Message, decode, message_bytes_max};

use super::machine::Rti;
use crate::tag::from_wire;

/// The number of bytes behind a held message that are kept to find the answer to a stop request there. The longest
/// message can be as long as memory is large, but the search must not use up memory.
const LOOK_AHEAD_BYTES_MAX: usize = 1 << 20;

impl Rti<'_> {
    /// Handles the window that a federate offers. Returns that of the federation.
    pub(super) fn take_offer(&mut self, federate: usize, offer: u16) -> u16 {
        let before = core::mem::replace(&mut self.members.slots[federate].window, offer);
        if before != offer {
            self.agree_on_window();
        }
        self.window
    }

    /// Sets the window of the federation by what those that take part offer. Half of the storage for tags is for
    /// messages that a delay keeps in transit.
    pub(super) fn agree_on_window(&mut self) {
        let members = &self.members;
        let offers = (0..members.slots.len()).filter(|federate| members.running(*federate).is_some());
        let smallest = offers.map(|federate| members.slots[federate].window).min().unwrap_or_default();
        let stored = u16::try_from(self.tags.in_transit_max() / 2).unwrap_or(u16::MAX);
        self.window = smallest.min(stored).max(self.config.window);
    }
}

/// Returns whether to stop reading behind a held message that is `len` of these bytes long: all that are there.
pub(super) fn is_full(bytes: &[u8], len: usize, limits: &Limits) -> bool {
    bytes.len() >= message_bytes_max(limits) || bytes.len() - len >= LOOK_AHEAD_BYTES_MAX
}

/// Looks for a federate's answer to a stop, or for its end, behind its earlier messages: the earliest tag at which it
/// can stop. The same message is found again in its order, and has no effect then.
///
/// Bounded by the number of bytes.
pub(super) fn look_ahead(mut bytes: &[u8], limits: &Limits) -> Option<Tag> {
    loop {
        match decode(bytes, limits) {
            Ok(Decoded::Complete { message: Message::StopReply(tag) | Message::StopRequest(tag), .. }) => {
                return Some(from_wire(tag));
            }
            // It will leave, and names no tag.
            Ok(Decoded::Complete { message: Message::Resign | Message::Failed, .. }) => return Some(Tag::NEVER),
            Ok(Decoded::Complete { len, .. }) => bytes = &bytes[len..],
            Err(DecodeError::UnknownType { .. }) => bytes = &bytes[1..],
            Ok(Decoded::Incomplete { .. }) => return None,
            Err(_) => return Some(Tag::NEVER),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    const LIMITS: Limits = Limits { payload_bytes_max: 100, federation_id_bytes_max: 10, neighbors_max: 1 };

    fn encoded(messages: &[Message<'_>]) -> Vec<u8> {
        messages.iter().flat_map(lf_testkit::messages::encoded).collect()
    }

    fn tagged() -> Message<'static> {
        Message::TaggedMessage { port: 1, federate: 0, tag: lf_wire::Tag::FOREVER, payload: b"message" }
    }

    #[test]
    fn an_answer_to_a_stop_is_found_behind_messages_and_bytes_that_are_none() {
        let tag = lf_wire::Tag { time: 7, microstep: 1 };
        for answer in [Message::StopReply(tag), Message::StopRequest(tag)] {
            let bytes = [encoded(&[tagged()]), [250].to_vec(), encoded(&[tagged(), answer])].concat();
            assert_eq!(look_ahead(&bytes, &LIMITS), Some(from_wire(tag)));
            // A message that is not complete is none.
            assert_eq!(look_ahead(&bytes[..bytes.len() - 1], &LIMITS), None);
        }
    }

    #[test]
    fn a_federate_that_leaves_or_sends_nonsense_names_no_tag() {
        for end in [Message::Resign, Message::Failed] {
            assert_eq!(look_ahead(&encoded(&[tagged(), end]), &LIMITS), Some(Tag::NEVER));
        }
        let none = Limits { payload_bytes_max: 1, ..LIMITS };
        assert_eq!(look_ahead(&encoded(&[tagged()]), &none), Some(Tag::NEVER));
    }

    #[test]
    fn no_more_is_read_than_the_longest_message_or_the_limit() {
        let longest = message_bytes_max(&LIMITS);
        let full = |bytes: usize, len| is_full(&std::vec![0; bytes], len, &LIMITS);
        assert_eq!([longest - 1, longest].map(|bytes| full(bytes, 40)), [false, true]);
        let large = Limits { payload_bytes_max: 4 * LOOK_AHEAD_BYTES_MAX, ..LIMITS };
        let full = |behind: usize| is_full(&std::vec![0; 40 + behind], 40, &large);
        assert_eq!([LOOK_AHEAD_BYTES_MAX - 1, LOOK_AHEAD_BYTES_MAX].map(full), [false, true]);
    }
}
