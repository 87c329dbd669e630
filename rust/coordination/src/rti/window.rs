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
//! **Nobody is held forever.** Whoever is held has its next event after that of its receiver. So the federate with the
//! earliest next event is never held. All that it waits for is known, since the next events of those that are held are
//! later; so it gets on, as long as it has something to do at what counts as its next event, for which see
//! `in_transit`. A next event cannot come to be earlier than the tag of what is held, for that tag has been granted.
//! `PORT_ABSENT`, announcements and stops of a federate that is held wait with its message, which is harmless for the
//! same reason.
//!
//! **Room** is the other thing that a message waits for, on its receiver's connection. A receiver reads on as long as
//! its receive buffer is not full of messages for queues that are full, so this wait ends, too, where no queue is
//! smaller than the bound below. Where one is, federates can wait in a circle: the first for room at the second, which
//! can empty its queue only after a tag whose output is held, because a third is behind, which waits for the first.
//! The RTI does not let such output go. It cannot tell a receiver that is full from one that is slow, and in a circle
//! with a slow one, which goes on by itself, the output would break the bound for queues that are large enough. The
//! second federate can tell, and ends with an error that names the input: at once where it waits for a grant, and
//! after a minute where its tag waits for room for output.
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
use lf_wire::{DecodeError, Decoded, Limits, Message, decode, message_bytes_max};

use crate::tag::from_wire;

/// How many bytes behind a message that is held are kept to find the answer to a stop request there. The longest
/// message can be as long as memory is large, and it is not for this that memory should be used up.
const LOOK_AHEAD_BYTES_MAX: usize = 1 << 20;

/// Whether no more is to be read behind a message that is held and `len` of these bytes long: all that are there.
pub(super) fn is_full(bytes: &[u8], len: usize, limits: &Limits) -> bool {
    bytes.len() >= message_bytes_max(limits) || bytes.len() - len >= LOOK_AHEAD_BYTES_MAX
}

/// Looks for what a federate says about a stop, or for its end, behind what it has to say before: the earliest tag at
/// which it can stop. What is found is found again in its turn, and then says nothing new.
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
            // As long as it is not whole, there is none.
            assert_eq!(look_ahead(&bytes[..bytes.len() - 1], &LIMITS), None);
        }
    }

    #[test]
    fn who_leaves_or_cannot_be_understood_names_no_tag() {
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
