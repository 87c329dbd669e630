// SPDX-License-Identifier: Apache-2.0
//! Inputs whose messages can come after their tag. A tardy message takes effect later than intended, and has its
//! intended tag.
use heapless::vec::VecStorage;

use crate::cell::{Placed, TriggerCell, Undelivered, cell_by_view};
use crate::payload::{Native, Payload, PayloadError, Serializer};
use crate::port::Port;
use crate::queue::{Event, Full, Owned, Queue, View};
use crate::tables::PortId;
use crate::time::Tag;

/// A value with its intended tag.
#[derive(Clone, Debug)]
pub struct Intended<T> {
    /// The tag of the event, unless it is tardy.
    intended: Tag,
    value: T,
}

/// A port with the queue that fills it: the end of a connection from another federate whose messages can be tardy.
///
/// Generated code makes a `TardyInput<T, N>` instead of the [`QueuedPort`](crate::QueuedPort) of an input with
/// [`NetworkInput::tardy`](crate::NetworkInput::tardy).
pub type TardyInput<T, const N: usize> = TardyInputInner<T, Owned<Intended<T>, N>>;

/// A [`TardyInput`] of any capacity.
pub struct TardyInputInner<T, S: VecStorage<Event<Intended<T>>> + ?Sized = View<Intended<T>>> {
    /// The port that it fills.
    pub port: Port<T>,
    /// The intended tag of the port's value, if it is tardy.
    intended: Option<Tag>,
    queue: Queue<Intended<T>, S>,
}

impl<T, const N: usize> TardyInput<T, N> {
    /// Returns an empty port with an empty queue; `port` is the id of the port that it fills.
    pub const fn new(port: PortId) -> Self {
        Self { port: Port::new(port), intended: None, queue: Queue::new() }
    }

    /// Takes a message from another federate, to take effect at `tag`; it is tardy if that is later than `intended`.
    ///
    /// It takes effect later if another one has that tag; a tardy one, after all messages in the queue. If it has to
    /// give way to a tardy one, it is tardy itself.
    ///
    /// # Errors
    /// When the queue is full, or the bytes are not a value.
    pub fn deliver_tardy(&mut self, tag: Tag, intended: Tag, bytes: &[u8]) -> Result<Placed, Undelivered>
    where
        T: Payload,
    {
        self.deliver_tardy_by::<Native>(tag, intended, bytes)
    }

    /// Takes a message by a serializer.
    ///
    /// # Errors
    /// Those of [`deliver_tardy`](Self::deliver_tardy).
    pub fn deliver_tardy_by<S: Serializer<T>>(
        &mut self,
        tag: Tag,
        intended: Tag,
        bytes: &[u8],
    ) -> Result<Placed, Undelivered> {
        self.put(tag, intended, || S::decode(bytes))
    }

    /// Takes the value of a function, which is called if there is room for it.
    #[doc(hidden)]
    pub fn put(
        &mut self,
        tag: Tag,
        intended: Tag,
        value: impl FnOnce() -> Result<T, PayloadError>,
    ) -> Result<Placed, Undelivered> {
        (self as &mut TardyInputInner<T>).put(tag, intended, value)
    }

    /// Takes a message that is in time.
    ///
    /// # Errors
    /// When the queue is full, or the bytes are not a value.
    pub fn deliver(&mut self, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered>
    where
        T: Payload,
    {
        self.deliver_by::<Native>(tag, bytes)
    }

    /// Takes a message that is in time by a serializer.
    ///
    /// # Errors
    /// Those of [`deliver`](Self::deliver).
    pub fn deliver_by<S: Serializer<T>>(&mut self, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
        self.deliver_tardy_by::<S>(tag, tag, bytes).map(|_| ())
    }
}

cell_by_view!(TardyInput, TardyInputInner, T);

impl<T> TardyInputInner<T> {
    fn put(
        &mut self,
        tag: Tag,
        intended: Tag,
        value: impl FnOnce() -> Result<T, PayloadError>,
    ) -> Result<Placed, Undelivered> {
        if !self.queue.has_room() {
            return Err(Undelivered::Full(Full { capacity: self.queue.capacity() }));
        }
        let value = value().map_err(Undelivered::Payload)?;
        let is_late = intended < tag;
        // It comes after earlier messages, if these have become late.
        let is_before = |event: &&Event<Intended<T>>| is_late || event.value.intended < event.tag;
        let before = self.queue.iter().rev().find(is_before).map(|event| event.tag).filter(|before| *before >= tag);
        let tardy = is_late || before.is_some();
        let mut at = before.map_or(tag, Tag::next_microstep);
        while self.queue.contains(at) {
            at = at.next_microstep();
        }
        let intended = if tardy { intended } else { at };
        self.queue.insert(at, Intended { intended, value }).map_err(Undelivered::Full)?;
        Ok(Placed { tag: at, tardy })
    }
}

impl<T> TriggerCell for TardyInputInner<T> {
    fn activate(&mut self, tag: Tag) -> Option<Tag> {
        let meant = self.queue.pop_until(tag);
        self.intended = meant.as_ref().map(|meant| meant.intended).filter(|intended| *intended < tag);
        self.port.value = meant.map(|meant| meant.value);
        self.queue.first_tag()
    }

    /// Does nothing: the engine clears the port as a port.
    fn clear(&mut self) {}

    fn pending(&self) -> Option<Tag> {
        self.queue.first_tag()
    }

    fn has_room(&self) -> bool {
        self.queue.has_room()
    }

    fn intended(&self) -> Option<Tag> {
        self.intended
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;
    use crate::time::{Instant, Microstep};

    fn tag(time: i64, microstep: u32) -> Tag {
        Tag::new(Instant::from_nanos(time), Microstep(microstep))
    }

    fn bytes(value: u32) -> [u8; 4] {
        value.to_le_bytes()
    }

    #[test]
    fn a_message_that_gives_way_to_a_tardy_one_is_tardy_too() {
        let mut input = TardyInput::<u32, 4>::new(PortId(0));
        let late = input.deliver_tardy(tag(5, 1), tag(3, 0), &bytes(1)).expect("there is room");
        assert_eq!(late, Placed { tag: tag(5, 1), tardy: true });
        let displaced = input.deliver_tardy(tag(5, 1), tag(5, 1), &bytes(2)).expect("there is room");
        assert_eq!(displaced, Placed { tag: tag(5, 2), tardy: true });
        assert_eq!(TriggerCell::activate(&mut input, tag(5, 1)), Some(tag(5, 2)));
        assert_eq!((input.port.value, TriggerCell::intended(&input)), (Some(1), Some(tag(3, 0))));
        assert_eq!(TriggerCell::activate(&mut input, tag(5, 2)), None);
        assert_eq!((input.port.value, TriggerCell::intended(&input)), (Some(2), Some(tag(5, 1))));
    }

    #[test]
    fn a_message_that_gives_way_to_one_in_time_is_in_time() {
        let mut input = TardyInput::<u32, 4>::new(PortId(0));
        for microstep in 0..2 {
            let placed = input.deliver_tardy(tag(5, 0), tag(5, 0), &bytes(microstep)).expect("there is room");
            assert_eq!(placed, Placed { tag: tag(5, microstep), tardy: false });
        }
        assert_eq!(TriggerCell::activate(&mut input, tag(5, 0)), Some(tag(5, 1)));
        TriggerCell::activate(&mut input, tag(5, 1));
        assert_eq!((input.port.value, TriggerCell::intended(&input)), (Some(1), None));
    }

    proptest! {
        /// Messages of one federate take effect in order, however late they come, no two at one tag, and each that does
        /// not take effect at its tag, nor just after others of that tag that were in time, has its intended tag.
        #[test]
        fn messages_keep_their_order(steps in prop::collection::vec((0..4i64, 0..3i64), 1..30)) {
            let mut input = TardyInput::<u32, 32>::new(PortId(0));
            let (mut sent, mut current) = (1, tag(0, 0));
            let mut seen = Vec::new();
            for (number, (ahead, pass)) in (0..).zip(steps) {
                sent += ahead;
                let meant = tag(sent, 0);
                let at = if meant > current { meant } else { current.next_microstep() };
                let placed = input.deliver_tardy(at, meant, &bytes(number)).expect("there is room");
                prop_assert_eq!(placed.tardy, at != meant, "{:?}", placed);
                for _ in 0..pass {
                    let Some(next) = TriggerCell::pending(&input) else { break };
                    prop_assert!(next > current);
                    current = next;
                    TriggerCell::activate(&mut input, current);
                    seen.extend(input.port.value.take());
                }
            }
            while let Some(next) = TriggerCell::pending(&input) {
                TriggerCell::activate(&mut input, next);
                seen.extend(input.port.value.take());
            }
            prop_assert!(seen.is_sorted() && seen.len() == seen.last().map_or(0, |last| *last as usize + 1));
        }
    }
}
