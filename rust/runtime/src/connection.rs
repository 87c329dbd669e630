// SPDX-License-Identifier: Apache-2.0
//! One TCP connection with its two buffers.

use lf_wire::{InBuffer, OutBuffer};

use crate::federate::{Inbound, Outbound, Peers};
use crate::platform::{Interest, NetError, Platform, SocketId, Transfer};

/// Buffers that a connection uses as long as it lasts, and the next connection after it.
#[derive(Debug)]
pub struct Buffers<'s> {
    /// What has come and is not handled yet. It must hold the longest message that can come.
    pub input: InBuffer<&'s mut [u8]>,
    /// What is to be sent. It must hold the longest message that can be sent, and control messages beside it.
    pub output: OutBuffer<&'s mut [u8]>,
    /// Of a federate: the connections with others, past the RTI.
    pub(crate) peers: Peers<'s>,
}

impl<'s> Buffers<'s> {
    /// Empty buffers in the owner's memory.
    pub fn new(input: &'s mut [u8], output: &'s mut [u8]) -> Self {
        Self { input: InBuffer::new(input), output: OutBuffer::new(output), peers: Peers::default() }
    }

    /// With connections to the federates of [`Federation::peers_out`], in the same order, and as many places for
    /// connections from others as [`Federation::peers_in`] has.
    ///
    /// [`Federation::peers_out`]: crate::Federation::peers_out
    /// [`Federation::peers_in`]: crate::Federation::peers_in
    #[must_use]
    pub fn with_peers(self, outbound: &'s mut [Outbound<'s>], inbound: &'s mut [Inbound<'s>]) -> Self {
        Self { peers: Peers::new(outbound, inbound), ..self }
    }

    /// Forgets what belonged to a connection that has ended.
    pub(crate) fn clear(&mut self) {
        self.input.clear();
        self.output.clear();
    }
}

/// How a connection is after reading.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Reading {
    /// More may come.
    Open,
    /// The peer has closed its direction: nothing more comes after what is in the buffer.
    Ended,
}

impl Buffers<'_> {
    /// Reads once, as much as there is space for.
    ///
    /// One call does one read, so that a fast peer cannot keep the event loop from its other work.
    ///
    /// # Errors
    /// When the connection broke.
    pub(crate) fn fill<P: Platform>(&mut self, platform: &mut P, socket: SocketId) -> Result<Reading, NetError> {
        let space = self.input.space();
        if space.is_empty() {
            return Ok(Reading::Open);
        }
        match platform.read(socket, space)? {
            Transfer::Bytes(count) => {
                self.input.filled(count);
                Ok(Reading::Open)
            }
            Transfer::WouldBlock => Ok(Reading::Open),
            Transfer::Closed => Ok(Reading::Ended),
        }
    }

    /// Writes what is pending, as much as the system takes; bounded by the size of the buffer.
    ///
    /// # Errors
    /// When the connection broke.
    pub(crate) fn flush<P: Platform>(&mut self, platform: &mut P, socket: SocketId) -> Result<(), NetError> {
        while !self.output.is_empty() {
            match platform.write(socket, self.output.pending())? {
                Transfer::Bytes(count) => self.output.consume(count),
                Transfer::WouldBlock => break,
                Transfer::Closed => return Err(NetError::Reset),
            }
        }
        Ok(())
    }

    /// What to wait for: bytes if there is space, and room if something is pending.
    pub(crate) fn interest(&mut self) -> Interest {
        Interest { readable: !self.input.space().is_empty(), writable: !self.output.is_empty() }
    }
}
