// SPDX-License-Identifier: Apache-2.0
//! Clock synchronization over TCP before the start: what stands between an answer and the times that it leads to would
//! be taken for a part of its way. So the connection whose turn it is comes before all others, and again after each of
//! them; its answer is written at once, and each time that begins an exchange is taken right before it is.

use lf_coordination::Deadline;
use lf_coordination::rti::{ConnectionId, Notice};
use lf_wire::Storage;

use super::RtiLoop;
use crate::platform::Platform;

impl<P: Platform, N: FnMut(Notice<'_>), B: Storage> RtiLoop<'_, '_, P, N, B> {
    /// Reads the connection whose turn it is, answers it, and sends the times that are due. Whether something has come
    /// there, only reading says: the last wait is over.
    pub(super) fn exchange(&mut self) {
        if let Some(ConnectionId(index)) = self.rti.exchanging() {
            self.inlets[index].readable = true;
            self.receive(index);
            self.send(index);
        }
        self.tell_times();
    }

    /// Sends the times that are due.
    pub(super) fn tell_times(&mut self) {
        while self.rti.poll_exchange_timeout() != Deadline::Never {
            let now = self.platform.now();
            let Some(ConnectionId(index)) = self.tell(|rti, outlet| rti.poll_exchange(now, outlet)) else { return };
            self.send(index);
        }
    }
}
