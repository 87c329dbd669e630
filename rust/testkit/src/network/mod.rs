// SPDX-License-Identifier: Apache-2.0
//! TCP and UDP in virtual time, as event loops see them: byte streams of bounded length that arrive late and in pieces,
//! end in order, and break when a socket is closed while something is unread; and datagrams.
//!
//! [`Network`] knows what TCP and UDP do; the [`Medium`] that it is made with says how long things take and how much
//! fits, and sees what happens. Times are nanoseconds of virtual time, which whoever calls tells.

mod datagrams;
mod pipe;
mod socket;
mod switch;

use lf_runtime::platform::IpAddress;

use crate::random::Random;

pub use switch::Network;

/// What lies between the participants of a network, and who looks on.
///
/// A connection is that of the participant that has begun it: which way its bytes go makes no difference to its wire.
/// Datagrams take the wire of the one of both that has joined later.
pub trait Medium {
    /// How long so many bytes are on their way at once, over the wire of this participant; 0 bytes stand for news,
    /// as of the end of a connection.
    fn latency_ns(&mut self, owner: usize, bytes: usize) -> u64;

    /// How many bytes each direction of a connection of this participant holds, written and not read yet; at least 1.
    fn pipe_bytes(&self, owner: usize) -> usize;

    /// How many bytes a read or write moves that could move `most`, which is at least 1: from 1 to `most`.
    fn piece(&mut self, most: usize) -> usize;

    /// How often a datagram arrives: 0 times when it gets lost.
    fn copies(&mut self) -> usize;

    /// What decides by chance what participants ask their systems for.
    fn random(&mut self) -> &mut Random;

    /// Something has happened.
    fn see(&mut self, _event: Event<'_>, _now: u64) {}
}

/// What a medium sees. Connections are numbered one after the other; side 0 is the participant that has begun it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event<'a> {
    /// A connection begins.
    Begun {
        /// Its number.
        connection: usize,
        /// The participant that has begun it.
        by: usize,
        /// The participant that listens.
        to: usize,
    },
    /// Bytes were written.
    Written {
        /// Over which connection.
        connection: usize,
        /// Who has written.
        side: usize,
        /// What.
        bytes: &'a [u8],
        /// When they are there for the reader.
        arrives: u64,
    },
    /// Bytes were read.
    Read {
        /// Over which connection.
        connection: usize,
        /// Who had written them.
        side: usize,
        /// How many.
        bytes: usize,
    },
    /// A write has found no room.
    Refused,
}

/// The address of a participant; the number of participants is below 255.
pub fn address_of(participant: usize) -> IpAddress {
    IpAddress::V4([10, 0, 0, u8::try_from(participant + 1).unwrap_or(u8::MAX)].into())
}
