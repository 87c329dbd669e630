// SPDX-License-Identifier: Apache-2.0
//! The sockets of one participant.

use std::collections::VecDeque;

use lf_runtime::platform::{Endpoint, Interest, IpAddress, NetError, SocketId};

/// Datagrams in transit to a port: time of arrival, sender and content.
#[derive(Debug, Default)]
pub(crate) struct Arriving(pub(super) Vec<(u64, Endpoint, Vec<u8>)>);

impl Arriving {
    /// Returns the arrival of the first one.
    pub(crate) fn next_time(&self) -> Option<u64> {
        self.0.iter().map(|(at, ..)| *at).min()
    }

    pub(crate) fn take(&mut self, now: u64) -> Option<(Endpoint, Vec<u8>)> {
        let first = (0..self.0.len()).min_by_key(|index| self.0[*index].0)?;
        (self.0[first].0 <= now).then(|| self.0.swap_remove(first)).map(|(_, from, bytes)| (from, bytes))
    }
}

/// The kind of a socket.
#[derive(Debug)]
pub(crate) enum Kind {
    /// A connection attempt, with its outcome and the time at which that is known; `None` for never.
    Connecting { at: Option<u64>, outcome: Result<usize, NetError> },
    /// One side (0 or 1) of a connection; it writes into the pipe of its own number.
    Open { connection: usize, side: usize },
    /// A listener with its accept queue: time, connection and address.
    Listening { port: u16, waiting: VecDeque<(u64, usize, IpAddress)> },
    /// A port for datagrams.
    Datagrams { port: u16, arriving: Arriving },
}

#[derive(Debug)]
pub(crate) struct Socket {
    pub(crate) kind: Kind,
    pub(crate) interest: Interest,
}

/// The sockets of one participant.
#[derive(Debug, Default)]
pub(crate) struct Table {
    /// The slots of sockets: how often each was used, and its socket.
    places: Vec<(u16, Option<Socket>)>,
    /// Whether the participant has ended.
    pub(crate) off: bool,
}

impl Table {
    pub(crate) fn insert(&mut self, kind: Kind) -> Result<SocketId, NetError> {
        if self.off {
            return Err(NetError::Unreachable);
        }
        let free = self.places.iter().position(|(_, place)| place.is_none()).unwrap_or_else(|| {
            self.places.push((0, None));
            self.places.len() - 1
        });
        let index = u16::try_from(free).map_err(|_| NetError::NoSocketLeft)?;
        let (generation, place) = &mut self.places[free];
        *place = Some(Socket { kind, interest: Interest::NONE });
        Ok(SocketId { index, generation: *generation })
    }

    pub(crate) fn get(&mut self, id: SocketId) -> Result<&mut Socket, NetError> {
        match self.places.get_mut(usize::from(id.index)) {
            Some((generation, Some(socket))) if *generation == id.generation => Ok(socket),
            _ => Err(NetError::Stale),
        }
    }

    /// Frees the slot of a socket.
    pub(crate) fn take(&mut self, id: SocketId) -> Option<Socket> {
        self.get(id).ok()?;
        let (generation, place) = &mut self.places[usize::from(id.index)];
        *generation = generation.wrapping_add(1);
        place.take()
    }

    /// Returns the accept queue of this port, if a listener has it.
    pub(crate) fn waiting_at(&mut self, wanted: u16) -> Option<&mut VecDeque<(u64, usize, IpAddress)>> {
        self.places.iter_mut().find_map(|(_, place)| match place {
            Some(Socket { kind: Kind::Listening { port, waiting }, .. }) if *port == wanted => Some(waiting),
            _ => None,
        })
    }

    /// Returns the datagrams for this port, if a socket has it.
    pub(crate) fn arriving_at(&mut self, wanted: u16) -> Option<&mut Arriving> {
        self.places.iter_mut().find_map(|(_, place)| match place {
            Some(Socket { kind: Kind::Datagrams { port, arriving }, .. }) if *port == wanted => Some(arriving),
            _ => None,
        })
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (SocketId, &Socket)> {
        let ids = (0..).zip(&self.places);
        ids.filter_map(|(index, (generation, place))| {
            Some((SocketId { index, generation: *generation }, place.as_ref()?))
        })
    }

    /// Returns a port that no other socket of this participant has, since each has had its own slot.
    pub(crate) fn ephemeral_port(&self) -> u16 {
        let free = self.places.iter().position(|(_, place)| place.is_none()).unwrap_or(self.places.len());
        49_152 + u16::try_from(free).unwrap_or(0) % 16_384
    }
}
