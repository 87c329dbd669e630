// SPDX-License-Identifier: Apache-2.0
//! TCP as the event loops see it: byte streams of bounded length that arrive late and in pieces, end in order, and
//! break when a socket is closed while something is unread.

use std::collections::VecDeque;
use std::net::{Ipv4Addr, SocketAddrV4};

use lf_runtime::platform::{Interest, NetError, SocketId, Transfer};

use super::datagrams::Arriving;
use super::pipe::Pipe;
use crate::check::Watch;
use crate::random::Random;
use crate::scenario::{Conditions, Wire};

/// What a socket is.
#[derive(Debug)]
pub(super) enum Kind {
    /// The outcome is known at the time.
    Connecting {
        at: u64,
        outcome: Result<usize, NetError>,
    },
    /// One side (0 or 1) of a connection; it writes into the pipe of its own number.
    Open {
        connection: usize,
        side: usize,
    },
    Listening {
        port: u16,
        waiting: VecDeque<(u64, usize, Ipv4Addr)>,
    },
    Datagrams {
        port: u16,
        arriving: Arriving,
    },
}

#[derive(Debug)]
pub(super) struct Socket {
    pub(super) kind: Kind,
    interest: Interest,
}

#[derive(Debug)]
struct Link {
    pipes: [Pipe; 2],
    owners: [usize; 2],
    interests: [Interest; 2],
}

/// The sockets of one participant.
#[derive(Debug, Default)]
struct Table {
    places: Vec<(u16, Option<Socket>)>,
    off: bool,
}

/// All sockets and connections of a world.
#[derive(Debug)]
pub(crate) struct Network {
    wires: Vec<Wire>,
    pieces: bool,
    random: Random,
    links: Vec<Link>,
    tables: Vec<Table>,
    /// Participants that have something to do at a time, since the last look.
    pub(super) wakes: Vec<(usize, u64)>,
    /// Sees all bytes that are written.
    pub(crate) watch: Watch,
    /// How often a write found no room.
    pub(crate) refused_writes: u64,
}

/// The address of a participant.
pub(crate) fn address_of(participant: usize) -> Ipv4Addr {
    Ipv4Addr::new(10, 0, 0, u8::try_from(participant + 1).unwrap_or(u8::MAX))
}

impl Network {
    pub(super) fn new(conditions: &Conditions, seed: u64) -> Self {
        let count = conditions.hosts.len();
        Self {
            wires: conditions.hosts.iter().map(|host| host.link.clone()).collect(),
            pieces: conditions.pieces,
            random: Random::new(seed),
            links: Vec::new(),
            tables: (0..count).map(|_| Table::default()).collect(),
            wakes: Vec::new(),
            watch: Watch::new(count - 1),
            refused_writes: 0,
        }
    }

    /// What a piece of so many bytes takes on the wire of a federate.
    pub(super) fn latency(&mut self, federate: usize, bytes: usize) -> u64 {
        let wire = &self.wires[federate];
        let jitter = self.random.time(0, wire.jitter);
        let jitter = if self.random.percent(wire.slow_percent) { 10 * jitter } else { jitter };
        let transfer = wire.ns_per_byte.saturating_mul(i64::try_from(bytes).unwrap_or(0));
        u64::try_from(wire.latency + jitter + transfer).unwrap_or(0)
    }

    pub(super) fn host_count(&self) -> usize {
        self.tables.len()
    }

    pub(super) fn chance(&mut self, percent: u64) -> bool {
        self.random.percent(percent)
    }

    /// What the sockets of a participant are.
    pub(super) fn kinds_of(&mut self, owner: usize) -> impl Iterator<Item = &mut Kind> {
        self.tables[owner].places.iter_mut().filter_map(|(_, place)| place.as_mut()).map(|socket| &mut socket.kind)
    }

    /// Numbers that the seed decides.
    pub(super) fn random_bytes(&mut self, buffer: &mut [u8]) {
        for byte in buffer {
            *byte = u8::try_from(self.random.below(256)).unwrap_or(0);
        }
    }

    pub(super) fn insert(&mut self, owner: usize, kind: Kind) -> Result<SocketId, NetError> {
        let table = &mut self.tables[owner];
        if table.off {
            return Err(NetError::Unreachable);
        }
        let free = table.places.iter().position(|(_, place)| place.is_none()).unwrap_or_else(|| {
            table.places.push((0, None));
            table.places.len() - 1
        });
        table.places[free].1 = Some(Socket { kind, interest: Interest::NONE });
        let index = u16::try_from(free).map_err(|_| NetError::NoSocketLeft)?;
        Ok(SocketId { index, generation: table.places[free].0 })
    }

    pub(super) fn socket(&mut self, owner: usize, id: SocketId) -> Result<&mut Socket, NetError> {
        match self.tables[owner].places.get_mut(usize::from(id.index)) {
            Some((generation, Some(socket))) if *generation == id.generation => Ok(socket),
            _ => Err(NetError::Stale),
        }
    }

    pub(super) fn listen(&mut self, owner: usize, port: u16) -> Result<SocketId, NetError> {
        self.insert(owner, Kind::Listening { port, waiting: VecDeque::new() })
    }

    pub(super) fn local_port(&mut self, owner: usize, id: SocketId) -> Result<u16, NetError> {
        match self.socket(owner, id)?.kind {
            Kind::Listening { port, .. } | Kind::Datagrams { port, .. } => Ok(port),
            _ => Err(NetError::Stale),
        }
    }

    pub(super) fn connect(&mut self, owner: usize, to: SocketAddrV4, now: u64) -> Result<SocketId, NetError> {
        let there = now + self.latency(owner, 0);
        let outcome_at = there + self.latency(owner, 0);
        let number = self.links.len();
        let host = (0..self.tables.len()).find(|host| address_of(*host) == *to.ip() && !self.tables[*host].off);
        let places = host.map(|host| &mut self.tables[host].places);
        let waiting = places.into_iter().flatten().find_map(|(_, place)| match place {
            Some(Socket { kind: Kind::Listening { port, waiting }, .. }) if *port == to.port() => Some(waiting),
            _ => None,
        });
        let outcome = match (waiting, host) {
            (Some(waiting), Some(host)) => {
                let at = waiting.back().map_or(0, |(at, ..)| *at).max(there);
                waiting.push_back((at, number, address_of(owner)));
                self.wakes.push((host, at));
                self.links.push(Link {
                    pipes: [Pipe::default(), Pipe::default()],
                    owners: [owner, host],
                    interests: [Interest::NONE; 2],
                });
                self.watch.begin(number, owner);
                Ok(number)
            }
            _ => Err(NetError::Refused),
        };
        self.insert(owner, Kind::Connecting { at: outcome_at, outcome })
    }

    pub(super) fn connected(&mut self, owner: usize, id: SocketId, now: u64) -> Result<(), NetError> {
        let socket = self.socket(owner, id)?;
        match socket.kind {
            Kind::Connecting { at, outcome } if at <= now => {
                socket.kind = Kind::Open { connection: outcome?, side: 0 };
                Ok(())
            }
            _ => Err(NetError::Stale),
        }
    }

    pub(super) fn accept(
        &mut self,
        owner: usize,
        id: SocketId,
        now: u64,
    ) -> Result<Option<(SocketId, Ipv4Addr)>, NetError> {
        let Kind::Listening { waiting, .. } = &mut self.socket(owner, id)?.kind else { return Err(NetError::Stale) };
        let has_come = waiting.front().is_some_and(|(at, ..)| *at <= now);
        match if has_come { waiting.pop_front() } else { None } {
            None => Ok(None),
            Some((_, connection, peer)) => Ok(Some((self.insert(owner, Kind::Open { connection, side: 1 })?, peer))),
        }
    }

    /// The connection of an open socket, and the side.
    fn open(&mut self, owner: usize, id: SocketId) -> Result<(usize, usize), NetError> {
        match self.socket(owner, id)?.kind {
            Kind::Open { connection, side } => Ok((connection, side)),
            _ => Err(NetError::Stale),
        }
    }

    /// How much of what could be moved is moved at once.
    fn piece(&mut self, most: usize) -> usize {
        if self.pieces && self.random.percent(50) { self.random.count(1, most) } else { most }
    }

    pub(super) fn read(
        &mut self,
        owner: usize,
        id: SocketId,
        target: &mut [u8],
        now: u64,
    ) -> Result<Transfer, NetError> {
        let (connection, side) = self.open(owner, id)?;
        let pipe = &self.links[connection].pipes[1 - side];
        if pipe.is_reset(now) {
            return Err(NetError::Reset);
        }
        let most = pipe.available(now).min(target.len());
        if most == 0 {
            return Ok(if pipe.has_ended(now) { Transfer::Closed } else { Transfer::WouldBlock });
        }
        let count = self.piece(most);
        let back = self.latency(self.links[connection].owners[0], 0);
        let link = &mut self.links[connection];
        link.pipes[1 - side].take(&mut target[..count]);
        self.watch.read(connection, 1 - side, count, now);
        if link.interests[1 - side].writable {
            // The news of the room travels back.
            self.wakes.push((link.owners[1 - side], now + back));
        }
        Ok(Transfer::Bytes(count))
    }

    pub(super) fn write(&mut self, owner: usize, id: SocketId, bytes: &[u8], now: u64) -> Result<Transfer, NetError> {
        let (connection, side) = self.open(owner, id)?;
        let federate = self.links[connection].owners[0];
        let link = &mut self.links[connection];
        if link.pipes[1 - side].is_reset(now) || link.pipes[side].end.is_some() {
            return Err(NetError::Reset);
        }
        if link.pipes[side].deserted {
            // The peer's system answers to what nobody reads any more by breaking the connection.
            let at = now + self.latency(federate, 0);
            self.break_off(connection, 1 - side, at);
            return Ok(Transfer::Bytes(bytes.len()));
        }
        let most = self.wires[federate].socket_bytes.saturating_sub(link.pipes[side].len()).min(bytes.len());
        if most == 0 {
            self.refused_writes += 1;
            return Ok(Transfer::WouldBlock);
        }
        let count = self.piece(most);
        let at = now + self.latency(federate, count);
        let link = &mut self.links[connection];
        let at = link.pipes[side].after_all(at);
        link.pipes[side].push(at, &bytes[..count]);
        if link.interests[1 - side].readable {
            self.wakes.push((link.owners[1 - side], at));
        }
        self.watch.write(connection, side, &bytes[..count], now);
        Ok(Transfer::Bytes(count))
    }

    /// Who reads this direction learns then that the connection is broken.
    fn break_off(&mut self, connection: usize, direction: usize, at: u64) {
        let link = &mut self.links[connection];
        link.pipes[direction].reset.get_or_insert(at);
        self.wakes.push((link.owners[1 - direction], at));
    }

    fn end(&mut self, connection: usize, direction: usize, at: u64) {
        let link = &mut self.links[connection];
        let at = link.pipes[direction].after_all(at);
        link.pipes[direction].end.get_or_insert(at);
        self.wakes.push((link.owners[1 - direction], at));
    }

    pub(super) fn shut_down_writing(&mut self, owner: usize, id: SocketId, now: u64) {
        if let Ok((connection, side)) = self.open(owner, id) {
            let at = now + self.latency(self.links[connection].owners[0], 0);
            self.end(connection, side, at);
        }
    }

    pub(super) fn close(&mut self, owner: usize, id: SocketId, now: u64) {
        if self.socket(owner, id).is_err() {
            return;
        }
        let (generation, place) = &mut self.tables[owner].places[usize::from(id.index)];
        *generation = generation.wrapping_add(1);
        match place.take().map(|socket| socket.kind) {
            Some(Kind::Open { connection, side }) => self.desert(connection, side, now),
            Some(Kind::Connecting { outcome: Ok(connection), .. }) => self.desert(connection, 0, now),
            Some(Kind::Listening { waiting, .. }) => {
                for (_, connection, _) in waiting {
                    let at = now + self.latency(self.links[connection].owners[0], 0);
                    self.break_off(connection, 1, at);
                }
            }
            _ => {}
        }
    }

    /// One side has closed its socket: the other sees the end, or a broken connection if something was unread.
    fn desert(&mut self, connection: usize, side: usize, now: u64) {
        let at = now + self.latency(self.links[connection].owners[0], 0);
        let link = &mut self.links[connection];
        link.interests[side] = Interest::NONE;
        link.pipes[1 - side].deserted = true;
        if link.pipes[1 - side].len() > 0 {
            self.break_off(connection, side, at);
        } else {
            self.end(connection, side, at);
        }
        let writer = self.links[connection].owners[1 - side];
        self.wakes.push((writer, at));
    }

    fn sockets_of(&self, owner: usize) -> Vec<SocketId> {
        (0..)
            .zip(&self.tables[owner].places)
            .filter(|(_, (_, place))| place.is_some())
            .map(|(index, (generation, _))| SocketId { index, generation: *generation })
            .collect()
    }

    /// The participant is no more: its system closes its sockets.
    pub(super) fn switch_off(&mut self, owner: usize, now: u64) {
        for id in self.sockets_of(owner) {
            self.close(owner, id, now);
        }
        self.tables[owner].off = true;
    }

    /// All connections of a participant break, for both sides.
    pub(super) fn break_all(&mut self, owner: usize, now: u64) {
        for id in self.sockets_of(owner) {
            if let Ok((connection, _)) = self.open(owner, id) {
                self.break_off(connection, 0, now);
                self.break_off(connection, 1, now);
            }
        }
    }

    pub(super) fn set_interest(&mut self, owner: usize, id: SocketId, interest: Interest) {
        let Ok(socket) = self.socket(owner, id) else { return };
        socket.interest = interest;
        if let Kind::Open { connection, side } = socket.kind {
            self.links[connection].interests[side] = interest;
        }
    }

    /// When a socket first is readable, and when it is writable.
    fn times(&self, kind: &Kind) -> (Option<u64>, Option<u64>, Option<u64>) {
        match kind {
            Kind::Connecting { at, .. } => (None, Some(*at), None),
            Kind::Listening { waiting, .. } => (waiting.front().map(|(at, ..)| *at), None, None),
            Kind::Datagrams { arriving, .. } => (arriving.next_time(), None, None),
            Kind::Open { connection, side } => {
                let link = &self.links[*connection];
                let (incoming, outgoing) = (&link.pipes[1 - side], &link.pipes[*side]);
                let room = outgoing.deserted || outgoing.len() < self.wires[link.owners[0]].socket_bytes;
                (incoming.next_time(), room.then_some(0), incoming.reset)
            }
        }
    }

    /// The sockets of a participant that are as their interest says.
    pub(super) fn ready(&self, owner: usize, now: u64, mut report: impl FnMut(SocketId, Interest)) {
        for (index, (generation, place)) in (0..).zip(&self.tables[owner].places) {
            let Some(socket) = place.as_ref().filter(|socket| socket.interest != Interest::NONE) else { continue };
            let (readable, writable, broken) = self.times(&socket.kind);
            let due = |at: Option<u64>| at.is_some_and(|at| at <= now);
            let broken = due(broken);
            let is = Interest {
                readable: (socket.interest.readable && due(readable)) || broken,
                writable: (socket.interest.writable && due(writable)) || broken,
            };
            if is != Interest::NONE {
                report(SocketId { index, generation: *generation }, is);
            }
        }
    }

    /// When the first socket of a participant is as its interest says.
    pub(super) fn next_ready(&self, owner: usize) -> Option<u64> {
        let sockets = self.tables[owner].places.iter().filter_map(|(_, place)| place.as_ref());
        let times = sockets.filter(|socket| socket.interest != Interest::NONE).flat_map(|socket| {
            let (readable, writable, broken) = self.times(&socket.kind);
            [readable.filter(|_| socket.interest.readable), writable.filter(|_| socket.interest.writable), broken]
        });
        times.flatten().min()
    }
}
