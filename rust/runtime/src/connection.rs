// SPDX-License-Identifier: Apache-2.0
//! One TCP connection with its two buffers.
//!
//! A connection knows bytes and no messages. It reads once at a time, so that a fast peer cannot keep an event loop
//! from its other work, and only when a wait has reported input; it writes as much as the system takes.

use lf_wire::{InBuffer, OutBuffer, Storage};

use crate::platform::{Interest, Platform, SocketId, Transfer};

/// A connection, or a slot for one: its socket, while there is one, and its buffers, which the next connection reuses.
#[derive(Debug)]
pub(crate) struct Connection<'s> {
    socket: Option<SocketId>,
    /// Received bytes that are not handled yet.
    pub(crate) input: InBuffer<&'s mut [u8]>,
    /// Bytes to send.
    pub(crate) output: OutBuffer<&'s mut [u8]>,
    /// Whether there may be something to read.
    readable: bool,
    /// Whether nothing more comes.
    ended: bool,
}

/// The outcome of one read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Reading {
    /// Nothing.
    Nothing,
    /// Bytes, which are in the buffer.
    Bytes,
    /// The peer has closed its direction, or the connection broke: nothing more comes after what is in the buffer.
    End,
}

impl<'s> Connection<'s> {
    /// Returns an empty slot with buffers in the owner's memory.
    pub(crate) fn new(input: &'s mut [u8], output: &'s mut [u8]) -> Self {
        let (input, output) = (InBuffer::new(input), OutBuffer::new(output));
        Self { socket: None, input, output, readable: false, ended: false }
    }

    /// Opens the connection; it may have input already.
    pub(crate) fn open(&mut self, socket: SocketId) {
        (self.socket, self.readable, self.ended) = (Some(socket), true, false);
    }

    /// Returns the socket, while the connection is there.
    pub(crate) fn socket(&self) -> Option<SocketId> {
        self.socket
    }

    /// Returns whether nothing more comes, apart from what has come.
    pub(crate) fn has_ended(&self) -> bool {
        self.ended
    }

    /// Marks the connection as readable, though no wait has reported it.
    pub(crate) fn mark_readable(&mut self) {
        self.readable = true;
    }

    /// Returns whether there may be something to read, and forgets it until a wait reports input again.
    pub(crate) fn take_readable(&mut self) -> bool {
        core::mem::take(&mut self.readable)
    }

    /// Returns whether [`Connection::fill`] would read.
    pub(crate) fn is_due(&mut self) -> bool {
        self.readable && !self.ended && self.socket.is_some() && !self.input.space().is_empty()
    }

    /// Reads once, if something may have come and there is space for it.
    pub(crate) fn fill<P: Platform>(&mut self, platform: &mut P) -> Reading {
        let Some(socket) = self.socket.filter(|_| self.readable && !self.ended) else { return Reading::Nothing };
        if self.input.space().is_empty() {
            return Reading::Nothing;
        }
        self.readable = false;
        let reading = read(platform, socket, &mut self.input, usize::MAX);
        self.ended = reading == Reading::End;
        reading
    }

    /// Writes what is pending, as much as the system takes. Returns `false` when the connection is broken.
    pub(crate) fn flush<P: Platform>(&mut self, platform: &mut P) -> bool {
        self.socket.is_none_or(|socket| write(platform, socket, &mut self.output))
    }

    /// Sets what to wait for: bytes, if they are wanted and there is space, and room if something is pending.
    pub(crate) fn set_interest<P: Platform>(&mut self, platform: &mut P, wanted: bool) {
        if let Some(socket) = self.socket {
            let readable = wanted && !self.ended && !self.input.space().is_empty();
            platform.set_interest(socket, Interest { readable, writable: !self.output.is_empty() });
        }
    }

    /// Handles that a wait found this socket ready.
    pub(crate) fn handle_ready(&mut self, ready: SocketId, interest: Interest) {
        self.readable |= self.socket == Some(ready) && interest.readable;
    }

    /// Closes the socket, if there is one, and clears the state of the connection.
    pub(crate) fn close<P: Platform>(&mut self, platform: &mut P) {
        if let Some(socket) = self.socket.take() {
            platform.close(socket);
        }
        (self.readable, self.ended) = (false, false);
        self.input.clear();
        self.output.clear();
    }
}

/// Reads once, at most this many bytes, and no more than there is space for. There has to be some space.
pub(crate) fn read<P: Platform, B: Storage>(
    platform: &mut P,
    socket: SocketId,
    input: &mut InBuffer<B>,
    bytes_max: usize,
) -> Reading {
    let space = input.space();
    let bytes = space.len().min(bytes_max);
    match platform.read(socket, space.get_mut(..bytes).unwrap_or_default()) {
        Ok(Transfer::Bytes(count)) => {
            input.filled(count);
            Reading::Bytes
        }
        Ok(Transfer::WouldBlock) => Reading::Nothing,
        Ok(Transfer::Closed) | Err(_) => Reading::End,
    }
}

/// Writes what is pending, as much as the system takes; bounded by the size of the buffer. Returns `false` when the
/// connection is broken: reading finds its end, after the peer's last messages.
pub(crate) fn write<P: Platform, B: Storage>(platform: &mut P, socket: SocketId, output: &mut OutBuffer<B>) -> bool {
    while !output.is_empty() {
        match platform.write(socket, output.pending()) {
            Ok(Transfer::Bytes(count)) => output.consume(count),
            Ok(Transfer::WouldBlock) => break,
            Ok(Transfer::Closed) | Err(_) => return false,
        }
    }
    true
}
