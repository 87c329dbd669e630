// SPDX-License-Identifier: Apache-2.0
//! All sockets and connections.

use std::collections::VecDeque;

use lf_runtime::platform::{Endpoint, Interest, IpAddress, NetError, SocketId, Transfer};

use super::pipe::Pipe;
use super::socket::{Kind, Socket, Table};
use super::{Event, Medium, address_of};

/// The number of unread bytes for which every system has memory: what opens a connection finds room at once.
const LEAST_ROOM: usize = 64;

/// A connection: side 0 is the participant that has opened it. Each side writes into the pipe of its own number.
#[derive(Debug)]
struct Link {
    pipes: [Pipe; 2],
    owners: [usize; 2],
    interests: [Interest; 2],
}

/// All sockets and connections of some participants. Their calls are those of
/// [`Platform`](lf_runtime::platform::Platform), with the caller (`owner`) and the time (`now`).
#[derive(Debug)]
pub struct Network<M> {
    pub(crate) medium: M,
    links: Vec<Link>,
    pub(crate) tables: Vec<Table>,
    /// Participants that may have to run at a time, since the last call of [`take_wakes`](Self::take_wakes).
    pub(crate) wakes: Vec<(usize, u64)>,
}

impl<M: Medium> Network<M> {
    /// Returns a network without participants.
    pub fn new(medium: M) -> Self {
        Self { medium, links: Vec::new(), tables: Vec::new(), wakes: Vec::new() }
    }

    /// Adds a participant, and returns its number. Before it listens, connections to it are refused.
    pub fn join(&mut self) -> usize {
        self.tables.push(Table::default());
        self.tables.len() - 1
    }

    /// Returns the medium.
    pub fn medium(&self) -> &M {
        &self.medium
    }

    /// Returns the medium for changes.
    pub fn medium_mut(&mut self) -> &mut M {
        &mut self.medium
    }

    /// Takes the participants that may have to run, each with its time, because input arrives for it or it has room.
    pub fn take_wakes(&mut self) -> Vec<(usize, u64)> {
        std::mem::take(&mut self.wakes)
    }

    /// Returns the participant that has this address.
    pub(crate) fn host_at(&self, address: IpAddress) -> Option<usize> {
        (0..self.tables.len()).find(|host| address_of(*host) == address)
    }

    /// Opens a listener; port 0 stands for one that no other socket of the participant has.
    ///
    /// # Errors
    /// If the participant has ended, or has no free slot.
    pub fn listen(&mut self, owner: usize, port: u16) -> Result<SocketId, NetError> {
        let table = &mut self.tables[owner];
        let port = if port == 0 { table.ephemeral_port() } else { port };
        table.insert(Kind::Listening { port, waiting: VecDeque::new() })
    }

    /// Returns the port of a listener or of a socket for datagrams.
    ///
    /// # Errors
    /// If the id names neither.
    pub fn local_port(&mut self, owner: usize, id: SocketId) -> Result<u16, NetError> {
        match self.tables[owner].get(id)?.kind {
            Kind::Listening { port, .. } | Kind::Datagrams { port, .. } => Ok(port),
            _ => Err(NetError::Stale),
        }
    }

    /// Begins to connect. A participant without a listener refuses; an address without a participant never answers.
    ///
    /// # Errors
    /// If the participant has ended, or has no free slot.
    pub fn connect(&mut self, owner: usize, to: Endpoint, now: u64) -> Result<SocketId, NetError> {
        let there = now + self.medium.latency_ns(owner, 0);
        let at = Some(there + self.medium.latency_ns(owner, 0));
        let number = self.links.len();
        let Some(host) = self.host_at(to.ip) else {
            return self.tables[owner].insert(Kind::Connecting { at: None, outcome: Err(NetError::Unreachable) });
        };
        let Some(waiting) = self.tables[host].waiting_at(to.port) else {
            return self.tables[owner].insert(Kind::Connecting { at, outcome: Err(NetError::Refused) });
        };
        let comes = waiting.back().map_or(0, |(at, ..)| *at).max(there);
        waiting.push_back((comes, number, address_of(owner)));
        self.wakes.push((host, comes));
        let pipes = [Pipe::default(), Pipe::default()];
        self.links.push(Link { pipes, owners: [owner, host], interests: [Interest::NONE; 2] });
        self.medium.see(Event::Begun { connection: number, by: owner, to: host }, now);
        self.tables[owner].insert(Kind::Connecting { at, outcome: Ok(number) })
    }

    /// Returns the outcome of [`Network::connect`].
    ///
    /// # Errors
    /// Returns the reason why it did not connect.
    pub fn connected(&mut self, owner: usize, id: SocketId, now: u64) -> Result<(), NetError> {
        let socket = self.tables[owner].get(id)?;
        match socket.kind {
            Kind::Connecting { at: Some(at), outcome } if at <= now => {
                socket.kind = Kind::Open { connection: outcome?, side: 0 };
                Ok(())
            }
            _ => Err(NetError::Stale),
        }
    }

    /// Takes a connection from the accept queue of a listener.
    ///
    /// # Errors
    /// If the id names no listener, or there is no free slot.
    pub fn accept(&mut self, owner: usize, id: SocketId, now: u64) -> Result<Option<(SocketId, IpAddress)>, NetError> {
        let Kind::Listening { waiting, .. } = &mut self.tables[owner].get(id)?.kind else {
            return Err(NetError::Stale);
        };
        let has_come = waiting.front().is_some_and(|(at, ..)| *at <= now);
        match if has_come { waiting.pop_front() } else { None } {
            None => Ok(None),
            Some((_, connection, peer)) => {
                Ok(Some((self.tables[owner].insert(Kind::Open { connection, side: 1 })?, peer)))
            }
        }
    }

    /// Returns the connection and the side of an open socket.
    fn open(&mut self, owner: usize, id: SocketId) -> Result<(usize, usize), NetError> {
        match self.tables[owner].get(id)?.kind {
            Kind::Open { connection, side } => Ok((connection, side)),
            _ => Err(NetError::Stale),
        }
    }

    /// Reads the bytes that have arrived, or a part of them.
    ///
    /// # Errors
    /// If the connection is broken, or the id names none.
    pub fn read(&mut self, owner: usize, id: SocketId, target: &mut [u8], now: u64) -> Result<Transfer, NetError> {
        let (connection, side) = self.open(owner, id)?;
        let pipe = &self.links[connection].pipes[1 - side];
        if pipe.is_reset(now) {
            return Err(NetError::Reset);
        }
        let most = pipe.available(now).min(target.len());
        if most == 0 {
            return Ok(if pipe.has_ended(now) { Transfer::Closed } else { Transfer::WouldBlock });
        }
        let bytes = self.medium.piece(most);
        let back = self.medium.latency_ns(self.links[connection].owners[0], 0);
        let link = &mut self.links[connection];
        link.pipes[1 - side].take(&mut target[..bytes]);
        self.medium.see(Event::Read { connection, side: 1 - side, bytes }, now);
        if link.interests[1 - side].writable {
            // The news of the room travels back.
            self.wakes.push((link.owners[1 - side], now + back));
        }
        Ok(Transfer::Bytes(bytes))
    }

    /// Writes as much as there is room for, or a part of it.
    ///
    /// # Errors
    /// If the connection is broken or ended, or the id names none.
    pub fn write(&mut self, owner: usize, id: SocketId, bytes: &[u8], now: u64) -> Result<Transfer, NetError> {
        let (connection, side) = self.open(owner, id)?;
        let link = &mut self.links[connection];
        let beginner = link.owners[0];
        if link.pipes[1 - side].is_reset(now) || link.pipes[side].end.is_some() {
            return Err(NetError::Reset);
        }
        if link.pipes[side].deserted {
            // The peer's system answers data without a reader with a reset.
            let at = now + self.medium.latency_ns(beginner, 0);
            self.break_off(connection, 1 - side, at);
            return Ok(Transfer::Bytes(bytes.len()));
        }
        let unread = link.pipes[side].len();
        let most = self.medium.pipe_bytes(beginner).saturating_sub(unread).min(bytes.len());
        if most == 0 || unread >= LEAST_ROOM && !self.medium.is_read_in_time() {
            self.medium.see(Event::Refused, now);
            return Ok(Transfer::WouldBlock);
        }
        let bytes = &bytes[..self.medium.piece(most)];
        let at = link.pipes[side].after_all(now + self.medium.latency_ns(beginner, bytes.len()));
        link.pipes[side].push(at, bytes);
        if link.interests[1 - side].readable {
            self.wakes.push((link.owners[1 - side], at));
        }
        self.medium.see(Event::Written { connection, side, bytes, arrives: at }, now);
        Ok(Transfer::Bytes(bytes.len()))
    }

    /// Tells the reader of this side's bytes at this time that the connection is broken.
    fn break_off(&mut self, connection: usize, side: usize, at: u64) {
        let link = &mut self.links[connection];
        link.pipes[side].reset.get_or_insert(at);
        self.wakes.push((link.owners[1 - side], at));
    }

    /// Tells the reader of this side's bytes at this time, or after the last byte, that no more will follow.
    fn end(&mut self, connection: usize, side: usize, at: u64) {
        let link = &mut self.links[connection];
        let at = link.pipes[side].after_all(at);
        link.pipes[side].end.get_or_insert(at);
        self.wakes.push((link.owners[1 - side], at));
    }

    /// Returns the arrival of a notification that a connection sends now.
    fn news(&mut self, connection: usize, now: u64) -> u64 {
        now + self.medium.latency_ns(self.links[connection].owners[0], 0)
    }

    /// Closes the writing direction of a connection.
    pub fn shut_down_writing(&mut self, owner: usize, id: SocketId, now: u64) {
        if let Ok((connection, side)) = self.open(owner, id) {
            let at = self.news(connection, now);
            self.end(connection, side, at);
        }
    }

    /// Closes a socket; a stale id is ignored.
    pub fn close(&mut self, owner: usize, id: SocketId, now: u64) {
        match self.tables[owner].take(id).map(|socket| socket.kind) {
            Some(Kind::Open { connection, side }) => {
                self.desert(connection, side, now);
            }
            Some(Kind::Connecting { outcome: Ok(connection), .. }) => self.desert(connection, 0, now),
            Some(Kind::Listening { waiting, .. }) => {
                for (_, connection, _) in waiting {
                    let at = self.news(connection, now);
                    self.break_off(connection, 1, at);
                }
            }
            _ => {}
        }
    }

    /// Closes one side's socket: the other side sees the end, or a broken connection if bytes were unread.
    fn desert(&mut self, connection: usize, side: usize, now: u64) {
        let at = self.news(connection, now);
        let link = &mut self.links[connection];
        link.interests[side] = Interest::NONE;
        link.pipes[1 - side].deserted = true;
        let writer = link.owners[1 - side];
        if link.pipes[1 - side].len() > 0 {
            self.break_off(connection, side, at);
        } else {
            self.end(connection, side, at);
        }
        self.wakes.push((writer, at));
    }

    fn sockets_of(&self, owner: usize) -> Vec<SocketId> {
        self.tables[owner].iter().map(|(id, _)| id).collect()
    }

    /// Ends a participant: its system closes its sockets, and refuses connections.
    pub fn switch_off(&mut self, owner: usize, now: u64) {
        for id in self.sockets_of(owner) {
            self.close(owner, id, now);
        }
        self.tables[owner].off = true;
    }

    /// Breaks all connections of a participant, for both sides.
    pub fn break_all(&mut self, owner: usize, now: u64) {
        for id in self.sockets_of(owner) {
            if let Ok((connection, _)) = self.open(owner, id) {
                self.break_off(connection, 0, now);
                self.break_off(connection, 1, now);
            }
        }
    }

    /// Sets the events that a participant waits for on a socket; ignores a stale id.
    pub fn set_interest(&mut self, owner: usize, id: SocketId, interest: Interest) {
        let Ok(socket) = self.tables[owner].get(id) else { return };
        socket.interest = interest;
        if let Kind::Open { connection, side } = socket.kind {
            self.links[connection].interests[side] = interest;
        }
    }

    /// Returns the times from which on a socket is readable, writable, and broken.
    fn times(&self, kind: &Kind) -> (Option<u64>, Option<u64>, Option<u64>) {
        match kind {
            Kind::Connecting { at, .. } => (None, *at, None),
            Kind::Listening { waiting, .. } => (waiting.front().map(|(at, ..)| *at), None, None),
            Kind::Datagrams { arriving, .. } => (arriving.next_time(), None, None),
            Kind::Open { connection, side } => {
                let link = &self.links[*connection];
                let (incoming, outgoing) = (&link.pipes[1 - side], &link.pipes[*side]);
                let room = outgoing.deserted || outgoing.len() < self.medium.pipe_bytes(link.owners[0]);
                (incoming.next_time(), room.then_some(0), incoming.reset)
            }
        }
    }

    /// Returns the sockets for which a participant waits.
    fn awaited(&self, owner: usize) -> impl Iterator<Item = (SocketId, &Socket)> {
        self.tables[owner].iter().filter(|(_, socket)| socket.interest != Interest::NONE)
    }

    /// Reports the sockets of a participant that match their interest.
    pub fn ready(&self, owner: usize, now: u64, mut report: impl FnMut(SocketId, Interest)) {
        for (id, Socket { kind, interest }) in self.awaited(owner) {
            let (readable, writable, broken) = self.times(kind);
            let due = |at: Option<u64>| at.is_some_and(|at| at <= now);
            let broken = due(broken);
            let is = Interest {
                readable: (interest.readable && due(readable)) || broken,
                writable: (interest.writable && due(writable)) || broken,
            };
            if is != Interest::NONE {
                report(id, is);
            }
        }
    }

    /// Returns the time at which the first socket of a participant matches its interest.
    pub fn next_ready(&self, owner: usize) -> Option<u64> {
        let times = self.awaited(owner).flat_map(|(_, Socket { kind, interest })| {
            let (readable, writable, broken) = self.times(kind);
            [readable.filter(|_| interest.readable), writable.filter(|_| interest.writable), broken]
        });
        times.flatten().min()
    }
}
