// SPDX-License-Identifier: Apache-2.0
//! The pending events of one trigger, in order of tag, no two at the same.
use heapless::deque::DequeInner;
use heapless::vec::{OwnedVecStorage, VecStorage, ViewVecStorage};

use crate::time::Tag;

/// One pending event.
#[derive(Clone, Debug)]
pub struct Event<T> {
    pub(crate) tag: Tag,
    pub(crate) value: T,
}

/// Storage for `N` events of values `T`.
pub type Owned<T, const N: usize> = OwnedVecStorage<Event<T>, N>;
/// Borrowed storage for events of values `T`, so that code exists once for all capacities.
pub type View<T> = ViewVecStorage<Event<T>>;

/// A queue is full; it holds this many events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Full {
    /// The queue's capacity in events.
    pub capacity: usize,
}

pub(crate) struct Queue<T, S: VecStorage<Event<T>> + ?Sized = View<T>>(DequeInner<Event<T>, S>);

impl<T, const N: usize> Queue<T, Owned<T, N>> {
    pub(crate) const fn new() -> Self {
        Self(heapless::Deque::new())
    }
}

impl<T> Queue<T> {
    pub(crate) fn capacity(&self) -> usize {
        self.0.storage_capacity()
    }

    pub(crate) fn has_room(&self) -> bool {
        !self.0.is_full()
    }

    pub(crate) fn first_tag(&self) -> Option<Tag> {
        self.0.front().map(|event| event.tag)
    }

    pub(crate) fn iter(&self) -> impl DoubleEndedIterator<Item = &Event<T>> {
        self.0.iter()
    }

    pub(crate) fn contains(&self, tag: Tag) -> bool {
        self.0.iter().rev().take_while(|event| event.tag >= tag).any(|event| event.tag == tag)
    }

    pub(crate) fn value_at(&mut self, tag: Tag) -> Option<&mut T> {
        self.0.iter_mut().rev().find(|event| event.tag == tag).map(|event| &mut event.value)
    }

    /// Adds an event at `tag`, or at the first microstep after it that has none; returns the event's tag.
    pub(crate) fn insert(&mut self, mut tag: Tag, value: T) -> Result<Tag, Full> {
        while self.contains(tag) {
            tag = tag.next_microstep();
        }
        if self.0.push_back(Event { tag, value }).is_err() {
            return Err(Full { capacity: self.capacity() });
        }
        // The event moves forward past later ones. Most come in order of tag, and do not move at all.
        let mut at = self.0.storage_len() - 1;
        while at > 0 && self.0.get(at - 1).is_some_and(|before| before.tag > tag) {
            self.0.swap(at - 1, at);
            at -= 1;
        }
        Ok(tag)
    }

    /// Removes the event at `tag`.
    pub(crate) fn remove(&mut self, tag: Tag) {
        self.0.retain(|event| event.tag != tag);
    }

    /// Moves all events: their distance from `to` becomes that from `from`.
    pub(crate) fn shift(&mut self, from: Tag, to: Tag) {
        self.0.iter_mut().for_each(|event| event.tag = event.tag.moved(from, to));
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// Takes the earliest event, if it is at `tag` or before.
    pub(crate) fn pop_until(&mut self, tag: Tag) -> Option<T> {
        self.0.pop_front_if(|event| event.tag <= tag).map(|event| event.value)
    }
}
