// SPDX-License-Identifier: Apache-2.0
//! The connection to the RTI: made, made again until the RTI has accepted the federate, and closed.

use core::net::SocketAddrV4;

use lf_coordination::Deadline;
use lf_coordination::federate::{ConnectRetry, ConnectStep};
use lf_model::time::Instant;

use crate::connection::{Buffers, Reading};
use crate::error::RunError;
use crate::platform::{Interest, NetError, Platform, SocketId};

/// The connection to the RTI.
#[derive(Debug)]
pub(super) struct Link<'s> {
    /// The buffers of the connection.
    pub(super) buffers: Buffers<'s>,
    address: SocketAddrV4,
    state: State,
    retry: ConnectRetry,
    /// Why the last attempt failed.
    last_error: Option<NetError>,
    /// The socket has something to read, as far as the last wait knew.
    readable: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum State {
    /// No connection, none under way; the next attempt is due at this time.
    Waiting(Instant),
    /// An attempt is under way; `true` when the socket says that it has an outcome.
    Connecting(SocketId, bool),
    Open(SocketId),
    /// Closed for good.
    Closed,
}

/// What reading from the link found.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Arrival {
    /// Nothing, or bytes in the input buffer.
    Open,
    /// The connection has ended; what is in the input buffer is still to be handled.
    End,
}

impl<'s> Link<'s> {
    pub(super) fn new(now: Instant, address: SocketAddrV4, buffers: Buffers<'s>) -> Self {
        let retry = ConnectRetry::new(now);
        Self { buffers, address, state: State::Waiting(now), retry, last_error: None, readable: false }
    }

    /// Whether messages can be exchanged.
    pub(super) fn is_open(&self) -> bool {
        matches!(self.state, State::Open(_))
    }

    /// Makes the connection, as far as that goes without waiting. `true` when it has just been made.
    ///
    /// # Errors
    /// [`RunError::RtiUnreachable`] when the time for it is over.
    pub(super) fn establish<P: Platform>(&mut self, platform: &mut P) -> Result<bool, RunError> {
        match self.state {
            State::Waiting(_) => self.attempt(platform).map(|()| false),
            State::Connecting(socket, true) => match platform.connected(socket) {
                Ok(()) => {
                    self.state = State::Open(socket);
                    self.readable = true;
                    Ok(true)
                }
                Err(error) => {
                    self.last_error = Some(error);
                    self.drop_socket(platform);
                    self.state = State::Waiting(platform.now());
                    self.attempt(platform).map(|()| false)
                }
            },
            State::Connecting(..) if platform.now() >= self.retry.give_up() => {
                Err(RunError::RtiUnreachable { address: self.address, last: self.last_error })
            }
            State::Connecting(..) | State::Open(_) | State::Closed => Ok(false),
        }
    }

    /// Drops a connection that ended before the RTI accepted the federate; [`Link::establish`] makes the next one.
    pub(super) fn begin_anew<P: Platform>(&mut self, platform: &mut P) {
        self.drop_socket(platform);
        self.last_error = Some(NetError::Reset);
        self.state = State::Waiting(platform.now());
    }

    /// Reads once, if there is something to read.
    pub(super) fn fill<P: Platform>(&mut self, platform: &mut P) -> Arrival {
        let State::Open(socket) = self.state else { return Arrival::Open };
        if !self.readable || self.buffers.input.space().is_empty() {
            return Arrival::Open;
        }
        self.readable = false;
        match self.buffers.fill(platform, socket) {
            Ok(Reading::Open) => Arrival::Open,
            Ok(Reading::Ended) | Err(_) => Arrival::End,
        }
    }

    /// Writes what is pending. `true` when the output buffer has become empty by it.
    ///
    /// A broken connection is not reported here: reading finds its end, after the peer's last words.
    pub(super) fn flush<P: Platform>(&mut self, platform: &mut P) -> bool {
        let State::Open(socket) = self.state else { return false };
        if self.buffers.output.is_empty() {
            return false;
        }
        if self.buffers.flush(platform, socket).is_err() {
            self.buffers.output.clear();
            self.readable = true;
            return false;
        }
        self.buffers.output.is_empty()
    }

    /// Closes our direction; what was written still reaches the RTI.
    pub(super) fn shut_down_writing<P: Platform>(&mut self, platform: &mut P) {
        if let State::Open(socket) = self.state {
            platform.shut_down_writing(socket);
        }
    }

    /// Closes the connection for good.
    pub(super) fn close<P: Platform>(&mut self, platform: &mut P) {
        self.drop_socket(platform);
        self.state = State::Closed;
    }

    /// Says what to wait for: bytes as long as there is space for them, and room if something is pending.
    pub(super) fn set_interest<P: Platform>(&mut self, platform: &mut P) {
        match self.state {
            State::Connecting(socket, _) => platform.set_interest(socket, Interest::WRITE),
            State::Open(socket) => platform.set_interest(socket, self.buffers.interest()),
            State::Waiting(_) | State::Closed => {}
        }
    }

    /// A wait found this socket ready.
    pub(super) fn handle_ready(&mut self, ready: SocketId, interest: Interest) {
        match &mut self.state {
            State::Connecting(socket, has_outcome) if *socket == ready => *has_outcome = true,
            State::Open(socket) if *socket == ready => self.readable |= interest.readable,
            _ => {}
        }
    }

    /// When [`Link::establish`] or [`Link::fill`] is to be called though no socket is ready.
    pub(super) fn poll_timeout(&mut self) -> Deadline {
        match self.state {
            // A write found the connection broken; the end is to be read.
            State::Open(_) if self.readable && !self.buffers.input.space().is_empty() => Deadline::Now,
            State::Waiting(time) => Deadline::At(time),
            State::Connecting(..) => Deadline::At(self.retry.give_up()),
            State::Open(_) | State::Closed => Deadline::Never,
        }
    }

    fn attempt<P: Platform>(&mut self, platform: &mut P) -> Result<(), RunError> {
        match self.retry.poll(platform.now()) {
            ConnectStep::Attempt => match platform.connect(self.address) {
                Ok(socket) => self.state = State::Connecting(socket, false),
                Err(error) => {
                    self.last_error = Some(error);
                    self.state = State::Waiting(platform.now());
                }
            },
            ConnectStep::WaitUntil(time) => self.state = State::Waiting(time),
            ConnectStep::GiveUp => {
                return Err(RunError::RtiUnreachable { address: self.address, last: self.last_error });
            }
        }
        Ok(())
    }

    fn drop_socket<P: Platform>(&mut self, platform: &mut P) {
        if let State::Connecting(socket, _) | State::Open(socket) = self.state {
            platform.close(socket);
        }
        self.buffers.clear();
        self.readable = false;
    }
}
