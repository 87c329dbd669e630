// SPDX-License-Identifier: Apache-2.0
//! Clock synchronization over UDP: datagrams are read before anything else, for the time right after that is the one
//! that counts.

use lf_coordination::Deadline;
use lf_coordination::rti::Notice;
use lf_wire::Storage;

use super::RtiLoop;
use crate::datagram::{BYTES_MAX, PER_TURN, send};
use crate::platform::{Interest, Platform, SocketId};

/// The port for datagrams.
#[derive(Debug)]
pub(super) struct Port {
    socket: Option<SocketId>,
    readable: bool,
}

impl Port {
    /// A port, if there is one.
    pub(super) fn new<P: Platform>(platform: &mut P, socket: Option<SocketId>) -> Self {
        if let Some(socket) = socket {
            platform.set_interest(socket, Interest::READ);
        }
        Self { socket, readable: false }
    }

    /// A wait found this socket ready. `true` if it is this one.
    pub(super) fn handle_ready(&mut self, ready: SocketId) -> bool {
        let is_it = self.socket == Some(ready);
        self.readable |= is_it;
        is_it
    }

    /// Closes the port, for good.
    pub(super) fn close<P: Platform>(&mut self, platform: &mut P) {
        if let Some(socket) = self.socket.take() {
            platform.close(socket);
        }
    }
}

impl<P: Platform, N: FnMut(Notice<'_>), B: Storage> RtiLoop<'_, '_, P, N, B> {
    /// When a round is to begin: never without a port, which is closed when the federation has ended.
    pub(super) fn next_round(&self) -> Deadline {
        if self.port.socket.is_some() { self.rti.poll_round_timeout() } else { Deadline::Never }
    }

    /// Answers the datagrams that have come, a bounded number of them, and begins a round if it is time.
    pub(super) fn synchronize(&mut self) {
        let Some(socket) = self.port.socket else { return };
        let mut buffer = [0; BYTES_MAX];
        let mut left = if core::mem::take(&mut self.port.readable) { PER_TURN } else { 0 };
        while left > 0 {
            left -= 1;
            // An error of the port is one of a datagram that was sent; what has come is behind it.
            let received = self.platform.receive_from(socket, &mut buffer);
            let now = self.platform.now();
            let (count, from) = match received {
                Ok(Some(received)) => received,
                Ok(None) => break,
                Err(_) => continue,
            };
            let datagram = buffer.get(..count).unwrap_or_default();
            if let Some(answer) = self.tell(|rti, outlet| rti.handle_datagram(now, from, datagram, outlet)) {
                send(self.platform, socket, answer.to, &answer.message);
                let probe = answer.coded_probe(self.platform.now());
                send(self.platform, socket, probe.to, &probe.message);
            }
        }
        let due = self.rti.poll_round_timeout();
        let now = self.platform.now();
        if due.is_due(now)
            && let Some(question) = self.rti.poll_round(now)
        {
            send(self.platform, socket, question.to, &question.message);
        }
    }
}
