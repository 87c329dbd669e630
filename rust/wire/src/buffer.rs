// SPDX-License-Identifier: Apache-2.0
//! Buffers between a byte stream and its messages. They use their owner's memory: a `&mut [u8]`, an array, or a
//! `Vec<u8>`.
//!
//! Both keep their bytes contiguous and move them to the front only when the room behind them does not suffice: at most
//! once between two calls of `consume`.
//!
//! In [`Storage`] that can grow, a buffer has the length of its content, not of the longest message that can come.

use lf_derive::outlined;

use core::fmt;

use crate::NoRoom;

/// Memory of a buffer that may be able to grow: an owner with a heap implements it on a `Vec`; slices and arrays do not
/// grow.
pub trait Storage: AsRef<[u8]> + AsMut<[u8]> {
    /// Returns its length while no single message needs more; memory beyond it is released.
    fn bytes_usual(&self) -> usize {
        self.as_ref().len()
    }

    /// Returns its maximum length. Growing to it may still fail.
    fn bytes_max(&self) -> usize {
        self.as_ref().len()
    }

    /// Makes it `bytes` long, which is longer than it is; its bytes stay. Returns `false` if that is impossible:
    /// nothing has changed then.
    fn grow(&mut self, bytes: usize) -> bool {
        let _ = bytes;
        false
    }

    /// Releases what exceeds the usual length. The bytes have no meaning any more.
    fn shrink(&mut self) {}
}

impl Storage for &mut [u8] {}

impl<const N: usize> Storage for [u8; N] {}

/// Contiguous bytes, somewhere in the storage. Shared by both buffers.
struct Span<B> {
    storage: B,
    /// The beginning of the bytes. `start <= end <= capacity` always holds, and `start == end` only at 0.
    start: usize,
    /// The end of the bytes.
    end: usize,
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> Span<B> {
    fn capacity(&self) -> usize {
        self.storage.as_ref().len()
    }

    fn len(&self) -> usize {
        self.end - self.start
    }

    fn bytes(&self) -> &[u8] {
        self.storage.as_ref().get(self.start..self.end).unwrap_or_default()
    }

    /// Returns the storage behind the bytes.
    fn tail(&mut self) -> &mut [u8] {
        self.storage.as_mut().get_mut(self.end..).unwrap_or_default()
    }

    /// Appends `n` bytes of the tail to the bytes; at most the whole tail.
    #[outlined]
    fn extend(&mut self, n: usize) {
        self.end += n.min(self.capacity().saturating_sub(self.end));
    }

    /// Drops `n` bytes at the front; at most all.
    fn consume(&mut self, n: usize) {
        self.start += n.min(self.len());
        if self.start == self.end {
            (self.start, self.end) = (0, 0);
        }
    }

    /// Drops `n` bytes behind the first `offset` ones, which move up to close the gap; at most all.
    fn remove(&mut self, offset: usize, n: usize) {
        let offset = offset.min(self.len());
        let n = n.min(self.len() - offset);
        let (start, end) = (self.start, self.end);
        if let Some(bytes) = self.storage.as_mut().get_mut(start..end) {
            bytes.copy_within(..offset, n);
        }
        self.consume(n);
    }

    /// Moves the bytes to the front of the storage.
    fn compact(&mut self) {
        if self.start > 0 {
            if let Some(front) = self.storage.as_mut().get_mut(..self.end) {
                front.copy_within(self.start.., 0);
            }
            (self.start, self.end) = (0, self.len());
        }
    }

    /// Moves the bytes to other storage and returns the old one; if they do not fit, returns the other one.
    fn replace(&mut self, mut storage: B) -> Result<B, B> {
        let bytes = self.bytes();
        match storage.as_mut().get_mut(..bytes.len()) {
            Some(front) => front.copy_from_slice(bytes),
            None => return Err(storage),
        }
        self.end = self.len();
        self.start = 0;
        Ok(core::mem::replace(&mut self.storage, storage))
    }
}

impl<B: Storage> Span<B> {
    /// Releases memory if there are no bytes, and more than usual.
    fn shrink(&mut self) {
        if self.start == self.end && self.capacity() > self.storage.bytes_usual() {
            self.storage.shrink();
        }
    }

    /// Makes the storage longer, with the bytes at its front. Returns `false` if that is impossible.
    fn grow(&mut self, bytes: usize) -> bool {
        self.compact();
        bytes > self.capacity() && bytes <= self.storage.bytes_max() && self.storage.grow(bytes)
    }
}

/// Received bytes that are not consumed yet. The owner reads from its socket into [`space`](Self::space), reports the
/// number of bytes to [`filled`](Self::filled), takes messages with `next`, and drops each with
/// [`consume`](Self::consume).
///
/// A message that is not consumed stays the next one; an owner that cannot handle it just does not read.
pub struct InBuffer<B>(Span<B>);

impl<B: AsRef<[u8]> + AsMut<[u8]>> InBuffer<B> {
    /// Returns an empty buffer in `storage`, all of which it uses. It must hold the longest message that can come, or
    /// be able to grow so far.
    pub const fn new(storage: B) -> Self {
        Self(Span { storage, start: 0, end: 0 })
    }

    /// Returns the capacity in bytes.
    pub fn capacity(&self) -> usize {
        self.0.capacity()
    }

    /// Returns the received bytes that are not consumed yet.
    pub fn bytes(&self) -> &[u8] {
        self.0.bytes()
    }

    /// Returns the space for the next bytes. Empty only if the buffer is full of unconsumed bytes.
    pub fn space(&mut self) -> &mut [u8] {
        // Moving pays when it gains at least as much room as it moves bytes; otherwise it waits until it must.
        if self.0.start >= self.0.len() || self.0.tail().is_empty() {
            self.0.compact();
        }
        self.0.tail()
    }

    /// Records that the first `n` bytes of [`space`](Self::space) have been filled; at most all.
    pub fn filled(&mut self, n: usize) {
        self.0.extend(n);
    }

    /// Drops the first `n` bytes; at most all.
    pub fn consume(&mut self, n: usize) {
        self.0.consume(n);
    }

    /// Drops `n` bytes behind the first `offset` ones, which stay; at most all. For owners that can handle a message
    /// though one before it has to wait. Costs a move of the first `offset` bytes.
    pub fn remove(&mut self, offset: usize, n: usize) {
        self.0.remove(offset, n);
    }

    /// Drops all bytes, for a connection that begins anew.
    pub fn clear(&mut self) {
        self.0.consume(usize::MAX);
    }

    /// Moves the bytes to other storage, for owners that can grow, and returns the old one.
    ///
    /// # Errors
    /// Returns `storage` if the bytes do not fit there.
    pub fn replace(&mut self, storage: B) -> Result<B, B> {
        self.0.replace(storage)
    }
}

impl<B: Storage> InBuffer<B> {
    /// Returns the maximum capacity in bytes.
    pub fn capacity_max(&self) -> usize {
        self.0.storage.bytes_max()
    }

    /// Makes space for an incomplete message at the front that has `needed` bytes or more. Returns `false` if there is
    /// no space and the storage cannot grow.
    ///
    /// A full buffer becomes at most twice as long. So its length depends on the received bytes, not on an announced
    /// length.
    pub fn make_space_for(&mut self, needed: usize) -> bool {
        let capacity = self.capacity();
        if self.0.len() < capacity {
            return true;
        }
        // Not byte by byte for callers that know only that one more is needed.
        let least = capacity.saturating_add(capacity / 4);
        let bytes = needed.max(least).min(capacity.saturating_mul(2).max(1)).min(self.capacity_max());
        self.0.grow(bytes)
    }

    /// Releases what exceeds the usual length, if the buffer is empty.
    pub fn shrink(&mut self) {
        self.0.shrink();
    }
}

/// Bytes of pushed messages that are not sent yet. The owner writes [`pending`](Self::pending) to its socket and
/// reports the number of written bytes to [`consume`](Self::consume).
pub struct OutBuffer<B>(Span<B>);

impl<B: AsRef<[u8]> + AsMut<[u8]>> OutBuffer<B> {
    /// Returns an empty buffer in `storage`, all of which it uses.
    pub const fn new(storage: B) -> Self {
        Self(Span { storage, start: 0, end: 0 })
    }

    /// Returns the capacity in bytes.
    pub fn capacity(&self) -> usize {
        self.0.capacity()
    }

    /// Returns the number of bytes that can be pushed now. A message fits if its `encoded_len` is not more.
    pub fn room(&self) -> usize {
        self.0.capacity().saturating_sub(self.0.len())
    }

    /// Returns the bytes to send, all contiguous.
    pub fn pending(&self) -> &[u8] {
        self.0.bytes()
    }

    /// Returns whether there is nothing to send.
    pub fn is_empty(&self) -> bool {
        self.0.len() == 0
    }

    /// Records that the first `n` bytes of [`pending`](Self::pending) have been sent. Drops at most all.
    pub fn consume(&mut self, n: usize) {
        self.0.consume(n);
    }

    /// Drops all bytes, for a connection that begins anew.
    pub fn clear(&mut self) {
        self.0.consume(usize::MAX);
    }

    /// Pushes bytes of complete messages.
    ///
    /// # Errors
    /// [`NoRoom`] if they do not fit; nothing has been pushed then.
    pub fn push_bytes(&mut self, bytes: &[u8]) -> Result<(), NoRoom> {
        self.claim(bytes.len())?.copy_from_slice(bytes);
        self.commit(bytes.len());
        Ok(())
    }

    /// Moves the bytes to other storage, for owners that can grow, and returns the old one.
    ///
    /// # Errors
    /// Returns `storage` if the bytes do not fit there.
    pub fn replace(&mut self, storage: B) -> Result<B, B> {
        self.0.replace(storage)
    }

    /// Returns the next `len` bytes, to be written and then committed.
    pub(crate) fn claim(&mut self, len: usize) -> Result<&mut [u8], NoRoom> {
        let room = self.room();
        if self.0.tail().len() < len && len <= room {
            self.0.compact();
        }
        self.0.tail().get_mut(..len).ok_or(NoRoom { needed: len, room })
    }

    /// Makes the first `len` claimed bytes pending.
    pub(crate) fn commit(&mut self, len: usize) {
        self.0.extend(len);
    }
}

impl<B: Storage> OutBuffer<B> {
    /// Returns the maximum capacity in bytes.
    pub fn capacity_max(&self) -> usize {
        self.0.storage.bytes_max()
    }

    /// Returns the number of bytes that may be pushed now, after [`make_room`](Self::make_room): the longest message if
    /// nothing is pending, and otherwise the rest of the usual length.
    pub fn room_max(&self) -> usize {
        let storage = &self.0.storage;
        match self.0.len() {
            0 => storage.bytes_max(),
            pending => storage.bytes_usual().saturating_sub(pending),
        }
    }

    /// Makes room for `len` bytes, in longer storage if necessary. Returns `false` if that is impossible.
    pub fn make_room(&mut self, len: usize) -> bool {
        let capacity = self.capacity();
        if self.room() >= len {
            return true;
        }
        // Not message by message.
        let ahead = capacity.saturating_mul(2).min(self.0.storage.bytes_usual());
        self.0.grow(self.0.len().saturating_add(len).max(ahead))
    }

    /// Releases what exceeds the usual length, if the buffer is empty.
    pub fn shrink(&mut self) {
        self.0.shrink();
    }
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> fmt::Debug for InBuffer<B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("InBuffer").field("bytes", &self.bytes()).field("capacity", &self.capacity()).finish()
    }
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> fmt::Debug for OutBuffer<B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OutBuffer").field("pending", &self.pending()).field("capacity", &self.capacity()).finish()
    }
}
