// SPDX-License-Identifier: Apache-2.0
//! What the RTI asks of its owner, and what it answers.

use core::fmt;

use lf_wire::Message;

use super::notice::Notice;

/// A connection, by its place in the owner's table: below the number of connections in the RTI's storage.
///
/// A number may be given to a new connection as soon as the old one is closed on both sides, by whomever.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ConnectionId(pub usize);

impl fmt::Display for ConnectionId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// The connections, as the RTI sees them.
pub trait Outlet {
    /// Bytes that can be sent on this connection now. Once nothing is pending on it, there has to be room for the
    /// longest message that the RTI's limits accept; otherwise that message would be held back for ever.
    fn room(&self, connection: ConnectionId) -> usize;

    /// Puts a message behind what is pending on the connection. Only called when there is room for it.
    fn send(&mut self, connection: ConnectionId, message: &Message<'_>);

    /// Ends our direction once all that is pending has been sent. The peer is still read, until it closes.
    fn half_close(&mut self, connection: ConnectionId);

    /// Closes the connection once all that is pending has been sent. The RTI knows it no longer; what the peer still
    /// sends is not wanted, and its end is not reported with [`handle_disconnect`](super::Rti::handle_disconnect).
    fn close(&mut self, connection: ConnectionId);

    /// Something happened that people may want to know.
    fn notice(&mut self, notice: Notice<'_>);
}

/// What became of input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// This many bytes at the front are done with, at least one. There may be more messages behind them.
    Consumed(usize),
    /// A message begins here, but is not whole. It has at least this many bytes, more than there are. If nothing more
    /// will come, [`handle_disconnect`](super::Rti::handle_disconnect) is due.
    Incomplete(usize),
    /// The message at the front has to wait until there is room on the named connection. Keep it, do not read its own
    /// connection meanwhile, and offer it again after [`handle_writable`](super::Rti::handle_writable) for the named
    /// one, or when the named one is closed in either direction, by whomever.
    Blocked(ConnectionId),
    /// The message at the front has to wait until the federate on the named connection, its destination, has got on.
    /// Keep it, do not read its own connection meanwhile, and offer it again each time that input of the named
    /// connection has been offered, whatever has become of that; when that connection is closed in either direction,
    /// by whomever; and once [`stop_tag`](super::Rti::stop_tag) is known. Connections never wait for each other in a
    /// circle.
    Held(ConnectionId),
    /// As [`Held`](Self::Held), but go on reading its own connection, and offer the message also when more has come
    /// there, or nothing more will: a federate's answer to a stop request is looked for behind the message.
    HeldReadOn(ConnectionId),
    /// The connection is closed. Forget its input.
    Closed,
}
