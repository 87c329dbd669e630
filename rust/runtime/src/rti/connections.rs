// SPDX-License-Identifier: Apache-2.0
//! The RTI's connections: what comes in on one side of the table, what goes out on the other.
//!
//! The two sides are separate, because a message is handled while it still lies in the input buffer of its connection,
//! and goes straight from there into the output buffers of others.

use core::fmt;

use lf_coordination::Deadline;
use lf_coordination::rti::{ConnectionId, Notice, Outlet};
use lf_model::time::{Instant, Interval};
use lf_wire::{InBuffer, Message, OutBuffer, Storage};

use crate::platform::{Interest, Platform, SocketId, Transfer};

/// How long a closed connection may take to send what is pending, and its peer to close its own direction.
///
/// A socket that is closed while bytes of the peer are unread resets the connection, and the last message, such as the
/// reason of a rejection, may be lost. So the peer is read until it closes, but not for longer than this.
const LINGER: Interval = Interval::from_secs(2);

/// Most bytes that one read takes, so that what has been read is still in the processor's cache when it is handled.
const READ_BYTES_MAX: usize = 1 << 16;

/// The receiving side of one connection.
pub struct Inlet<B> {
    pub(super) buffer: InBuffer<B>,
    /// The socket may have something to read.
    pub(super) readable: bool,
    /// The peer has closed, or the connection broke.
    pub(super) ended: bool,
    /// The message at the front waits for this.
    pub(super) awaits: Option<Awaited>,
    /// Since when messages have been waiting here; FOREVER once that was told.
    pub(super) awaits_since: Option<Instant>,
    /// The buffer may hold whole messages that have not been consumed.
    pub(super) fresh: bool,
}

/// What a message waits for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Awaited {
    /// Room on this connection.
    Room(ConnectionId),
    /// Input of this connection.
    Input(ConnectionId),
    /// Input of this connection, or more behind the message.
    InputOrMore(ConnectionId),
}

impl Awaited {
    /// The connection where it has to come about.
    pub(super) fn connection(self) -> ConnectionId {
        let (Self::Room(connection) | Self::Input(connection) | Self::InputOrMore(connection)) = self;
        connection
    }

    /// Whether this has come about: room or input.
    pub(super) fn is(self, what: Self) -> bool {
        match self {
            Self::Room(_) | Self::Input(_) => self == what,
            Self::InputOrMore(connection) => Self::Input(connection) == what,
        }
    }
}

/// The sending side of one connection.
#[expect(clippy::struct_excessive_bools, reason = "four questions, of which each has its own answer")]
pub struct Outgoing<B> {
    pub(super) socket: Option<SocketId>,
    pub(super) buffer: OutBuffer<B>,
    pub(super) state: State,
    /// The connection of the socket whose place in the platform's table is this one, modulo the length of the table.
    pub(super) of_socket: u16,
    /// Input of others may wait for room or input here.
    pub(super) awaited: bool,
    /// Memory was refused for a message of so many bytes, which is lost; nothing that belongs behind it may be sent.
    pub(super) refused: Option<usize>,
    /// What is pending is more than advice: somebody may wait for it.
    urgent: bool,
    /// Something went before its turn, and nobody has been told yet that there is room.
    went: bool,
    /// This connection is in the queue of those that are due.
    due: bool,
    /// An entry of that queue.
    queue: u16,
}

/// The connections that something is to be done for: a queue in which each is at most once.
#[derive(Clone, Copy, Default, Debug)]
pub(super) struct Due {
    head: usize,
    len: usize,
}

impl Due {
    pub(super) fn len(self) -> usize {
        self.len
    }

    /// Puts a connection at the end, if it is not in the queue.
    pub(super) fn push<B>(&mut self, table: &mut [Outgoing<B>], index: usize) {
        let Some(outgoing) = table.get_mut(index).filter(|outgoing| !outgoing.due) else { return };
        outgoing.due = true;
        let end = (self.head + self.len) % table.len();
        // There are no more connections than that: the table is cut to it.
        table[end].queue = u16::try_from(index).unwrap_or(u16::MAX);
        self.len += 1;
    }

    /// One of the entries.
    pub(super) fn get<B>(self, table: &[Outgoing<B>], index: usize) -> usize {
        table[(self.head + index) % table.len()].queue.into()
    }

    /// Takes the first entry.
    pub(super) fn pop<B>(&mut self, table: &mut [Outgoing<B>]) -> Option<usize> {
        self.len = self.len.checked_sub(1)?;
        let index = self.get(table, 0);
        self.head = (self.head + 1) % table.len();
        table[index].due = false;
        Some(index)
    }
}

/// How far a connection is closed from our side.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum State {
    Open,
    /// Our direction is to be closed once all is sent.
    HalfClosing,
    HalfClosed,
    /// Closed for the RTI; what is pending is still sent, and the peer's end awaited, until the time.
    Closing(Option<Instant>),
    Draining(Instant),
}

impl<B: Storage> Inlet<B> {
    /// An inlet that keeps what has come in `buffer`, which has to hold the longest message or to grow so far.
    pub fn new(buffer: B) -> Self {
        Self {
            buffer: InBuffer::new(buffer),
            readable: false,
            ended: false,
            awaits: None,
            awaits_since: None,
            fresh: false,
        }
    }

    pub(super) fn reset(&mut self) {
        self.clear();
        (self.readable, self.ended, self.awaits, self.awaits_since, self.fresh) = (true, false, None, None, false);
    }

    pub(super) fn clear(&mut self) {
        self.buffer.clear();
        self.buffer.shrink();
    }

    /// Reads once, as much as there is space for. Returns whether more has come, or the end.
    pub(super) fn fill<P: Platform>(&mut self, platform: &mut P, socket: SocketId) -> bool {
        let space = self.buffer.space();
        let len = space.len().min(READ_BYTES_MAX);
        let space = &mut space[..len];
        if !self.readable || self.ended || space.is_empty() {
            return false;
        }
        self.readable = false;
        match platform.read(socket, space) {
            Ok(Transfer::Bytes(count)) => {
                self.buffer.filled(count);
                self.fresh = true;
            }
            Ok(Transfer::WouldBlock) => return false,
            Ok(Transfer::Closed) | Err(_) => self.ended = true,
        }
        true
    }

    /// Whether more is wanted, and there is space for it.
    pub(super) fn wants_more(&mut self) -> bool {
        !self.ended && self.reads_on() && !self.buffer.space().is_empty()
    }

    /// Whether the message at the front, if there is one, does not wait for others alone.
    pub(super) fn reads_on(&self) -> bool {
        matches!(self.awaits, None | Some(Awaited::InputOrMore(_)))
    }

    /// Reads once and forgets it: for a peer whose connection is closed for the RTI.
    pub(super) fn discard<P: Platform>(&mut self, platform: &mut P, socket: SocketId) {
        self.clear();
        (self.awaits, self.fresh) = (None, false);
        self.fill(platform, socket);
        self.buffer.clear();
    }
}

impl<B: Storage> Outgoing<B> {
    /// A vacant place whose connections keep what is to be sent in `buffer`, which has to hold the longest message or
    /// to grow so far.
    pub fn new(buffer: B) -> Self {
        Self {
            socket: None,
            buffer: OutBuffer::new(buffer),
            state: State::Open,
            of_socket: 0,
            awaited: false,
            refused: None,
            urgent: false,
            went: false,
            due: false,
            queue: 0,
        }
    }

    pub(super) fn open(&mut self, socket: SocketId) {
        self.socket = Some(socket);
        self.clear();
        self.state = State::Open;
        (self.awaited, self.refused) = (false, None);
    }

    /// Frees the place: gives the socket, which is to be closed.
    pub(super) fn vacate(&mut self) -> Option<SocketId> {
        self.clear();
        self.socket.take()
    }

    fn clear(&mut self) {
        self.buffer.clear();
        self.buffer.shrink();
    }

    /// Puts a message behind what is pending. If memory is refused for it, it is lost, and so is all that follows.
    fn push(&mut self, message: &Message<'_>) {
        if self.refused.is_some() {
            return;
        }
        let len = message.encoded_len();
        if self.buffer.make_room(len) {
            // It fits, and a message that came over the wire can go over it.
            let _ = self.buffer.push(message);
            self.urgent |= !matches!(message, Message::DownstreamNextEventTag(_));
        } else {
            self.refused = Some(len);
        }
    }

    /// Until when it is kept only for the peer to read what it has been sent.
    pub(super) fn lingers_until(&self) -> Option<Instant> {
        match self.state {
            State::Draining(until) if self.socket.is_some() => Some(until),
            _ => None,
        }
    }

    /// Whether it is open in both directions; nothing waits for room on one that is not.
    pub(super) fn is_open(&self) -> bool {
        self.socket.is_some() && self.state == State::Open
    }

    /// Whether the RTI still reads this connection.
    pub(super) fn is_read(&self) -> bool {
        self.socket.is_some() && matches!(self.state, State::Open | State::HalfClosing | State::HalfClosed)
    }

    /// Writes what is pending if somebody may wait for it.
    pub(super) fn hurry<P: Platform>(&mut self, platform: &mut P) {
        if core::mem::take(&mut self.urgent) {
            self.went |= self.flush(platform);
        }
    }

    /// Writes what is pending. `true` when something went, also before.
    pub(super) fn flush<P: Platform>(&mut self, platform: &mut P) -> bool {
        let Some(socket) = self.socket else { return false };
        let went = core::mem::take(&mut self.went);
        let before = self.buffer.pending().len();
        self.urgent = false;
        while !self.buffer.is_empty() {
            match platform.write(socket, self.buffer.pending()) {
                Ok(Transfer::Bytes(count)) => self.buffer.consume(count),
                Ok(Transfer::WouldBlock) => break,
                // Reading finds the end, after the peer's last words.
                Ok(Transfer::Closed) | Err(_) => self.buffer.clear(),
            }
        }
        self.buffer.shrink();
        went || self.buffer.pending().len() < before
    }

    /// Goes on with closing, as far as that goes without waiting. `ended`: the peer has closed its direction.
    pub(super) fn advance_closing<P: Platform>(&mut self, platform: &mut P, ended: bool) {
        let Some(socket) = self.socket else { return };
        match self.state {
            State::HalfClosing if self.buffer.is_empty() => {
                platform.shut_down_writing(socket);
                self.state = State::HalfClosed;
            }
            State::Open | State::HalfClosing | State::HalfClosed => {}
            State::Closing(None) => {
                self.state = State::Closing(Some(platform.now() + LINGER));
                self.advance_closing(platform, ended);
            }
            State::Closing(Some(until)) if self.buffer.is_empty() => {
                platform.shut_down_writing(socket);
                self.state = State::Draining(until);
                self.advance_closing(platform, ended);
            }
            // The peer may have closed its own direction only, so its end does not mean that it reads no more.
            State::Closing(Some(until)) if platform.now() < until => {}
            State::Draining(until) if !ended && platform.now() < until => {}
            State::Closing(_) | State::Draining(_) => {
                platform.close(socket);
                self.socket = None;
                self.clear();
            }
        }
    }

    /// When [`Outgoing::advance_closing`] is to be called though the socket is not ready.
    pub(super) fn poll_timeout(&self) -> Deadline {
        match (self.socket, self.state) {
            (Some(_), State::Closing(Some(until)) | State::Draining(until)) => Deadline::At(until),
            (Some(_), State::Closing(None)) => Deadline::Now,
            _ => Deadline::Never,
        }
    }

    pub(super) fn interest(&self, reading: bool) -> Interest {
        Interest { readable: reading, writable: !self.buffer.is_empty() }
    }
}

impl<B: Storage> fmt::Debug for Inlet<B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Inlet").field("buffer", &self.buffer).field("awaits", &self.awaits).finish_non_exhaustive()
    }
}

impl<B: Storage> fmt::Debug for Outgoing<B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Outgoing").field("buffer", &self.buffer).field("state", &self.state).finish_non_exhaustive()
    }
}

/// Remembers the connection of a socket where [`connection_of`] looks for it.
pub(super) fn note_socket<B>(table: &mut [Outgoing<B>], socket: SocketId, connection: usize) {
    let place = usize::from(socket.index) % table.len();
    table[place].of_socket = u16::try_from(connection).unwrap_or(u16::MAX);
}

/// The connection that has a socket.
pub(super) fn connection_of<B>(table: &[Outgoing<B>], socket: SocketId) -> Option<usize> {
    let is_it = |outgoing: &Outgoing<B>| outgoing.socket == Some(socket);
    let noted = usize::from(table.get(usize::from(socket.index) % table.len().max(1))?.of_socket);
    match table.get(noted) {
        Some(outgoing) if is_it(outgoing) => Some(noted),
        // Sockets of other connections have the same place modulo the length.
        _ => table.iter().position(is_it),
    }
}

/// What the RTI's machine sees of the connections.
pub(super) struct Outgoings<'a, N, B> {
    pub(super) table: &'a mut [Outgoing<B>],
    pub(super) due: &'a mut Due,
    pub(super) notices: &'a mut N,
}

impl<N: FnMut(Notice<'_>), B: Storage> Outlet for Outgoings<'_, N, B> {
    fn room(&self, connection: ConnectionId) -> usize {
        self.table.get(connection.0).map_or(0, |outgoing| outgoing.buffer.room_max())
    }

    fn send(&mut self, connection: ConnectionId, message: &Message<'_>) {
        if let Some(outgoing) = self.table.get_mut(connection.0) {
            // There may be room, for the machine asks before.
            outgoing.push(message);
            self.due.push(self.table, connection.0);
        }
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

    fn notice(&mut self, notice: Notice<'_>) {
        (self.notices)(notice);
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

    /// Sockets whose places are the same modulo the length of the table are told apart, and so is a place's next socket
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
