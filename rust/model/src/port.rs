// SPDX-License-Identifier: Apache-2.0
//! Ports, which store the values of a tag.
use core::fmt;

use heapless::vec::VecStorage;

use crate::cell::{Readable, TriggerCell, Undelivered, cell_by_view, mode_by_view};
use crate::modes::ModeCell;
use crate::payload::{Native, Payload, PayloadError, Serializer};
use crate::queue::{Event, Full, Owned, Queue, View};
use crate::tables::PortId;
use crate::time::Tag;

/// A port: a value, if one has been set at the current tag. Bodies see `&Port<T>`, and effects as `&mut Port<T>`.
pub struct Port<T> {
    pub(crate) id: PortId,
    pub(crate) value: Option<T>,
}

impl<T> Port<T> {
    /// Returns an empty port; generated code makes one per entry of [`Tables::ports`](crate::Tables::ports).
    pub const fn new(id: PortId) -> Self {
        Self { id, value: None }
    }

    /// Drops the value, for [`Program::clear_port`](crate::Program::clear_port).
    pub fn clear(&mut self) {
        self.value = None;
    }

    /// Takes the value out, for ports whose values are stored elsewhere.
    #[doc(hidden)]
    pub fn take(&mut self) -> Option<T> {
        self.value.take()
    }
}

impl<T> Port<T> {
    /// Writes the value as bytes, for [`Program::encode`](crate::Program::encode).
    ///
    /// # Errors
    /// When there is no value, or the bytes do not fit.
    pub fn encode(&self, bytes: &mut [u8]) -> Result<usize, PayloadError>
    where
        T: Payload,
    {
        self.encode_by::<Native>(bytes)
    }

    /// Writes the value by a serializer.
    ///
    /// # Errors
    /// Those of [`encode`](Self::encode).
    pub fn encode_by<S: Serializer<T>>(&self, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        match &self.value {
            Some(value) => S::encode(value, bytes),
            None => Err(PayloadError::Absent),
        }
    }
}

impl<T: fmt::Debug> fmt::Debug for Port<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Port").field(&self.value).finish()
    }
}

impl<T> Readable for Port<T> {
    type Value = T;
    fn is_present(&self) -> bool {
        self.value.is_some()
    }
    fn value(&self) -> Option<&T> {
        self.value.as_ref()
    }
}

/// A port with the queue that fills it: the end of a connection with `after`, or of one from another federate.
///
/// Generated code makes a `QueuedPort<T, N>` per trigger of these kinds, instead of the `Port<T>` of the port that the
/// trigger fills, and passes [`port`](Self::port) to reactions. `N` is the connection's capacity from the plan.
pub type QueuedPort<T, const N: usize> = QueuedPortInner<T, Owned<T, N>>;

/// A [`QueuedPort`] of any capacity.
pub struct QueuedPortInner<T, S: VecStorage<Event<T>> + ?Sized = View<T>> {
    /// The port that it fills.
    pub port: Port<T>,
    queue: Queue<T, S>,
}

impl<T, const N: usize> QueuedPort<T, N> {
    /// Returns an empty port with an empty queue; `port` is the id of the port that it fills.
    pub const fn new(port: PortId) -> Self {
        Self { port: Port::new(port), queue: Queue::new() }
    }

    /// Copies the value of the connection's source, to arrive at `tag` or, when another one does, a microstep later.
    ///
    /// # Errors
    /// When the queue is full.
    pub fn capture(&mut self, tag: Tag, source: &Port<T>) -> Result<(), Full>
    where
        T: Clone,
    {
        match &source.value {
            Some(value) => self.view().queue.insert(tag, value.clone()).map(|_| ()),
            None => Ok(()),
        }
    }

    /// Takes a message from another federate, to arrive at `tag` or, when another one does, a microstep later.
    ///
    /// # Errors
    /// When the queue is full, or the bytes are not a value.
    pub fn deliver(&mut self, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered>
    where
        T: Payload,
    {
        self.deliver_by::<Native>(tag, bytes)
    }

    /// Takes a message by a serializer.
    ///
    /// # Errors
    /// Those of [`deliver`](Self::deliver).
    pub fn deliver_by<S: Serializer<T>>(&mut self, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
        self.put(tag, || S::decode(bytes))
    }

    /// Takes the value of a function, which is called if there is room for it.
    #[doc(hidden)]
    pub fn put(&mut self, tag: Tag, value: impl FnOnce() -> Result<T, PayloadError>) -> Result<(), Undelivered> {
        self.view().put(tag, value)
    }

    fn view(&mut self) -> &mut QueuedPortInner<T> {
        self
    }
}

cell_by_view!(QueuedPort, QueuedPortInner, T);
mode_by_view!(QueuedPort, QueuedPortInner, T);

impl<T> ModeCell for QueuedPortInner<T> {
    fn shift(&mut self, from: Tag, to: Tag) -> Option<Tag> {
        self.queue.shift(from, to);
        self.queue.first_tag()
    }
    fn discard(&mut self) {
        self.queue.clear();
    }
}

impl<T> QueuedPortInner<T> {
    fn put(&mut self, tag: Tag, value: impl FnOnce() -> Result<T, PayloadError>) -> Result<(), Undelivered> {
        if !self.queue.has_room() {
            return Err(Undelivered::Full(Full { capacity: self.queue.capacity() }));
        }
        let value = value().map_err(Undelivered::Payload)?;
        self.queue.insert(tag, value).map(|_| ()).map_err(Undelivered::Full)
    }
}

impl<T> TriggerCell for QueuedPortInner<T> {
    fn activate(&mut self, tag: Tag) -> Option<Tag> {
        self.port.value = self.queue.pop_until(tag);
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
}
