// SPDX-License-Identifier: Apache-2.0
//! From bytes to messages that are taken or held, on any connection of a federate.
//!
//! One connection carries messages for several inputs, and that to the RTI control messages too. A message without room
//! in the queue of its input is held where it lies, and the messages behind it are examined: they may be for another
//! input, or let the tag begin that makes room. A [`Policy`] decides what may come, what waits for what, and which
//! error bytes are that are no message: there is one for the RTI and one for other federates.
//!
//! Handling messages out of order changes nothing that the program sees, since events are ordered by tag and no tag
//! begins before all of its messages are in their queues.

use lf_coordination::from_wire;
use lf_model::time::Tag;
use lf_model::{DeliverError, Engine, InputId};
use lf_wire::{DecodeError, Decoded, Limits, Message, MessageType, decode_expected, destination_in_header};

use super::execution::Failed;
use super::held::Held;
use crate::connection::Connection;
use crate::error::RunError;
use crate::platform::Platform;

/// The disposition of a message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Disposition {
    /// It is handled.
    Taken,
    /// It is handled, and held messages may need no room any more.
    TakenForAll,
    /// It waits for room for this tag in the queue of its input, or else until everything before it has been handled.
    Held(Tag, Option<InputId>),
    /// It is a grant that waits, and reaches the earliest held tag.
    HeldGrant,
}

/// The rules for messages on a connection.
pub(super) trait Policy {
    /// Whether messages may have to wait.
    const HOLDS: bool = true;

    /// Returns whether messages of this type can come in a correct federation.
    fn expects(_: MessageType) -> bool {
        true
    }

    /// Returns whether the next TIMESTAMP is that for a transient federate. Nothing is held before it.
    #[cfg(feature = "transients")]
    fn awaits_effective_start(&self) -> bool {
        false
    }

    /// Returns the length of a message that is too long for the receive buffer, if it may be skipped.
    #[cfg(feature = "transients")]
    fn skips(&self, _bytes: &[u8]) -> Option<usize> {
        None
    }

    /// Handles a message behind the held ones, or returns what it waits for.
    ///
    /// # Errors
    /// When it must not come.
    fn take(&mut self, message: Message<'_>, held: &Held) -> Result<Disposition, Failed>;

    /// Returns the error for bytes that are no message.
    fn refuse(&mut self, bytes: &[u8], error: DecodeError) -> Failed;
}

/// A connection whose messages are examined one by one.
#[derive(Debug)]
pub(super) struct Receiver<'s> {
    pub(super) connection: Connection<'s>,
    pub(super) held: Held,
    /// The number of bytes of messages that were held together before and have not been examined again.
    alike: usize,
    /// The number of bytes to come of a message that is skipped.
    #[cfg(feature = "transients")]
    skipped: usize,
    limits: Limits,
}

impl<'s> Receiver<'s> {
    /// Returns a receiver of messages within these limits.
    pub(super) fn new(connection: Connection<'s>, limits: Limits) -> Self {
        Self {
            connection,
            held: Held::NONE,
            alike: 0,
            #[cfg(feature = "transients")]
            skipped: 0,
            limits,
        }
    }

    /// Goes back to the front of the held messages, if there may be room for them now.
    pub(super) fn resume(&mut self) {
        self.alike = self.held.release();
    }

    /// Examines the next message, which is not examined again before [`Receiver::resume`]. Returns `None` when there is
    /// no complete one; else whether it was taken. Its bytes are then gone.
    ///
    /// # Errors
    /// Those of the policy.
    pub(super) fn next<P: Policy>(&mut self, policy: &mut P) -> Result<Option<bool>, Failed> {
        let held = if P::HOLDS { self.held.bytes } else { 0 };
        #[cfg(feature = "transients")]
        if !self.skip() {
            return Ok(None);
        }
        let next = match policy {
            #[cfg(feature = "transients")]
            _ if policy.awaits_effective_start() => self.connection.input.next_to_transient(&self.limits, P::expects),
            _ => self.connection.input.next_expected(held, &self.limits, P::expects),
        };
        let next = match next {
            #[cfg(feature = "transients")]
            Err(error)
                if is_too_long(error)
                    && let Some(bytes) = policy.skips(self.rest()) =>
            {
                self.skipped = bytes;
                return self.next(policy);
            }
            next => next.map_err(|error| policy.refuse(self.rest(), error))?,
        };
        let Some((message, len)) = next else { return Ok(None) };
        let disposition = policy.take(message, &self.held)?;
        match disposition {
            _ if !P::HOLDS => self.connection.input.remove(0, len),
            Disposition::Taken | Disposition::TakenForAll => {
                self.connection.input.remove(self.held.bytes, len);
                self.alike = self.alike.saturating_sub(len);
            }
            // With those behind it for the same input, whose tags are later.
            Disposition::Held(tag, to) => self.held.hold(len.max(core::mem::take(&mut self.alike)), tag, to),
            Disposition::HeldGrant => self.held.hold_grant(len),
        }
        if P::HOLDS && disposition == Disposition::TakenForAll && self.held.input.is_some() {
            (self.held, self.alike) = (Held::NONE, 0);
        }
        Ok(Some(matches!(disposition, Disposition::Taken | Disposition::TakenForAll)))
    }

    /// Removes what has come of a message that is skipped. Returns whether that was all of it.
    #[cfg(feature = "transients")]
    fn skip(&mut self) -> bool {
        let bytes = self.skipped.min(self.rest().len());
        if bytes > 0 {
            self.connection.input.remove(self.held.bytes, bytes);
            self.skipped -= bytes;
        }
        self.skipped == 0
    }

    /// Closes the connection: nothing is held any more.
    pub(super) fn close<P: Platform>(&mut self, platform: &mut P) {
        (self.held, self.alike) = (Held::NONE, 0);
        self.connection.close(platform);
    }

    /// Returns the input whose held messages fill the whole buffer, so that the connection cannot be read. This lasts
    /// while no tag can begin or complete either.
    pub(super) fn full_input(&mut self) -> Option<InputId> {
        self.held.input.filter(|_| !self.held.stale && self.connection.input.space().is_empty())
    }

    /// Returns the bytes that are not held: the incomplete message.
    pub(super) fn rest(&self) -> &[u8] {
        self.connection.input.bytes().get(self.held.bytes..).unwrap_or_default()
    }

    /// Returns the tag of the first held message for this port, if there is one.
    pub(super) fn first_held<P: Policy>(&self, awaited: u16) -> Option<Tag> {
        let mut held = self.connection.input.bytes().get(..self.held.bytes).unwrap_or_default();
        while let Ok(Decoded::Complete { message, len }) = decode_expected(held, &self.limits, P::expects) {
            if let Message::P2pTaggedMessage { port, tag, .. } | Message::PortAbsent { port, tag, .. } = message
                && port == awaited
            {
                return Some(from_wire(tag));
            }
            held = held.get(len..).unwrap_or_default();
        }
        None
    }
}

fn is_too_long(error: DecodeError) -> bool {
    matches!(error, DecodeError::OverLimit { .. } | DecodeError::LargerThanBuffer { .. })
}

/// Returns the error for a message that is too long for the receive buffer: it is a message, but not a value of its
/// input.
pub(super) fn too_long(bytes: &[u8], error: DecodeError, engine: &Engine<'_>) -> Option<RunError> {
    if !is_too_long(error) {
        return None;
    }
    let header = destination_in_header(bytes)?;
    let (port, bytes) = (header.port, header.payload_bytes);
    let tables = engine.tables();
    match tables.input_of(port).map(|input| &tables.inputs[usize::from(input.0)]) {
        Some(input) => Some(RunError::TooLong { input: input.name, bytes, max: input.max_len }),
        None => Some(DeliverError::NoSuchPort { port }.into()),
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use lf_coordination::to_wire;
    use lf_model::time::{Instant, Tag};
    use lf_wire::OutBuffer;

    use super::*;

    /// Inputs with this much room each, and what they have received; `looks` counts the examined messages.
    struct Inputs {
        room: [usize; 2],
        taken: Vec<(u16, i64)>,
        looks: usize,
    }

    impl Policy for Inputs {
        fn take(&mut self, message: Message<'_>, _: &Held) -> Result<Disposition, Failed> {
            self.looks += 1;
            let Message::P2pTaggedMessage { port, tag, .. } = message else { return Ok(Disposition::TakenForAll) };
            let room = &mut self.room[usize::from(port)];
            if *room == 0 {
                return Ok(Disposition::Held(lf_coordination::from_wire(tag), Some(InputId(port))));
            }
            *room -= 1;
            self.taken.push((port, tag.time));
            Ok(Disposition::Taken)
        }

        fn refuse(&mut self, _: &[u8], error: DecodeError) -> Failed {
            panic!("{error}")
        }
    }

    fn message(port: u16, time: i64) -> Message<'static> {
        Message::P2pTaggedMessage { port, federate: 0, tag: to_wire(Tag::at(Instant::from_nanos(time))), payload: &[7] }
    }

    /// Returns which of these messages a receiver takes and holds, for inputs with this much room.
    fn run(
        messages: &[Message<'_>],
        room: [usize; 2],
        test: impl FnOnce(&mut dyn FnMut(Option<[usize; 2]>) -> Inputs),
    ) {
        let (mut bytes, mut encoded) = ([0; 512], [0; 512]);
        let mut output = OutBuffer::new(&mut encoded[..]);
        for message in messages {
            output.push(message).expect("there is room");
        }
        let mut receiver = Receiver::new(Connection::new(&mut bytes, &mut []), Limits::NONE);
        receiver.connection.input.space()[..output.pending().len()].copy_from_slice(output.pending());
        receiver.connection.input.filled(output.pending().len());
        test(&mut |again| {
            let mut inputs = Inputs { room: again.unwrap_or(room), taken: Vec::new(), looks: 0 };
            if again.is_some() {
                receiver.held.recheck();
            }
            receiver.resume();
            while receiver.next(&mut inputs).expect("all are messages").is_some() {}
            inputs
        });
    }

    #[test]
    fn a_message_without_room_is_held_and_others_pass_it_in_order() {
        run(&[message(0, 1), message(1, 2), message(0, 3), message(1, 4)], [0, 2], |take| {
            assert_eq!(take(None).taken, [(1, 2), (1, 4)]);
            // As nothing has changed, nothing is examined.
            assert_eq!(take(None).looks, 0);
            assert_eq!(take(Some([1, 0])).taken, [(0, 1)]);
            assert_eq!(take(Some([5, 0])).taken, [(0, 3)]);
        });
    }

    #[test]
    fn of_many_messages_for_one_full_input_only_the_first_is_looked_at_again() {
        let messages: Vec<_> = (0..9).map(|time| message(0, time)).collect();
        run(&messages, [0, 0], |take| {
            assert_eq!(take(None).looks, 9);
            assert_eq!(take(Some([0, 0])).looks, 1);
            let inputs = take(Some([2, 0]));
            assert_eq!((inputs.looks, inputs.taken), (3, [(0, 0), (0, 1)].to_vec()));
            assert_eq!(take(Some([9, 0])).taken.len(), 7);
        });
    }

    #[test]
    fn a_change_that_concerns_all_held_messages_has_them_examined_again() {
        run(&[message(0, 1), message(0, 2), Message::Resign], [0, 0], |take| assert_eq!(take(None).looks, 5));
    }
}
