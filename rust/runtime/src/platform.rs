// SPDX-License-Identifier: Apache-2.0
//! The operations of the system that the event loops need. Linux and Zephyr each implement them once.
//!
//! All calls but [`Platform::wait`] return at once. Sockets are non-blocking, TCP except for those of
//! [`Platform::bind`]; their name is a [`SocketId`], whose generation makes a stale id an error and never another
//! socket. A listener and a UDP port accept every family of IP that the system has.

use core::fmt;

use lf_coordination::Deadline;
use lf_coordination::clock_sync::ClockCorrection;
pub use lf_coordination::{Endpoint, IpAddress};
use lf_model::Outside;
use lf_model::time::{Instant, Interval};
#[cfg(feature = "security")]
pub use lf_secure::Participant;
use lf_texts::say;

/// A socket of the platform: an index into its table, and the number of earlier sockets with this index.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct SocketId {
    /// The index in the platform's table, from 0; below the number of sockets that the platform was given.
    pub index: u16,
    /// The number of earlier uses of this index, so that an id outlives its socket without naming the next one.
    pub generation: u16,
}

/// The events that an event loop waits for on one socket.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Interest {
    /// Bytes, a connection to accept, or the end of the connection.
    pub readable: bool,
    /// Room to write, or (after [`Platform::connect`]) the outcome of the connection attempt.
    pub writable: bool,
}

impl Interest {
    /// Neither; the platform then reports no error of the socket either.
    pub const NONE: Self = Self { readable: false, writable: false };
    /// Reading only.
    pub const READ: Self = Self { readable: true, writable: false };
    /// Writing only.
    pub const WRITE: Self = Self { readable: false, writable: true };
}

/// The outcome of one read or write.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Transfer {
    /// This number of bytes, at least one.
    Bytes(usize),
    /// Nothing now; wait for the socket.
    WouldBlock,
    /// The peer has closed its direction (reading), or accepts no more bytes (writing).
    Closed,
}

/// An error of the network, as the system reports it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum NetError {
    /// No program listens at that address.
    Refused,
    /// The peer reset the connection, or it timed out.
    Reset,
    /// No route, or the interface is down.
    Unreachable,
    /// The port is taken by another program.
    AddressInUse,
    /// The platform's table of sockets, or the system's, is full.
    NoSocketLeft,
    /// The id names a socket that has been closed.
    Stale,
    /// The other end has not proved who it is, or what came is not from it; the log has the reason.
    #[cfg(feature = "security")]
    Insecure,
    /// Any other error: the system's error number.
    Os(i32),
}

impl fmt::Display for NetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused => say!(f, "connection refused: nobody listens there (yet)"),
            Self::Reset => say!(f, "connection reset by the peer, or the peer is gone"),
            Self::Unreachable => say!(f, "network unreachable: check the cable, the IP address and the netmask"),
            Self::AddressInUse => say!(f, "the port is in use by another program"),
            Self::NoSocketLeft => say!(f, "no socket left: raise the limit of open sockets"),
            Self::Stale => say!(f, "the socket was closed before"),
            #[cfg(feature = "security")]
            Self::Insecure => say!(f, "the connection is not secure, as logged before"),
            Self::Os(number) => say!(f, "system error {number}"),
        }
    }
}

impl core::error::Error for NetError {}

/// The system has no random numbers available: its error number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct RandomError(pub i32);

impl fmt::Display for RandomError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        say!(f, "the system gives no random numbers (error {}), which authentication needs", self.0)
    }
}

impl core::error::Error for RandomError {}

/// The system under an event loop: its clock, and its network.
pub trait Platform {
    /// Whether it has UDP. Without UDP, no code that synchronizes clocks during the run is linked.
    const DATAGRAMS: bool = true;
    /// Whether hosts have names, and with them several addresses. Otherwise only one is tried.
    const NAMES: bool = true;
    /// The time after which a federate begins no further tag before it reads and writes again: longer than that takes.
    const TURN_TIME: Interval = Interval::from_micros(100);

    /// Returns the physical time: nanoseconds of this platform's clock, uncorrected, never running backwards.
    ///
    /// Its epoch is the platform's own: 1970 on Linux, the boot on Zephyr.
    fn now(&mut self) -> Instant;

    /// Returns the state that other threads of this participant may use: the federation's clock, the wake-up of
    /// [`Platform::wait`] and the mailbox.
    fn outside(&self) -> &'static dyn Outside;

    /// Makes [`Platform::now`] with this correction the federation's physical time, which [`Platform::outside`] shows.
    fn set_correction(&mut self, correction: ClockCorrection);

    /// Fills the buffer with unpredictable numbers.
    ///
    /// # Errors
    /// When the system has no source of them.
    fn random(&mut self, buffer: &mut [u8]) -> Result<(), RandomError>;

    /// Begins to connect; wait for [`Interest::WRITE`], then ask [`Platform::connected`].
    ///
    /// # Errors
    /// When the system refuses at once.
    fn connect(&mut self, address: Endpoint) -> Result<SocketId, NetError>;

    /// Returns the outcome of [`Platform::connect`], once the socket is writable.
    ///
    /// # Errors
    /// The reason why it did not connect; the socket then has to be closed.
    fn connected(&mut self, socket: SocketId) -> Result<(), NetError>;

    /// Listens on a TCP port of all interfaces; port 0 lets the system choose.
    ///
    /// # Errors
    /// [`NetError::AddressInUse`] when the port is taken.
    fn listen(&mut self, port: u16) -> Result<SocketId, NetError>;

    /// Opens a UDP port of all interfaces, for [`Platform::receive_from`] and [`Platform::send_to`] only; port 0 lets
    /// the system choose.
    ///
    /// # Errors
    /// [`NetError::AddressInUse`] when the port is taken.
    fn bind(&mut self, port: u16) -> Result<SocketId, NetError>;

    /// Takes a received datagram: returns the number of bytes in the buffer, and the sender. The rest of a longer
    /// datagram is lost. Returns `None` if there is none.
    ///
    /// # Errors
    /// When the system reports an error of the port; the next call may succeed.
    fn receive_from(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Option<(usize, Endpoint)>, NetError>;

    /// Sends a datagram, which may get lost without a report.
    ///
    /// # Errors
    /// When the system does not accept it; it is then lost.
    fn send_to(&mut self, socket: SocketId, to: Endpoint, bytes: &[u8]) -> Result<(), NetError>;

    /// Returns the port of a listener, or of a bound UDP port.
    ///
    /// # Errors
    /// When the id is stale.
    fn local_port(&mut self, listener: SocketId) -> Result<u16, NetError>;

    /// Takes one waiting connection from a listener, or `None` when there is none.
    ///
    /// # Errors
    /// [`NetError::NoSocketLeft`] when there is one, but no free socket for it; it then waits.
    fn accept(&mut self, listener: SocketId) -> Result<Option<(SocketId, IpAddress)>, NetError>;

    /// Reads the received bytes, at most `buffer.len()`.
    ///
    /// # Errors
    /// When the connection broke.
    fn read(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Transfer, NetError>;

    /// Writes as many bytes as the system accepts now.
    ///
    /// # Errors
    /// When the connection broke.
    fn write(&mut self, socket: SocketId, bytes: &[u8]) -> Result<Transfer, NetError>;

    /// Lets a connection that was begun fail if another participant than this one is at the other end, where the
    /// platform's connections are authenticated.
    #[cfg(feature = "security")]
    fn require(&mut self, _socket: SocketId, _participant: Participant) {}

    /// Returns whether this participant may be at the other end: where connections are authenticated, only the one that
    /// has proved to be there, on a connection that is still sound.
    #[cfg(feature = "security")]
    fn may_be(&self, _socket: SocketId, _participant: Participant) -> bool {
        true
    }

    /// Returns the reason why the platform has ended a connection, if it has.
    #[cfg(feature = "security")]
    fn failure(&self, _socket: SocketId) -> Option<NetError> {
        None
    }

    /// Closes the writing direction of a connection; what was written still reaches the peer.
    fn shut_down_writing(&mut self, socket: SocketId);

    /// Closes a socket and frees its index. Ignores a stale id.
    fn close(&mut self, socket: SocketId);

    /// Sets the events that [`Platform::wait`] waits for on this socket; a new socket has [`Interest::NONE`].
    fn set_interest(&mut self, socket: SocketId, interest: Interest);

    /// Announces the time of the next likely event, for the next [`Platform::wait`] only. A platform that takes long to
    /// wake may spin at that time.
    fn expect(&mut self, _time: Deadline) {}

    /// Waits until a socket matches its interest, or another thread wakes the loop, or `until` has come on
    /// [`Platform::now`]'s clock; calls `ready` for each socket that matches. An error or end of a connection counts as
    /// readable and writable, whichever the interest asks for.
    ///
    /// May return early; must not return later than the platform's timer resolution after `until`.
    fn wait(&mut self, until: Deadline, ready: &mut dyn FnMut(SocketId, Interest));

    /// Returns whether the user (^C) or the system (a shutdown) has asked this program to end.
    fn interrupted(&mut self) -> bool {
        false
    }
}
