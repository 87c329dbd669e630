// SPDX-License-Identifier: Apache-2.0
//! Datagrams of clock synchronization. The event loops read them before anything else, because the time right after
//! that is the one that counts.

use lf_coordination::Endpoint;
use lf_model::time::Instant;
use lf_wire::{Message, MessageType};

use crate::platform::{Interest, Platform, SocketId};

/// One byte more than the longest datagram, so that a longer one is not taken for one.
const BYTES_MAX: usize = MessageType::T4.fixed_bytes() + 1;
/// The maximum number of datagrams to read at a time.
const PER_TURN: usize = 64;

/// The UDP port of an event loop, if it has one.
#[derive(Debug, Default)]
pub(crate) struct DatagramPort {
    socket: Option<SocketId>,
    readable: bool,
}

impl DatagramPort {
    /// Returns the port, if there is one.
    pub(crate) fn new<P: Platform>(platform: &mut P, socket: Option<SocketId>) -> Self {
        if let Some(socket) = socket {
            platform.set_interest(socket, Interest::READ);
        }
        Self { socket, readable: false }
    }

    /// Returns the socket, until it is closed.
    pub(crate) fn socket(&self) -> Option<SocketId> {
        self.socket
    }

    /// Handles that a wait found this socket ready. Returns `true` if it is this one.
    pub(crate) fn handle_ready(&mut self, ready: SocketId) -> bool {
        let is_it = self.socket == Some(ready);
        self.readable |= is_it;
        is_it
    }

    /// Reads the datagrams that have come, a bounded number of them, and passes each to `handle`, with the socket for
    /// an answer, the time after the read, and the sender.
    pub(crate) fn receive<P: Platform>(
        &mut self,
        platform: &mut P,
        mut handle: impl FnMut(&mut P, SocketId, Instant, Endpoint, &[u8]),
    ) {
        let Some(socket) = self.socket.filter(|_| core::mem::take(&mut self.readable)) else { return };
        let mut buffer = [0; BYTES_MAX];
        for _ in 0..PER_TURN {
            // An error of the port belongs to a datagram that was sent; what has come is behind it.
            let received = platform.receive_from(socket, &mut buffer);
            let now = platform.now();
            match received {
                Ok(Some((count, from))) => {
                    handle(platform, socket, now, from, buffer.get(..count).unwrap_or_default());
                }
                Ok(None) => return,
                Err(_) => {}
            }
        }
    }

    /// Closes the port for good.
    pub(crate) fn close<P: Platform>(&mut self, platform: &mut P) {
        if let Some(socket) = self.socket.take() {
            platform.close(socket);
        }
    }
}

/// Sends a message. If it is lost, here or on the way, so is its round.
pub(crate) fn send<P: Platform>(platform: &mut P, socket: SocketId, to: Endpoint, message: &Message<'_>) {
    let mut bytes = [0; BYTES_MAX];
    if let Ok(len) = message.encode(&mut bytes) {
        let _ = platform.send_to(socket, to, bytes.get(..len).unwrap_or_default());
    }
}
