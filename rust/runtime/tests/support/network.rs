// SPDX-License-Identifier: Apache-2.0
//! TCP as the event loops see it: byte streams of bounded length that arrive late and in pieces, end in order, and
//! break when a socket is closed while something is unread.

use std::collections::{BTreeMap, VecDeque};
use std::net::{Ipv4Addr, SocketAddrV4};

use lf_runtime::platform::{Interest, NetError, SocketId, Transfer};

use super::random::Random;

/// What the network is like.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// Decides all that is left open: pieces, latencies, whose turn it is.
    pub seed: u64,
    /// Bytes that one direction of a connection holds, written and not read yet.
    pub pipe_bytes: usize,
    /// No piece takes longer from one end to the other.
    pub latency_ns_max: u64,
    /// Reads and writes move as much as there is, not a part of it.
    pub whole: bool,
}

impl Conditions {
    /// Ample pipes, some latency, in pieces.
    pub fn seeded(seed: u64) -> Self {
        Self { seed, pipe_bytes: 1 << 16, latency_ns_max: 200_000, whole: false }
    }
}

/// One direction of a connection.
#[derive(Debug, Default)]
struct Pipe {
    /// What is on its way or has come, each piece with the time at which it comes.
    pieces: VecDeque<(u64, VecDeque<u8>)>,
    bytes: usize,
    /// When the writer's end comes.
    end: Option<u64>,
    /// When the news comes that the connection is broken; what is unread is lost then.
    reset: Option<u64>,
    /// Nobody will read any more.
    deserted: bool,
}

impl Pipe {
    fn latest(&self) -> u64 {
        self.pieces.back().map_or(0, |(at, _)| *at)
    }

    fn is_reset(&self, now: u64) -> bool {
        self.reset.is_some_and(|at| at <= now)
    }

    fn available(&self, now: u64) -> usize {
        self.pieces.iter().take_while(|(at, _)| *at <= now).map(|(_, bytes)| bytes.len()).sum()
    }

    fn is_readable(&self, now: u64) -> bool {
        self.is_reset(now) || self.available(now) > 0 || self.has_ended(now)
    }

    fn has_ended(&self, now: u64) -> bool {
        self.bytes == 0 && self.end.is_some_and(|at| at <= now)
    }

    fn take(&mut self, target: &mut [u8]) {
        for byte in target {
            while self.pieces.front().is_some_and(|(_, bytes)| bytes.is_empty()) {
                self.pieces.pop_front();
            }
            *byte = self.pieces.front_mut().and_then(|(_, bytes)| bytes.pop_front()).expect("as many are available");
            self.bytes -= 1;
        }
    }

    fn times(&self) -> impl Iterator<Item = u64> {
        self.pieces.iter().map(|(at, _)| *at).chain(self.end).chain(self.reset)
    }
}

#[derive(Debug)]
pub(super) enum Kind {
    /// The outcome is known at the time.
    Connecting {
        at: Option<u64>,
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
    Datagrams(super::datagrams::Port),
}

#[derive(Debug)]
struct Socket {
    kind: Kind,
    interest: Interest,
}

/// The sockets of one participant.
#[derive(Debug, Default)]
struct Table {
    places: Vec<(u16, Option<Socket>)>,
    off: bool,
}

/// All sockets and connections of a world. Participants are numbered; each has an address of its own.
#[derive(Debug)]
pub struct Network {
    pub(super) conditions: Conditions,
    connections: Vec<[Pipe; 2]>,
    tables: BTreeMap<usize, Table>,
    /// Bytes that have been written, in all.
    pub written: u64,
}

/// The address of a participant.
pub fn address_of(participant: usize) -> Ipv4Addr {
    Ipv4Addr::new(10, 0, 0, u8::try_from(participant + 1).expect("there are few participants"))
}

impl Network {
    pub fn new(conditions: Conditions) -> Self {
        Self { conditions, connections: Vec::new(), tables: BTreeMap::new(), written: 0 }
    }

    /// There is a participant with this number. Before it listens, connections to it are refused.
    pub fn switch_on(&mut self, owner: usize) {
        self.tables.entry(owner).or_default();
    }

    pub(super) fn latency(&self, random: &mut Random) -> u64 {
        random.below(self.conditions.latency_ns_max + 1)
    }

    pub(super) fn insert(&mut self, owner: usize, kind: Kind) -> Result<SocketId, NetError> {
        let table = self.tables.entry(owner).or_default();
        if table.off {
            return Err(NetError::Unreachable);
        }
        let socket = Socket { kind, interest: Interest::NONE };
        let free = table.places.iter().position(|(_, place)| place.is_none());
        let index = free.unwrap_or_else(|| {
            table.places.push((0, None));
            table.places.len() - 1
        });
        table.places[index].1 = Some(socket);
        Ok(SocketId { index: u16::try_from(index).expect("few sockets"), generation: table.places[index].0 })
    }

    pub(super) fn kind(&mut self, owner: usize, id: SocketId) -> Result<&mut Kind, NetError> {
        self.socket(owner, id).map(|socket| &mut socket.kind)
    }

    /// What the sockets of a participant are.
    pub(super) fn kinds_of(&mut self, owner: usize) -> impl Iterator<Item = &mut Kind> {
        let places = self.tables.get_mut(&owner).into_iter().flat_map(|table| &mut table.places);
        places.filter_map(|(_, place)| place.as_mut()).map(|socket| &mut socket.kind)
    }

    fn socket(&mut self, owner: usize, id: SocketId) -> Result<&mut Socket, NetError> {
        let place = self.tables.get_mut(&owner).and_then(|table| table.places.get_mut(usize::from(id.index)));
        match place {
            Some((generation, Some(socket))) if *generation == id.generation => Ok(socket),
            _ => Err(NetError::Stale),
        }
    }

    pub fn listen(&mut self, owner: usize, port: u16) -> Result<SocketId, NetError> {
        // Port 0 stands for one that nobody else has.
        let own = self.tables.get(&owner).map_or(0, |table| table.places.len());
        let port = if port == 0 { 49_152 + u16::try_from(own).expect("there are few sockets") } else { port };
        self.insert(owner, Kind::Listening { port, waiting: VecDeque::new() })
    }

    pub fn local_port(&mut self, owner: usize, id: SocketId) -> Result<u16, NetError> {
        match self.socket(owner, id)?.kind {
            Kind::Listening { port, .. } => Ok(port),
            Kind::Datagrams(ref port) => Ok(port.number),
            _ => Err(NetError::Stale),
        }
    }

    pub fn connect(
        &mut self,
        owner: usize,
        to: SocketAddrV4,
        now: u64,
        random: &mut Random,
    ) -> Result<SocketId, NetError> {
        let (there, back) = (now + self.latency(random), self.latency(random));
        let number = self.connections.len();
        let host = self.tables.iter_mut().find(|(participant, _)| address_of(**participant) == *to.ip());
        let Some((_, table)) = host.filter(|(_, table)| !table.off) else {
            // Nobody answers at all.
            return self.insert(owner, Kind::Connecting { at: None, outcome: Err(NetError::Unreachable) });
        };
        let waiting = table.places.iter_mut().find_map(|(_, place)| match place {
            Some(Socket { kind: Kind::Listening { port, waiting }, .. }) if *port == to.port() => Some(waiting),
            _ => None,
        });
        let outcome = match waiting {
            Some(waiting) => {
                let at = waiting.back().map_or(0, |(at, ..)| *at).max(there);
                waiting.push_back((at, number, address_of(owner)));
                self.connections.push([Pipe::default(), Pipe::default()]);
                Ok(number)
            }
            None => Err(NetError::Refused),
        };
        self.insert(owner, Kind::Connecting { at: Some(there + back), outcome })
    }

    pub fn connected(&mut self, owner: usize, id: SocketId, now: u64) -> Result<(), NetError> {
        let socket = self.socket(owner, id)?;
        match socket.kind {
            Kind::Connecting { at: Some(at), outcome } if at <= now => {
                let connection = outcome?;
                socket.kind = Kind::Open { connection, side: 0 };
                Ok(())
            }
            _ => Err(NetError::Stale),
        }
    }

    pub fn accept(&mut self, owner: usize, id: SocketId, now: u64) -> Result<Option<(SocketId, Ipv4Addr)>, NetError> {
        let Kind::Listening { waiting, .. } = &mut self.socket(owner, id)?.kind else { return Err(NetError::Stale) };
        if waiting.front().is_none_or(|(at, ..)| *at > now) {
            return Ok(None);
        }
        let (_, connection, peer) = waiting.pop_front().expect("it was just looked at");
        Ok(Some((self.insert(owner, Kind::Open { connection, side: 1 })?, peer)))
    }

    /// The connection of an open socket, and the side.
    fn open(&mut self, owner: usize, id: SocketId) -> Result<(usize, usize), NetError> {
        match self.socket(owner, id)?.kind {
            Kind::Open { connection, side } => Ok((connection, side)),
            _ => Err(NetError::Stale),
        }
    }

    pub fn read(
        &mut self,
        owner: usize,
        id: SocketId,
        target: &mut [u8],
        now: u64,
        random: &mut Random,
    ) -> Result<Transfer, NetError> {
        let (connection, side) = self.open(owner, id)?;
        let whole = self.conditions.whole;
        let pipe = &mut self.connections[connection][1 - side];
        if pipe.is_reset(now) {
            return Err(NetError::Reset);
        }
        let most = pipe.available(now).min(target.len());
        if most == 0 {
            return Ok(if pipe.has_ended(now) { Transfer::Closed } else { Transfer::WouldBlock });
        }
        let count = if whole { most } else { 1 + random.index(most) };
        pipe.take(&mut target[..count]);
        Ok(Transfer::Bytes(count))
    }

    pub fn write(
        &mut self,
        owner: usize,
        id: SocketId,
        bytes: &[u8],
        now: u64,
        random: &mut Random,
    ) -> Result<Transfer, NetError> {
        let (connection, side) = self.open(owner, id)?;
        let at = now + self.latency(random);
        let Conditions { pipe_bytes, whole, .. } = self.conditions;
        let pipes = &mut self.connections[connection];
        if pipes[1 - side].is_reset(now) || pipes[side].end.is_some() {
            return Err(NetError::Reset);
        }
        let most = (pipe_bytes - pipes[side].bytes).min(bytes.len());
        if pipes[side].deserted {
            // The peer's system answers to what nobody reads any more by breaking the connection.
            pipes[1 - side].reset.get_or_insert(at);
            return Ok(Transfer::Bytes(bytes.len()));
        }
        if most == 0 {
            return Ok(Transfer::WouldBlock);
        }
        let count = if whole { most } else { 1 + random.index(most) };
        let at = at.max(pipes[side].latest());
        pipes[side].pieces.push_back((at, bytes[..count].iter().copied().collect()));
        pipes[side].bytes += count;
        self.written += count as u64;
        Ok(Transfer::Bytes(count))
    }

    pub fn shut_down_writing(&mut self, owner: usize, id: SocketId, now: u64, random: &mut Random) {
        let at = now + self.latency(random);
        if let Ok((connection, side)) = self.open(owner, id) {
            let pipe = &mut self.connections[connection][side];
            let at = at.max(pipe.latest());
            pipe.end.get_or_insert(at);
        }
    }

    pub fn close(&mut self, owner: usize, id: SocketId, now: u64, random: &mut Random) {
        if self.socket(owner, id).is_err() {
            return;
        }
        let Some(table) = self.tables.get_mut(&owner) else { return };
        let (generation, place) = &mut table.places[usize::from(id.index)];
        *generation = generation.wrapping_add(1);
        match place.take().map(|socket| socket.kind) {
            Some(Kind::Open { connection, side }) => self.desert(connection, side, now, random),
            Some(Kind::Connecting { outcome: Ok(connection), .. }) => self.desert(connection, 0, now, random),
            Some(Kind::Listening { waiting, .. }) => {
                for (_, connection, _) in waiting {
                    let at = now + self.latency(random);
                    self.connections[connection][1].reset.get_or_insert(at);
                }
            }
            _ => {}
        }
    }

    /// One side has closed its socket: the other sees the end, or a broken connection if something was unread.
    fn desert(&mut self, connection: usize, side: usize, now: u64, random: &mut Random) {
        let at = now + self.latency(random);
        let pipes = &mut self.connections[connection];
        pipes[1 - side].deserted = true;
        if pipes[1 - side].bytes > 0 {
            pipes[side].reset.get_or_insert(at);
        } else {
            let at = at.max(pipes[side].latest());
            pipes[side].end.get_or_insert(at);
        }
    }

    /// The participant is no more: its system closes its sockets.
    pub fn switch_off(&mut self, owner: usize, now: u64, random: &mut Random) {
        let table = self.tables.entry(owner).or_default();
        table.off = true;
        let ids: Vec<_> = (0..)
            .zip(&table.places)
            .filter(|(_, (_, place))| place.is_some())
            .map(|(index, (generation, _))| SocketId { index, generation: *generation })
            .collect();
        for id in ids {
            self.close(owner, id, now, random);
        }
    }

    pub fn set_interest(&mut self, owner: usize, id: SocketId, interest: Interest) {
        if let Ok(socket) = self.socket(owner, id) {
            socket.interest = interest;
        }
    }

    /// The sockets of a participant that are as their interest says.
    pub fn ready(&self, owner: usize, now: u64) -> Vec<(SocketId, Interest)> {
        let Some(table) = self.tables.get(&owner) else { return Vec::new() };
        let mut ready = Vec::new();
        for (index, (generation, place)) in (0..).zip(&table.places) {
            let Some(socket) = place.as_ref().filter(|socket| socket.interest != Interest::NONE) else { continue };
            let (readable, writable, broken) = self.state(&socket.kind, now);
            let wanted = socket.interest;
            let is = Interest {
                readable: (wanted.readable && readable) || broken,
                writable: (wanted.writable && writable) || broken,
            };
            if is != Interest::NONE {
                ready.push((SocketId { index, generation: *generation }, is));
            }
        }
        ready
    }

    /// Whether it is readable, writable, broken.
    fn state(&self, kind: &Kind, now: u64) -> (bool, bool, bool) {
        match kind {
            Kind::Connecting { at, .. } => (false, at.is_some_and(|at| at <= now), false),
            Kind::Open { connection, side } => {
                let pipes = &self.connections[*connection];
                let broken = pipes[1 - side].is_reset(now);
                let room = pipes[*side].bytes < self.conditions.pipe_bytes || pipes[*side].deserted;
                (pipes[1 - side].is_readable(now), room, broken)
            }
            Kind::Listening { waiting, .. } => (waiting.front().is_some_and(|(at, ..)| *at <= now), false, false),
            Kind::Datagrams(port) => (port.times().any(|at| at <= now), false, false),
        }
    }

    /// When the next piece of anything comes after `now`.
    pub fn next_time(&self, now: u64) -> Option<u64> {
        let sockets = self.tables.values().flat_map(|table| &table.places).filter_map(|(_, place)| place.as_ref());
        let of_sockets = sockets.flat_map(|socket| match &socket.kind {
            Kind::Connecting { at, .. } => at.iter().copied().collect::<Vec<_>>(),
            Kind::Listening { waiting, .. } => waiting.iter().map(|(at, ..)| *at).collect(),
            Kind::Datagrams(port) => port.times().collect(),
            Kind::Open { .. } => Vec::new(),
        });
        let pipes = self.connections.iter().flatten().filter(|pipe| !pipe.deserted);
        pipes.flat_map(Pipe::times).chain(of_sockets).filter(|at| *at > now).min()
    }
}
