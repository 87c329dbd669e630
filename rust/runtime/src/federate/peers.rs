// SPDX-License-Identifier: Apache-2.0
//! Connections with other federates, past the RTI: one in each direction in which something is sent.
//!
//! A connection is made by the side that sends. Each has a bounded buffer of its own: what does not fit there holds the
//! sender's tag open, and what does not fit into its input's queue stays there unread, so that TCP slows the sender.

use core::net::SocketAddrV4;

use lf_coordination::peer::{Answer, Arrival, judge_arrival, read_answer};
use lf_coordination::{Deadline, FederateId};
use lf_model::time::{Instant, Interval};
use lf_wire::june_2026::{Message, RejectCode};
use lf_wire::{InBuffer, OutBuffer};

use super::input::Held;
use crate::platform::{Interest, NetError, Platform, SocketId, Transfer};

/// How long a connection of another federate may take to say whose it is.
const INTRODUCTION_TIME_OUT: Interval = Interval::from_secs(10);
/// A connection to a federate to which this one sends directly, with its memory.
#[derive(Debug)]
pub struct Outbound<'s> {
    pub(super) output: OutBuffer<&'s mut [u8]>,
    answer: InBuffer<[u8; 2]>,
    state: State,
    /// Since when a message has had no room.
    pub(super) stuck: Option<Instant>,
    /// Messages that the other federate cannot have got, because it has left.
    lost: u64,
    /// The other federate has left before this one.
    left_early: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum State {
    /// It is not to be made yet.
    Absent,
    /// An attempt is under way; `true` when the socket says that it has an outcome.
    Connecting(SocketId, bool),
    /// This federate has said who it is, and the other one has not answered.
    Introduced(SocketId),
    /// Messages can be sent.
    Open(SocketId),
    /// The other one has left.
    Ended,
}

/// A connection from a federate that sends to this one directly, with its memory.
#[derive(Debug)]
pub struct Inbound<'s> {
    pub(super) input: InBuffer<&'s mut [u8]>,
    socket: Option<SocketId>,
    /// Whose it is, once that is known.
    pub(super) from: Option<FederateId>,
    /// The messages at the front of the receive buffer that wait for room.
    pub(super) held: Held,
    readable: bool,
    ended: bool,
    /// When the wait for its introduction is over.
    deadline: Instant,
}

impl<'s> Outbound<'s> {
    /// A connection that is still to be made, with a send buffer in this memory.
    pub fn new(output: &'s mut [u8]) -> Self {
        let (output, answer) = (OutBuffer::new(output), InBuffer::new([0; 2]));
        Self { output, answer, state: State::Absent, stuck: None, lost: 0, left_early: false }
    }

    /// Whether the other federate has left, so that what is sent to it goes nowhere.
    pub(super) fn has_ended(&self) -> bool {
        self.state == State::Ended
    }

    /// One more message for a federate that has left. `true` for the first.
    pub(super) fn lose(&mut self) -> bool {
        self.lost = self.lost.saturating_add(1);
        self.lost == 1
    }

    /// How many messages are lost at least.
    pub(super) fn lost(&self) -> u64 {
        self.lost
    }

    /// Whether the other federate has left before this one: what was on its way then may be lost too.
    pub(super) fn has_left_early(&self) -> bool {
        self.left_early
    }

    /// Writes what is pending. A connection that is broken is over.
    pub(super) fn flush<P: Platform>(&mut self, platform: &mut P) {
        let (State::Introduced(socket) | State::Open(socket)) = self.state else { return };
        while !self.output.is_empty() {
            match platform.write(socket, self.output.pending()) {
                Ok(Transfer::Bytes(count)) => {
                    self.output.consume(count);
                    self.stuck = None;
                }
                Ok(Transfer::WouldBlock) => return,
                Ok(Transfer::Closed) | Err(_) => return self.lose_peer(platform),
            }
        }
    }

    /// The other side has ended the connection.
    fn lose_peer<P: Platform>(&mut self, platform: &mut P) {
        self.left_early |= matches!(self.state, State::Open(_));
        self.end(platform);
    }

    /// The other side has left, or cannot be reached.
    fn end<P: Platform>(&mut self, platform: &mut P) {
        if let State::Connecting(socket, _) | State::Introduced(socket) | State::Open(socket) = self.state {
            platform.close(socket);
        }
        // Its last message at least is not complete.
        let loses = matches!(self.state, State::Open(_)) && !self.output.is_empty();
        self.lost = self.lost.saturating_add(u64::from(loses));
        self.state = State::Ended;
        self.output.clear();
        self.answer.clear();
        self.stuck = None;
    }

    /// Goes on with a connection that is being made. `Some` when it is there (`true`), or cannot be made (`false`).
    fn establish<P: Platform>(&mut self, platform: &mut P, introduction: &Message<'_>) -> Option<bool> {
        if let State::Connecting(socket, true) = self.state {
            if platform.connected(socket).is_err() || self.output.push(introduction).is_err() {
                self.end(platform);
                return Some(false);
            }
            self.state = State::Introduced(socket);
        }
        self.flush(platform);
        let State::Introduced(socket) = self.state else { return (self.state == State::Ended).then_some(false) };
        match platform.read(socket, self.answer.space()) {
            Ok(Transfer::Bytes(count)) => self.answer.filled(count),
            Ok(Transfer::WouldBlock) => return None,
            Ok(Transfer::Closed) | Err(_) => {
                self.end(platform);
                return Some(false);
            }
        }
        match read_answer(self.answer.bytes()) {
            Answer::Incomplete => None,
            Answer::Accepted => {
                self.state = State::Open(socket);
                Some(true)
            }
            answer => {
                log::warn!("another federate refuses the connection of this one: {answer:?}");
                self.end(platform);
                Some(false)
            }
        }
    }

    /// Looks for the end of the other side, which never says anything else.
    fn look_for_end<P: Platform>(&mut self, platform: &mut P, ready: SocketId) {
        if self.state == State::Open(ready)
            && !matches!(platform.read(ready, &mut [0; 1]), Ok(Transfer::WouldBlock | Transfer::Bytes(_)))
        {
            self.lose_peer(platform);
        }
    }

    fn set_interest<P: Platform>(&self, platform: &mut P) {
        match self.state {
            State::Connecting(socket, _) => platform.set_interest(socket, Interest::WRITE),
            State::Introduced(socket) | State::Open(socket) => {
                platform.set_interest(socket, Interest { readable: true, writable: !self.output.is_empty() });
            }
            State::Absent | State::Ended => {}
        }
    }
}

impl<'s> Inbound<'s> {
    /// A place for a connection that is still to come, with a receive buffer in this memory.
    pub fn new(input: &'s mut [u8]) -> Self {
        let (input, deadline) = (InBuffer::new(input), Instant::NEVER);
        Self { input, socket: None, from: None, held: Held::NONE, readable: false, ended: false, deadline }
    }

    /// Reads once, if a wait has told that there is something to read.
    pub(super) fn fill<P: Platform>(&mut self, platform: &mut P) {
        if self.readable {
            self.fill_now(platform);
        }
    }

    /// Reads once. `true` when there was something to read, or the end.
    pub(super) fn fill_now<P: Platform>(&mut self, platform: &mut P) -> bool {
        let Some(socket) = self.socket.filter(|_| !self.ended) else { return false };
        let space = self.input.space();
        if space.is_empty() {
            return false;
        }
        self.readable = false;
        match platform.read(socket, space) {
            Ok(Transfer::Bytes(count)) => self.input.filled(count),
            Ok(Transfer::WouldBlock) => return false,
            Ok(Transfer::Closed) | Err(_) => self.ended = true,
        }
        true
    }

    /// Whether nothing more comes, apart from what has come.
    pub(super) fn has_ended(&self) -> bool {
        self.ended
    }

    /// Frees the place.
    pub(super) fn close<P: Platform>(&mut self, platform: &mut P) {
        if let Some(socket) = self.socket.take() {
            platform.close(socket);
        }
        (self.from, self.readable, self.ended) = (None, false, false);
        self.held = Held::NONE;
        self.input.clear();
    }

    fn refuse<P: Platform>(&mut self, platform: &mut P, code: RejectCode) {
        log::warn!("a connection was refused: {code}");
        let mut bytes = [0; 2];
        if let (Some(socket), Ok(length)) = (self.socket, Message::Reject(code).encode(&mut bytes)) {
            // The first bytes of a connection always find room.
            let mut rest = &bytes[..length];
            while let Ok(Transfer::Bytes(count)) = platform.write(socket, rest) {
                rest = rest.get(count..).unwrap_or_default();
                if rest.is_empty() {
                    break;
                }
            }
            platform.shut_down_writing(socket);
        }
        self.close(platform);
    }
}

/// All connections with other federates.
#[derive(Debug)]
pub(crate) struct Peers<'s> {
    pub(super) outbound: &'s mut [Outbound<'s>],
    pub(super) inbound: &'s mut [Inbound<'s>],
    listener: Option<SocketId>,
    acceptable: bool,
    /// Messages wait in a receive buffer, and there may be room for them now.
    pub(super) stale: bool,
}

impl Default for Peers<'_> {
    fn default() -> Self {
        Self::new(&mut [], &mut [])
    }
}

impl<'s> Peers<'s> {
    pub(crate) fn new(outbound: &'s mut [Outbound<'s>], inbound: &'s mut [Inbound<'s>]) -> Self {
        Self { outbound, inbound, listener: None, acceptable: false, stale: false }
    }

    /// A tag has been begun: there is room for messages that wait.
    pub(super) fn look_again(&mut self) {
        self.stale = true;
        for inbound in self.inbound.iter_mut() {
            inbound.held.look_again();
        }
    }

    /// Begins to await connections, if any are to come; gives the port.
    pub(super) fn listen<P: Platform>(&mut self, platform: &mut P) -> Result<Option<u16>, NetError> {
        if !P::PEERS || self.inbound.is_empty() {
            return Ok(None);
        }
        let listener = platform.listen(0)?;
        self.listener = Some(listener);
        platform.local_port(listener).map(Some)
    }

    /// Begins to connect.
    pub(super) fn connect<P: Platform>(&mut self, platform: &mut P, index: usize, address: SocketAddrV4) {
        let Some(outbound) = self.outbound.get_mut(index).filter(|_| P::PEERS) else { return };
        outbound.end(platform);
        if let Ok(socket) = platform.connect(address) {
            outbound.state = State::Connecting(socket, false);
        }
    }

    /// Goes on with the connection that is being made, if it has this index. See [`Outbound::establish`].
    pub(super) fn establish<P: Platform>(
        &mut self,
        platform: &mut P,
        index: usize,
        introduction: &Message<'_>,
    ) -> Option<bool> {
        self.outbound.get_mut(index)?.establish(platform, introduction)
    }

    /// Takes connections that wait, and lets those in that say who they are. Bounded by the number of places.
    pub(super) fn welcome<P: Platform>(&mut self, platform: &mut P, federation_id: &[u8], awaited: &[u16]) {
        let now = platform.now();
        for index in 0..self.inbound.len() {
            if self.inbound[index].socket.is_none() && self.acceptable {
                self.accept(platform, index, now);
            }
            let inbound = &self.inbound[index];
            if inbound.socket.is_none() || inbound.from.is_some() {
                continue;
            }
            self.inbound[index].fill(platform);
            let is_there = |id| self.inbound.iter().any(|other| other.from == Some(id));
            let is_awaited = |id: FederateId| awaited.contains(&id.0) && !is_there(id);
            let verdict = judge_arrival(self.inbound[index].input.bytes(), federation_id, is_awaited);
            let inbound = &mut self.inbound[index];
            match verdict {
                Arrival::Welcome(federate, length) => {
                    inbound.input.consume(length);
                    inbound.from = Some(federate);
                    if let Some(socket) = inbound.socket {
                        // The first byte of a connection always finds room.
                        let _ = platform.write(socket, &[lf_wire::june_2026::MessageType::Ack.byte()]);
                    }
                }
                Arrival::Refuse(code) => inbound.refuse(platform, code),
                Arrival::Incomplete(_) if inbound.ended || inbound.deadline <= now => inbound.close(platform),
                Arrival::Incomplete(_) => {}
            }
        }
    }

    fn accept<P: Platform>(&mut self, platform: &mut P, index: usize, now: Instant) {
        let Some(listener) = self.listener else { return };
        match platform.accept(listener) {
            Ok(Some((socket, _))) => {
                let inbound = &mut self.inbound[index];
                inbound.socket = Some(socket);
                (inbound.readable, inbound.deadline) = (true, now + INTRODUCTION_TIME_OUT);
            }
            Ok(None) => self.acceptable = false,
            Err(error) => {
                log::warn!("a connection could not be accepted: {error}");
                self.acceptable = false;
            }
        }
    }

    /// Writes what is pending on all connections. `true` when nothing is left.
    pub(super) fn flush<P: Platform>(&mut self, platform: &mut P) -> bool {
        if !P::PEERS {
            return true;
        }
        for outbound in self.outbound.iter_mut() {
            outbound.flush(platform);
        }
        self.outbound.iter().all(|outbound| outbound.output.is_empty())
    }

    /// Sends what is still to be sent, and closes each connection when that is done. Those over which something may
    /// come stay open as long as this federate `hears`. `false` when nothing is left to be sent.
    pub(super) fn take_leave<P: Platform>(&mut self, platform: &mut P, hears: bool) -> bool {
        if !P::PEERS {
            return false;
        }
        if let Some(listener) = self.listener.take() {
            platform.close(listener);
        }
        for inbound in self.inbound.iter_mut().filter(|inbound| !hears || inbound.from.is_none()) {
            inbound.close(platform);
        }
        self.look_for_ends(platform);
        self.flush(platform);
        for outbound in self.outbound.iter_mut().filter(|outbound| outbound.output.is_empty()) {
            outbound.end(platform);
        }
        self.outbound.iter().any(|outbound| !outbound.output.is_empty())
    }

    /// Whether another federate can still send something directly.
    pub(super) fn can_receive<P: Platform>(&self) -> bool {
        P::PEERS && self.inbound.iter().any(|inbound| inbound.from.is_some())
    }

    /// Since when the federate with this index has taken nothing though this one waits for that.
    pub(super) fn stuck<P: Platform>(&self) -> Option<(usize, Instant)> {
        if !P::PEERS {
            return None;
        }
        let stuck = |(index, outbound): (usize, &Outbound<'_>)| outbound.stuck.map(|since| (index, since));
        self.outbound.iter().enumerate().filter_map(stuck).min_by_key(|(_, since)| *since)
    }

    /// Says what to wait for; messages only while the program can take them.
    pub(super) fn set_interest<P: Platform>(&mut self, platform: &mut P, running: bool) {
        if !P::PEERS {
            return;
        }
        if let Some(listener) = self.listener {
            let places = self.inbound.iter().any(|inbound| inbound.socket.is_none());
            platform.set_interest(listener, if places { Interest::READ } else { Interest::NONE });
        }
        for inbound in self.inbound.iter_mut() {
            let wanted = !inbound.ended && (running || inbound.from.is_none()) && !inbound.input.space().is_empty();
            if let Some(socket) = inbound.socket {
                platform.set_interest(socket, if wanted { Interest::READ } else { Interest::NONE });
            }
        }
        for outbound in self.outbound.iter() {
            outbound.set_interest(platform);
        }
    }

    /// A wait found this socket ready.
    pub(super) fn handle_ready<P: Platform>(&mut self, ready: SocketId, interest: Interest) {
        if !P::PEERS {
            return;
        }
        if self.listener == Some(ready) {
            self.acceptable = true;
        }
        for inbound in self.inbound.iter_mut().filter(|inbound| inbound.socket == Some(ready)) {
            inbound.readable |= interest.readable;
        }
        for outbound in self.outbound.iter_mut() {
            if let State::Connecting(socket, has_outcome) = &mut outbound.state {
                *has_outcome |= *socket == ready;
            }
        }
    }

    /// Notices which federates have left.
    pub(super) fn look_for_ends<P: Platform>(&mut self, platform: &mut P) {
        for outbound in self.outbound.iter_mut() {
            if let State::Open(socket) = outbound.state {
                outbound.look_for_end(platform, socket);
            }
        }
    }

    /// When there is something to do though no socket is ready.
    pub(super) fn poll_timeout<P: Platform>(&mut self, running: bool) -> Deadline {
        if !P::PEERS {
            return Deadline::Never;
        }
        let unread = |inbound: &mut Inbound<'_>| {
            inbound.readable && inbound.from.is_some() && !inbound.ended && !inbound.input.space().is_empty()
        };
        if running && (self.stale || self.inbound.iter_mut().any(unread)) {
            return Deadline::Now;
        }
        let free = self.inbound.iter().any(|inbound| inbound.socket.is_none());
        if self.acceptable && free && self.listener.is_some() {
            return Deadline::Now;
        }
        let nameless = self.inbound.iter().filter(|inbound| inbound.socket.is_some() && inbound.from.is_none());
        nameless.map(|inbound| inbound.deadline).min().into()
    }

    /// Ends all connections.
    pub(super) fn close<P: Platform>(&mut self, platform: &mut P) {
        if !P::PEERS {
            return;
        }
        if let Some(listener) = self.listener.take() {
            platform.close(listener);
        }
        for outbound in self.outbound.iter_mut() {
            outbound.end(platform);
        }
        for inbound in self.inbound.iter_mut() {
            inbound.close(platform);
        }
    }
}
