// SPDX-License-Identifier: Apache-2.0
//! The two directions of a connection of the RTI. They are separate, because a message is handled while it still lies
//! in the input buffer of its connection, and goes straight from there into the output buffers of others.

use core::fmt;

use lf_coordination::Deadline;
use lf_coordination::rti::ConnectionId;
use lf_model::time::{Instant, Interval};
use lf_wire::{InBuffer, Message, OutBuffer, Storage};

use crate::connection::{Reading, read, write};
use crate::platform::{Interest, Platform, SocketId};
use crate::trace::RTI;

/// The time that a closed connection may take to send what is pending, and its peer to close its own direction.
///
/// A socket that is closed with unread bytes of the peer resets the connection, and the last message, such as the
/// reason of a rejection, may be lost. So the RTI reads the peer until it closes, but not for longer than this.
const LINGER: Interval = Interval::from_secs(2);

/// The maximum number of bytes of one read, so that they are still in the processor's cache when they are handled.
const READ_BYTES_MAX: usize = 1 << 16;

/// The receiving side of one connection.
pub struct Inlet<B> {
    pub(super) buffer: InBuffer<B>,
    /// Whether the socket may have something to read.
    pub(super) readable: bool,
    /// Whether the peer has closed, or the connection broke.
    pub(super) ended: bool,
    /// The event that the message at the front waits for.
    pub(super) awaits: Option<Awaited>,
    /// The time since which messages have been waiting here; FOREVER once that was logged.
    pub(super) awaits_since: Option<Instant>,
    /// Whether the buffer may hold complete messages that have not been consumed.
    pub(super) fresh: bool,
}

/// The event that a message waits for.
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
    /// Returns the connection that the message waits for.
    pub(super) fn connection(self) -> ConnectionId {
        let (Self::Room(connection) | Self::Input(connection) | Self::InputOrMore(connection)) = self;
        connection
    }

    /// Returns whether `what` has come about: room or input.
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
    /// The connection of the socket whose index in the platform's table is this one, modulo the length of the table.
    pub(super) of_socket: u16,
    /// Whether input of others may wait for room or input here.
    pub(super) awaited: bool,
    /// The size of a message that got no memory and is lost; nothing that belongs behind it may be sent.
    pub(super) refused: Option<usize>,
    /// Whether something other than a DNET is pending: a federate may wait for it.
    urgent: bool,
    /// Whether something was sent early, and the room for it has not been reported yet.
    went: bool,
    /// Whether this connection is in the queue of due ones.
    pub(super) due: bool,
    /// An entry of that queue.
    pub(super) queue: u16,
    /// The federate, once it has sent its id, for records.
    #[cfg(feature = "traces")]
    pub(super) federate: u16,
}

/// The stage of closing a connection from our side.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum State {
    Open,
    /// Our direction is to be closed once everything is sent.
    HalfClosing,
    HalfClosed,
    /// Closed for the RTI; what is pending is still sent, and the peer's end awaited, until the time.
    Closing(Option<Instant>),
    Draining(Instant),
}

impl<B: Storage> Inlet<B> {
    /// Returns an inlet that keeps received bytes in `buffer`, which has to hold the longest message or to grow so far.
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
        if !self.readable || self.ended || self.buffer.space().is_empty() {
            return false;
        }
        self.readable = false;
        let reading = read(platform, socket, &mut self.buffer, READ_BYTES_MAX);
        self.fresh |= reading == Reading::Bytes;
        self.ended = reading == Reading::End;
        reading != Reading::Nothing
    }

    /// Returns whether more is wanted, and there is space for it.
    pub(super) fn wants_more(&mut self) -> bool {
        !self.ended && self.reads_on() && !self.buffer.space().is_empty()
    }

    /// Returns whether the message at the front, if there is one, does not wait for others alone.
    pub(super) fn reads_on(&self) -> bool {
        matches!(self.awaits, None | Some(Awaited::InputOrMore(_)))
    }

    /// Reads once and drops it: for a peer whose connection is closed for the RTI.
    pub(super) fn discard<P: Platform>(&mut self, platform: &mut P, socket: SocketId) {
        self.clear();
        (self.awaits, self.fresh) = (None, false);
        self.fill(platform, socket);
        self.buffer.clear();
    }
}

impl<B: Storage> Outgoing<B> {
    /// Returns a vacant slot whose connections keep pending bytes in `buffer`, which has to hold the longest message or
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
            #[cfg(feature = "traces")]
            federate: RTI,
        }
    }

    pub(super) fn open(&mut self, socket: SocketId) {
        self.socket = Some(socket);
        self.clear();
        self.state = State::Open;
        (self.awaited, self.refused) = (false, None);
        #[cfg(feature = "traces")]
        {
            self.federate = RTI;
        }
    }

    /// Returns which federate it is, for records; [`RTI`] as long as that is not known.
    #[cfg_attr(not(feature = "traces"), expect(clippy::unused_self, reason = "nobody records"))]
    pub(super) fn federate(&self) -> u16 {
        #[cfg(feature = "traces")]
        return self.federate;
        #[cfg(not(feature = "traces"))]
        RTI
    }

    /// Remembers which federate it is, for records.
    #[cfg_attr(not(feature = "traces"), expect(clippy::unused_self, unused_variables, reason = "nobody records"))]
    pub(super) fn set_federate(&mut self, federate: u16) {
        #[cfg(feature = "traces")]
        {
            self.federate = federate;
        }
    }

    /// Frees the slot: returns the socket, which has to be closed.
    pub(super) fn vacate(&mut self) -> Option<SocketId> {
        self.clear();
        self.socket.take()
    }

    fn clear(&mut self) {
        self.buffer.clear();
        self.buffer.shrink();
    }

    /// Puts a message behind what is pending. If there is no memory for it, it is lost, and so is everything that
    /// follows.
    pub(super) fn push(&mut self, message: &Message<'_>) {
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

    /// Returns until when it is kept only for the peer to read what it has been sent.
    pub(super) fn lingers_until(&self) -> Option<Instant> {
        match self.state {
            State::Draining(until) if self.socket.is_some() => Some(until),
            _ => None,
        }
    }

    /// Returns whether it is open in both directions; nothing waits for room on one that is not.
    pub(super) fn is_open(&self) -> bool {
        self.socket.is_some() && self.state == State::Open
    }

    /// Returns whether the RTI still reads this connection.
    pub(super) fn is_read(&self) -> bool {
        self.socket.is_some() && matches!(self.state, State::Open | State::HalfClosing | State::HalfClosed)
    }

    /// Writes what is pending if a federate may wait for it.
    pub(super) fn flush_urgent<P: Platform>(&mut self, platform: &mut P) {
        if core::mem::take(&mut self.urgent) {
            self.went |= self.flush(platform);
        }
    }

    /// Writes what is pending. Returns `true` when something was sent, also before.
    pub(super) fn flush<P: Platform>(&mut self, platform: &mut P) -> bool {
        let Some(socket) = self.socket else { return false };
        let went = core::mem::take(&mut self.went);
        let before = self.buffer.pending().len();
        self.urgent = false;
        if !write(platform, socket, &mut self.buffer) {
            self.buffer.clear();
        }
        self.buffer.shrink();
        went || self.buffer.pending().len() < before
    }

    /// Advances closing, as far as that goes without waiting. `ended`: the peer has closed its direction.
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

    /// Returns when to call [`Outgoing::advance_closing`] though the socket is not ready.
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
