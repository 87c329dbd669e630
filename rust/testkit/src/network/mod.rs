// SPDX-License-Identifier: Apache-2.0
//! TCP and UDP in virtual time, as event loops see them: byte streams of bounded length that arrive late and in pieces,
//! end in order, and break when a socket is closed while bytes are unread; and datagrams.
//!
//! [`Network`] implements TCP and UDP; its [`Medium`] decides latencies and capacities, and sees all events. Times are
//! nanoseconds of virtual time, which the caller supplies.

mod datagrams;
mod pipe;
mod socket;
mod switch;

use lf_runtime::platform::IpAddress;

use crate::random::Random;

pub use switch::Network;

/// The latencies and capacities between the participants of a network, with an observer of its events.
///
/// A connection uses the link of the participant that has opened it, in both directions. A datagram uses the link of
/// whichever of the two participants joined later.
pub trait Medium {
    /// Returns the latency of this number of bytes, sent at once over the link of this participant; 0 bytes stand for a
    /// notification, such as the end of a connection.
    fn latency_ns(&mut self, owner: usize, bytes: usize) -> u64;

    /// Returns the capacity in bytes of each direction of a connection of this participant, written and not read yet;
    /// at least 1.
    fn pipe_bytes(&self, owner: usize) -> usize;

    /// Returns how many bytes a read or write moves that could move `most`, which is at least 1: from 1 to `most`.
    fn piece(&mut self, most: usize) -> usize;

    /// Returns whether a write finds the room behind unread bytes. Otherwise the peer has read right after it.
    fn is_read_in_time(&mut self) -> bool {
        true
    }

    /// Returns how often a datagram arrives: 0 times if it is lost.
    fn copies(&mut self) -> usize;

    /// Returns the generator behind the random numbers of the participants' systems.
    fn random(&mut self) -> &mut Random;

    /// Observes an event.
    fn see(&mut self, _event: Event<'_>, _now: u64) {}
}

/// An event that a medium observes. Connections are numbered consecutively; side 0 is the participant that has opened
/// it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event<'a> {
    /// A connection is being opened.
    Begun {
        /// Its number.
        connection: usize,
        /// The participant that has opened it.
        by: usize,
        /// The participant that listens.
        to: usize,
    },
    /// Bytes were written.
    Written {
        /// The connection.
        connection: usize,
        /// The side that has written.
        side: usize,
        /// The bytes.
        bytes: &'a [u8],
        /// The time at which the reader can read them.
        arrives: u64,
    },
    /// Bytes were read.
    Read {
        /// The connection.
        connection: usize,
        /// The side that had written them.
        side: usize,
        /// The number of bytes.
        bytes: usize,
    },
    /// A write found no room.
    Refused,
}

/// Returns the address of a participant; the number of participants is below 255.
pub fn address_of(participant: usize) -> IpAddress {
    IpAddress::V4(octets_of(participant).into())
}

/// Returns the bytes of that address.
pub fn octets_of(participant: usize) -> [u8; 4] {
    [10, 0, 0, u8::try_from(participant + 1).unwrap_or(u8::MAX)]
}
