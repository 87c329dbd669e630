// SPDX-License-Identifier: Apache-2.0
//! The interface between the RTI and its owner.

use core::fmt;

use lf_wire::Message;

use super::log_event::RtiEvent;
use crate::FederateId;

/// A connection, as an index into the owner's table: below the number of connections in the RTI's storage.
///
/// The owner may reuse a number for a new connection as soon as both sides have closed the old one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ConnectionId(pub usize);

impl fmt::Display for ConnectionId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// The connections, as the RTI sees them.
pub trait Outlet {
    /// Returns the number of bytes that can be sent on this connection now. Once nothing is pending on it, there has to
    /// be room for the longest message that the RTI's limits accept; otherwise that message would be held back without
    /// end.
    fn room(&self, connection: ConnectionId) -> usize;

    /// Puts a message behind what is pending on the connection. The RTI calls it only if there is room for the message.
    fn send(&mut self, connection: ConnectionId, message: &Message<'_>);

    /// Returns whether the peer may be this federate: where connections are authenticated, it has proved that it is.
    fn may_be(&self, connection: ConnectionId, federate: FederateId) -> bool {
        let _ = (connection, federate);
        true
    }

    /// Ends our direction once all that is pending has been sent. The owner still reads the peer, until it closes.
    fn half_close(&mut self, connection: ConnectionId);

    /// Closes the connection once all that is pending has been sent. The RTI does not know it any longer: ignore what
    /// the peer still sends, and do not report its end with [`handle_disconnect`](super::Rti::handle_disconnect).
    fn close(&mut self, connection: ConnectionId);

    /// Logs an event.
    fn log(&mut self, event: RtiEvent<'_>);
}

/// The outcome of input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// This many bytes at the front are consumed, at least one. There may be more messages behind them.
    Consumed(usize),
    /// A message begins here, but is not complete. It has at least this many bytes, more than there are. If nothing
    /// more will come, call [`handle_disconnect`](super::Rti::handle_disconnect).
    Incomplete(usize),
    /// The message at the front has to wait until there is room on the named connection. Keep it, do not read its own
    /// connection meanwhile, and offer it again after [`handle_writable`](super::Rti::handle_writable) for the named
    /// one, or when either side has closed any direction of the named one.
    Blocked(ConnectionId),
    /// The message at the front has to wait until the federate on the named connection, its destination, has proceeded.
    /// Keep it, do not read its own connection meanwhile, and offer it again each time that input of the named
    /// connection has been offered, with any outcome; when either side has closed any direction of that connection; and
    /// once [`stop_tag`](super::Rti::stop_tag) is known. Connections never wait for each other in a circle.
    Held(ConnectionId),
    /// Like [`Held`](Self::Held), but go on reading its own connection, and offer the message also when more has come
    /// there, or nothing more will: the RTI looks for a federate's answer to a stop request behind the message.
    HeldReadOn(ConnectionId),
    /// The connection is closed. Drop its input.
    Closed,
}
