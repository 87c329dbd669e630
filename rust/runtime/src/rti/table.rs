// SPDX-License-Identifier: Apache-2.0
//! The table of the RTI's connections, with a queue of those with something to do: a federate that is silent costs
//! nothing.

use lf_coordination::Deadline;
#[cfg(feature = "security")]
use lf_coordination::FederateId;
use lf_coordination::rti::{ConnectionId, Outlet, RtiEvent, SetupError};
use lf_derive::outlined;
use lf_model::time::Instant;
use lf_wire::{Decoded, Limits, Message, Storage, decode};

use super::connections::{Awaited, Inlet, Outgoing, State};
#[cfg(feature = "security")]
use crate::platform::Participant;
use crate::platform::{Interest, Platform, SocketId};
use crate::trace::{RTI, Recording};

/// The connections: incoming and outgoing directions.
pub(super) struct Table<'a, B> {
    pub(super) inlets: &'a mut [Inlet<B>],
    pub(super) outgoings: &'a mut [Outgoing<B>],
    /// The connections with something to do; all others are left alone.
    due: Due,
    /// The number of connections.
    open: usize,
    /// The time at which the next connection that is being closed may be due.
    closing: Deadline,
}

impl<'a, B: Storage> Table<'a, B> {
    /// Returns a table without connections.
    ///
    /// # Errors
    /// When a buffer has less than the `needed` bytes of the longest message, which it would hold back without end.
    pub(super) fn new(
        inlets: &'a mut [Inlet<B>],
        outgoings: &'a mut [Outgoing<B>],
        needed: usize,
    ) -> Result<Self, SetupError> {
        let receive = inlets.iter().map(|inlet| ("received bytes", inlet.buffer.capacity_max()));
        let send = outgoings.iter().map(|outgoing| ("bytes to be sent", outgoing.buffer.capacity_max()));
        if let Some((part, found)) = receive.chain(send).find(|(_, found)| *found < needed) {
            return Err(SetupError::Storage { part, needed, found });
        }
        let count = inlets.len().min(outgoings.len()).min(u16::MAX.into());
        let (inlets, outgoings) = (&mut inlets[..count], &mut outgoings[..count]);
        Ok(Self { inlets, outgoings, due: Due::default(), open: 0, closing: Deadline::Never })
    }

    /// Returns the maximum number of connections.
    pub(super) fn len(&self) -> usize {
        self.outgoings.len()
    }

    /// Returns the number of connections.
    pub(super) fn open(&self) -> usize {
        self.open
    }

    /// Returns the receiving sides, and the sending sides as the machine sees them.
    #[outlined]
    pub(super) fn outlet<'x, P, N>(
        &'x mut self,
        platform: &'x mut P,
        recording: Recording<'x>,
        log: &'x mut N,
    ) -> (&'x mut [Inlet<B>], Outgoings<'x, P, N, B>) {
        (self.inlets, Outgoings { table: self.outgoings, due: &mut self.due, platform, recording, log })
    }

    /// Returns the number of connections in the queue.
    pub(super) fn due(&self) -> usize {
        self.due.len()
    }

    /// Returns an entry of the queue.
    pub(super) fn due_at(&self, entry: usize) -> usize {
        self.due.get(self.outgoings, entry)
    }

    /// Takes the first entry of the queue.
    pub(super) fn pop(&mut self) -> Option<usize> {
        self.due.pop(self.outgoings)
    }

    /// Puts a connection at the end of the queue, unless it is there.
    pub(super) fn push(&mut self, index: usize) {
        self.due.push(self.outgoings, index);
    }

    /// Handles that a wait found this socket ready.
    pub(super) fn handle_ready(&mut self, socket: SocketId, interest: Interest) {
        if let Some(index) = connection_of(self.outgoings, socket) {
            self.inlets[index].readable |= interest.readable;
            self.push(index);
        }
    }

    /// Returns a free slot.
    pub(super) fn vacant(&self) -> Option<usize> {
        if self.open == self.len() {
            return None;
        }
        self.outgoings.iter().position(|outgoing| outgoing.socket.is_none())
    }

    /// Puts a new connection into a free slot.
    pub(super) fn occupy(&mut self, index: usize, socket: SocketId) {
        self.open += 1;
        self.outgoings[index].open(socket);
        self.inlets[index].reset();
        note_socket(self.outgoings, socket, index);
        self.push(index);
    }

    /// Evicts a connection. Returns its socket, which has to be closed.
    pub(super) fn vacate(&mut self, index: usize) -> Option<SocketId> {
        let socket = self.outgoings.get_mut(index)?.vacate()?;
        self.freed();
        self.resume(Awaited::Room(ConnectionId(index)));
        self.resume(Awaited::Input(ConnectionId(index)));
        Some(socket)
    }

    /// Records that a socket has been closed.
    pub(super) fn freed(&mut self) {
        self.open -= 1;
    }

    /// Returns the connection that has been closing for longest, if its peer has been sent everything.
    pub(super) fn lingering(&self) -> Option<usize> {
        let until = |(index, outgoing): (usize, &Outgoing<B>)| outgoing.lingers_until().map(|until| (until, index));
        self.outgoings.iter().enumerate().filter_map(until).min().map(|(_, index)| index)
    }

    /// Checks the connections that are being closed, if the time of one may have come.
    pub(super) fn expire(&mut self, now: Instant) {
        if !self.closing.is_due(now) {
            return;
        }
        self.closing = Deadline::Never;
        for index in 0..self.outgoings.len() {
            let time_out = self.outgoings[index].poll_timeout();
            if time_out.is_due(now) {
                self.push(index);
            } else {
                self.closing = self.closing.min(time_out);
            }
        }
    }

    /// Returns when to call [`Table::expire`].
    pub(super) fn poll_timeout(&self) -> Deadline {
        self.closing
    }

    /// Returns what to wait for on a connection.
    pub(super) fn interest(&mut self, index: usize) -> Interest {
        self.closing = self.closing.min(self.outgoings[index].poll_timeout());
        let reading = self.inlets[index].wants_more();
        self.outgoings[index].interest(reading)
    }

    /// Begins to close what is still open.
    pub(super) fn close_all(&mut self) {
        for index in 0..self.len() {
            if self.outgoings[index].is_read() {
                self.outgoings[index].state = State::Closing(None);
                self.push(index);
            }
        }
    }

    /// Makes the message at the front of a connection wait.
    pub(super) fn postpone(&mut self, now: Instant, index: usize, awaited: Awaited) {
        let inlet = &mut self.inlets[index];
        inlet.awaits = Some(awaited);
        inlet.awaits_since = inlet.awaits_since.or(Some(now));
        let on = awaited.connection();
        if let Some(outgoing) = self.outgoings.get_mut(on.0) {
            outgoing.awaited = true;
            // If it is closing already, nothing else would lead there.
            self.push(on.0);
        }
    }

    /// Resumes the connections whose wait is over.
    pub(super) fn resume(&mut self, awaited: Awaited) {
        let on = awaited.connection();
        if !core::mem::take(&mut self.outgoings[on.0].awaited) {
            return;
        }
        for index in 0..self.inlets.len() {
            let inlet = &mut self.inlets[index];
            if inlet.awaits.is_some_and(|awaits| awaits.is(awaited)) {
                inlet.awaits = None;
                self.push(index);
            } else if inlet.awaits.is_some_and(|other| other.connection() == on) {
                self.outgoings[on.0].awaited = true;
            }
        }
    }

    /// Returns whether there is something to do for a connection though its socket is not ready.
    pub(super) fn has_work(&self, index: usize) -> bool {
        let inlet = &self.inlets[index];
        self.outgoings[index].is_read() && inlet.awaits.is_none() && (inlet.fresh || inlet.ended)
    }
}

/// The connections with something to do: a queue in which each is at most once.
#[derive(Clone, Copy, Default, Debug)]
struct Due {
    head: usize,
    len: usize,
}

impl Due {
    fn len(self) -> usize {
        self.len
    }

    /// Puts a connection at the end, unless it is in the queue.
    fn push<B>(&mut self, table: &mut [Outgoing<B>], index: usize) {
        let Some(outgoing) = table.get_mut(index).filter(|outgoing| !outgoing.due) else { return };
        outgoing.due = true;
        let end = (self.head + self.len) % table.len();
        // There are no more connections than that: the table is cut to it.
        table[end].queue = u16::try_from(index).unwrap_or(u16::MAX);
        self.len += 1;
    }

    /// Returns one of the entries.
    fn get<B>(self, table: &[Outgoing<B>], index: usize) -> usize {
        table[(self.head + index) % table.len()].queue.into()
    }

    /// Takes the first entry.
    fn pop<B>(&mut self, table: &mut [Outgoing<B>]) -> Option<usize> {
        self.len = self.len.checked_sub(1)?;
        let index = self.get(table, 0);
        self.head = (self.head + 1) % table.len();
        table[index].due = false;
        Some(index)
    }
}

/// Stores the connection of a socket where [`connection_of`] looks for it.
fn note_socket<B>(table: &mut [Outgoing<B>], socket: SocketId, connection: usize) {
    let place = usize::from(socket.index) % table.len();
    table[place].of_socket = u16::try_from(connection).unwrap_or(u16::MAX);
}

/// Returns the connection that has a socket.
fn connection_of<B>(table: &[Outgoing<B>], socket: SocketId) -> Option<usize> {
    let is_it = |outgoing: &Outgoing<B>| outgoing.socket == Some(socket);
    let noted = usize::from(table.get(usize::from(socket.index) % table.len().max(1))?.of_socket);
    match table.get(noted) {
        Some(outgoing) if is_it(outgoing) => Some(noted),
        // Sockets of other connections have the same index modulo the length.
        _ => table.iter().position(is_it),
    }
}

/// The connections as the RTI's machine sees them.
pub(super) struct Outgoings<'a, P, N, B> {
    table: &'a mut [Outgoing<B>],
    due: &'a mut Due,
    /// Its clock is that of what is recorded.
    platform: &'a mut P,
    recording: Recording<'a>,
    log: &'a mut N,
}

impl<P: Platform, N, B: Storage> Outgoings<'_, P, N, B> {
    /// Remembers which federate is at the other end of a connection, if what has come there says it: what is recorded
    /// of the answer names it.
    pub(super) fn learn_federate(&mut self, connection: usize, bytes: &[u8]) {
        if !self.recording.is_on() {
            return;
        }
        let Some(outgoing) = self.table.get_mut(connection).filter(|outgoing| outgoing.federate() == RTI) else {
            return;
        };
        if let Ok(Decoded::Complete {
            message:
                Message::FedIds { federate, .. }
                | Message::TransientFedIds { federate, .. }
                | Message::FedNonce { federate, .. },
            ..
        }) = decode(bytes, &Limits::NONE)
        {
            outgoing.set_federate(federate);
        }
    }

    /// Records a message that has come at this time on a connection.
    pub(super) fn note_received(&mut self, connection: usize, now: Instant, bytes: &[u8]) {
        if let Some(outgoing) = self.table.get(connection).filter(|_| self.recording.is_on()) {
            self.recording.note_bytes(now, bytes, outgoing.federate());
        }
    }
}

impl<P: Platform, N: FnMut(RtiEvent<'_>), B: Storage> Outlet for Outgoings<'_, P, N, B> {
    fn room(&self, connection: ConnectionId) -> usize {
        self.table.get(connection.0).map_or(0, |outgoing| outgoing.buffer.room_max())
    }

    fn send(&mut self, connection: ConnectionId, message: &Message<'_>) {
        if let Some(outgoing) = self.table.get_mut(connection.0) {
            // There may be room, because the machine asks before.
            outgoing.push(message);
            self.recording.note_sent(self.platform, message, outgoing.federate());
            self.due.push(self.table, connection.0);
        }
    }

    #[cfg(feature = "security")]
    fn may_be(&self, connection: ConnectionId, federate: FederateId) -> bool {
        let socket = self.table.get(connection.0).and_then(|outgoing| outgoing.socket);
        socket.is_some_and(|socket| self.platform.may_be(socket, Participant::Federate(federate.0)))
    }

    fn half_close(&mut self, connection: ConnectionId) {
        if let Some(outgoing) = self.table.get_mut(connection.0).filter(|outgoing| outgoing.state == State::Open) {
            outgoing.state = State::HalfClosing;
            self.due.push(self.table, connection.0);
        }
    }

    fn close(&mut self, connection: ConnectionId) {
        if let Some(outgoing) = self.table.get_mut(connection.0).filter(|outgoing| outgoing.is_read()) {
            outgoing.state = State::Closing(None);
            self.due.push(self.table, connection.0);
        }
    }

    fn log(&mut self, event: RtiEvent<'_>) {
        (self.log)(event);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each connection is in the queue at most once, and they are taken in the order in which they became due, however
    /// often the queue has gone round its table.
    #[test]
    fn connections_are_taken_in_the_order_in_which_they_became_due() {
        let mut table = [0; 3].map(|_| Outgoing::new([0; 0]));
        let mut due = Due::default();
        for first in [0, 1, 2, 0, 1] {
            let expected = [first, (first + 2) % 3];
            for index in [expected[0], expected[1], expected[0], 3] {
                due.push(&mut table, index);
            }
            assert_eq!([due.get(&table, 0), due.get(&table, 1)], expected);
            assert_eq!(
                [due.pop(&mut table), due.pop(&mut table), due.pop(&mut table)],
                [Some(expected[0]), Some(expected[1]), None]
            );
        }
    }

    /// Sockets with the same index modulo the length of the table are distinguished, and so is a slot's next socket
    /// from the one before.
    #[test]
    fn a_socket_is_found_wherever_it_was_noted() {
        let mut table = [0; 2].map(|_| Outgoing::new([0; 0]));
        let sockets = [(1, 0), (3, 0)].map(|(index, generation)| SocketId { index, generation });
        for (connection, socket) in sockets.into_iter().enumerate() {
            table[connection].open(socket);
            note_socket(&mut table, socket, connection);
        }
        assert_eq!(sockets.map(|socket| connection_of(&table, socket)), [Some(0), Some(1)]);
        assert_eq!(connection_of(&table, SocketId { index: 3, generation: 1 }), None);
    }
}
