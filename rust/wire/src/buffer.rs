// SPDX-License-Identifier: Apache-2.0
//! Buffers between a byte stream and its messages. They own no memory but what their owner gives them: a
//! `&mut [u8]`, an array, or a `Vec<u8>`.
//!
//! Both keep the bytes that they hold in one piece and move them to the front only when the room behind them does not
//! suffice: at most once between two calls of `consume`.
//!
//! In [`Storage`] that can grow, a buffer is as long as what it has to hold, not as the longest that can come.

use core::fmt;

use crate::NoRoom;

/// Memory of a buffer that may be able to grow: not a slice or an array, but what owners with a heap make of a `Vec`.
pub trait Storage: AsRef<[u8]> + AsMut<[u8]> {
    /// How many bytes it has as long as no single message needs more; memory beyond them is given back.
    fn bytes_usual(&self) -> usize {
        self.as_ref().len()
    }

    /// How many bytes it can have at most. They may still be refused.
    fn bytes_max(&self) -> usize {
        self.as_ref().len()
    }

    /// Makes it `bytes` long, which is longer than it is; the bytes that there are stay. `false` if it cannot be:
    /// nothing has changed then.
    fn grow(&mut self, bytes: usize) -> bool {
        let _ = bytes;
        false
    }

    /// Gives back what it has beyond the usual. What the bytes are is of no interest any more.
    fn shrink(&mut self) {}
}

impl Storage for &mut [u8] {}

impl<const N: usize> Storage for [u8; N] {}

/// Bytes in one piece, somewhere in the storage. Shared by both buffers.
struct Span<B> {
    storage: B,
    /// Where the bytes begin. `start <= end <= capacity` always holds, and `start == end` only at 0.
    start: usize,
    /// Where they end.
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

    /// The storage behind the bytes.
    fn tail(&mut self) -> &mut [u8] {
        self.storage.as_mut().get_mut(self.end..).unwrap_or_default()
    }

    /// Takes `n` bytes of the tail to the bytes; no more than the tail has.
    #[cfg_attr(target_pointer_width = "32", inline(never))]
    fn extend(&mut self, n: usize) {
        self.end += n.min(self.capacity().saturating_sub(self.end));
    }

    /// Drops `n` bytes at the front; no more than there are.
    fn consume(&mut self, n: usize) {
        self.start += n.min(self.len());
        if self.start == self.end {
            (self.start, self.end) = (0, 0);
        }
    }

    /// Drops `n` bytes behind the first `offset` ones, which move up to close the gap; no more than there are.
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
    /// Gives back memory if there are no bytes, and more than usual.
    fn shrink(&mut self) {
        if self.start == self.end && self.capacity() > self.storage.bytes_usual() {
            self.storage.shrink();
        }
    }

    /// Makes the storage longer, with the bytes at its front. `false` if it cannot be.
    fn grow(&mut self, bytes: usize) -> bool {
        self.compact();
        bytes > self.capacity() && bytes <= self.storage.bytes_max() && self.storage.grow(bytes)
    }
}

/// Bytes received and not yet consumed. The owner reads from its socket into [`space`](Self::space), says with
/// [`filled`](Self::filled) how much came, takes messages with `next`, and drops each with
/// [`consume`](Self::consume).
///
/// A message that is not consumed stays the next one; as long as its owner cannot handle it, it just does not read.
pub struct InBuffer<B>(Span<B>);

impl<B: AsRef<[u8]> + AsMut<[u8]>> InBuffer<B> {
    /// An empty buffer in `storage`, all of which it uses. It must hold the longest message that can come, or be able
    /// to grow so far.
    pub const fn new(storage: B) -> Self {
        Self(Span { storage, start: 0, end: 0 })
    }

    /// Bytes that the buffer can hold.
    pub fn capacity(&self) -> usize {
        self.0.capacity()
    }

    /// Bytes received and not yet consumed.
    pub fn bytes(&self) -> &[u8] {
        self.0.bytes()
    }

    /// Where to put the bytes that come next. Empty only if the buffer is full of unconsumed bytes.
    pub fn space(&mut self) -> &mut [u8] {
        // Moving is paid for when it gains at least as much room as it moves bytes; otherwise it waits until it must.
        if self.0.start >= self.0.len() || self.0.tail().is_empty() {
            self.0.compact();
        }
        self.0.tail()
    }

    /// Says that the first `n` bytes of [`space`](Self::space) have been filled. No more are taken than it has.
    pub fn filled(&mut self, n: usize) {
        self.0.extend(n);
    }

    /// Drops the first `n` bytes; no more than there are.
    pub fn consume(&mut self, n: usize) {
        self.0.consume(n);
    }

    /// Drops `n` bytes behind the first `offset` ones, which stay; no more than there are. For owners that can handle
    /// a message though one before it has to wait. Costs a move of the first `offset` bytes.
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
    /// How many bytes the buffer can hold at most.
    pub fn capacity_max(&self) -> usize {
        self.0.storage.bytes_max()
    }

    /// Makes space for a message at the front that is not whole and has `needed` bytes or more. `false` if there is no
    /// space and none can be had.
    ///
    /// A full buffer becomes at most twice as long. So its length depends on how much has come, not on what was
    /// announced.
    pub fn make_space_for(&mut self, needed: usize) -> bool {
        let capacity = self.capacity();
        if self.0.len() < capacity {
            return true;
        }
        // Not byte by byte for those who know only that one more is needed.
        let least = capacity.saturating_add(capacity / 4);
        let bytes = needed.max(least).min(capacity.saturating_mul(2).max(1)).min(self.capacity_max());
        self.0.grow(bytes)
    }

    /// Gives back what the storage has beyond the usual, if the buffer is empty.
    pub fn shrink(&mut self) {
        self.0.shrink();
    }
}

/// Bytes of messages pushed and not yet sent. The owner writes [`pending`](Self::pending) to its socket and says with
/// [`consume`](Self::consume) how much went.
pub struct OutBuffer<B>(Span<B>);

impl<B: AsRef<[u8]> + AsMut<[u8]>> OutBuffer<B> {
    /// An empty buffer in `storage`, all of which it uses.
    pub const fn new(storage: B) -> Self {
        Self(Span { storage, start: 0, end: 0 })
    }

    /// Bytes that the buffer can hold.
    pub fn capacity(&self) -> usize {
        self.0.capacity()
    }

    /// Bytes that can be pushed now. A message fits if its `encoded_len` is not more.
    pub fn room(&self) -> usize {
        self.0.capacity().saturating_sub(self.0.len())
    }

    /// Bytes to send, all in one piece.
    pub fn pending(&self) -> &[u8] {
        self.0.bytes()
    }

    /// Whether there is nothing to send.
    pub fn is_empty(&self) -> bool {
        self.0.len() == 0
    }

    /// Says that the first `n` bytes of [`pending`](Self::pending) have been sent. No more are dropped than there are.
    pub fn consume(&mut self, n: usize) {
        self.0.consume(n);
    }

    /// Drops all bytes, for a connection that begins anew.
    pub fn clear(&mut self) {
        self.0.consume(usize::MAX);
    }

    /// Pushes bytes that are whole messages already.
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

    /// The next `len` bytes, to be written and then committed.
    pub(crate) fn claim(&mut self, len: usize) -> Result<&mut [u8], NoRoom> {
        let room = self.room();
        if self.0.tail().len() < len && len <= room {
            self.0.compact();
        }
        self.0.tail().get_mut(..len).ok_or(NoRoom { needed: len, room })
    }

    /// Makes the first `len` bytes that were claimed pending.
    pub(crate) fn commit(&mut self, len: usize) {
        self.0.extend(len);
    }
}

impl<B: Storage> OutBuffer<B> {
    /// How many bytes the buffer can hold at most.
    pub fn capacity_max(&self) -> usize {
        self.0.storage.bytes_max()
    }

    /// How many bytes may be pushed now, after [`make_room`](Self::make_room): the longest message if nothing is
    /// pending, and otherwise what is left of the usual length.
    pub fn room_max(&self) -> usize {
        let storage = &self.0.storage;
        match self.0.len() {
            0 => storage.bytes_max(),
            pending => storage.bytes_usual().saturating_sub(pending),
        }
    }

    /// Sees to it that there is room for `len` bytes, in longer storage if need be. `false` if that cannot be had.
    pub fn make_room(&mut self, len: usize) -> bool {
        let capacity = self.capacity();
        if self.room() >= len {
            return true;
        }
        // Not message by message.
        let ahead = capacity.saturating_mul(2).min(self.0.storage.bytes_usual());
        self.0.grow(self.0.len().saturating_add(len).max(ahead))
    }

    /// Gives back what the storage has beyond the usual, if the buffer is empty.
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
