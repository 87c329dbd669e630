// SPDX-License-Identifier: Apache-2.0
//! Clock synchronization over UDP: datagrams are read before anything else, for the time right after that is the one
//! that counts.

use lf_coordination::federate::ClockSync;

use super::FederateLoop;
use crate::datagram::{BYTES_MAX, PER_TURN, send};
use crate::error::RunError;
use crate::platform::{Interest, Platform, SocketId};

/// The port for datagrams.
#[derive(Debug, Default)]
pub(super) struct Port {
    socket: Option<SocketId>,
    readable: bool,
    /// Strangers have been reported.
    told: bool,
}

impl Port {
    /// Opens a port, if this federate takes part in rounds over UDP; gives its number.
    pub(super) fn open<P: Platform>(platform: &mut P, clock_sync: ClockSync) -> Result<(Self, Option<u16>), RunError> {
        let ClockSync::On { .. } = clock_sync else { return Ok((Self::default(), None)) };
        if !P::DATAGRAMS {
            log::warn!("the clock is synchronized before the start only, because this image has no UDP");
            return Ok((Self::default(), None));
        }
        let socket = platform.bind(0).map_err(RunError::Bind)?;
        let number = platform.local_port(socket).map_err(RunError::Bind)?;
        platform.set_interest(socket, Interest::READ);
        Ok((Self { socket: Some(socket), ..Self::default() }, Some(number)))
    }

    /// A wait found this socket ready.
    pub(super) fn handle_ready(&mut self, ready: SocketId) {
        self.readable |= self.socket == Some(ready);
    }

    /// Closes the port, for good.
    pub(super) fn close<P: Platform>(&mut self, platform: &mut P) {
        if let Some(socket) = self.socket.take() {
            platform.close(socket);
        }
    }
}

impl<P: Platform> FederateLoop<'_, '_, P> {
    /// Reads the datagrams that have come, a bounded number of them, and answers them.
    pub(super) fn synchronize(&mut self) {
        if !P::DATAGRAMS {
            return;
        }
        let Some(socket) = self.port.socket.filter(|_| core::mem::take(&mut self.port.readable)) else { return };
        let mut buffer = [0; BYTES_MAX];
        for _ in 0..PER_TURN {
            // An error of the port is one of a datagram that was sent; what has come is behind it.
            let received = self.platform.receive_from(socket, &mut buffer);
            let now = self.platform.now();
            let (count, from) = match received {
                Ok(Some(received)) => received,
                Ok(None) => return,
                Err(_) => continue,
            };
            let heard = self.machine.handle_datagram(now, from, buffer.get(..count).unwrap_or_default());
            if let Some(answer) = heard.answer {
                let now = self.platform.now();
                self.machine.answer_leaves(now);
                send(self.platform, socket, from, &answer);
            }
            if heard.corrected {
                self.platform.set_correction(self.machine.clock());
            }
            if heard.stranger && !core::mem::replace(&mut self.port.told, true) {
                log::warn!("datagrams from {from}, which is not the RTI, are ignored");
            }
        }
    }

    /// Ends clock synchronization, and says what it was good for.
    pub(super) fn end_synchronization(&mut self) {
        if !P::DATAGRAMS {
            return;
        }
        self.port.close(self.platform);
        if let Some(report) = self.machine.clock_sync_report() {
            log::info!("clock synchronization: {report}");
        }
    }
}
