// SPDX-License-Identifier: Apache-2.0
//! Connections with other federates, past the RTI: one in each direction in which something is sent.
//!
//! A connection is made by the side that sends. Each has a bounded buffer of its own: what does not fit there holds the
//! sender's tag open, and what does not fit into its input's queue stays there unread, so that TCP slows the sender.

use core::net::SocketAddrV4;

use lf_coordination::peer::{Answer, read_answer};
use lf_coordination::{Deadline, FederateId};
use lf_model::time::{Instant, Interval};
use lf_wire::{InBuffer, Message, OutBuffer, RejectCode};

use super::input::Held;
use super::visitors::{Introduced, Visitors, refuse};
use crate::description::PEERS;
use crate::error::PeerFault;
use crate::platform::{Interest, NetError, Platform, SocketId, Transfer};

/// How long a connection to another federate may take until that has answered; then it is made anew.
const ANSWER_TIME_OUT: Interval = Interval::from_secs(10);

/// A connection to a federate to which this one sends directly, with its memory.
#[derive(Debug)]
pub struct Outbound<'s> {
    pub(super) output: OutBuffer<&'s mut [u8]>,
    answer: InBuffer<[u8; 2]>,
    state: State,
    /// When the wait for the answer of the other federate is over.
    answer_due: Instant,
    /// Why the last attempt has failed.
    trouble: Option<PeerFault>,
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
}

impl<'s> Outbound<'s> {
    /// A connection that is still to be made, with a send buffer in this memory.
    pub fn new(output: &'s mut [u8]) -> Self {
        let (output, answer) = (OutBuffer::new(output), InBuffer::new([0; 2]));
        let (state, answer_due) = (State::Absent, Instant::NEVER);
        Self { output, answer, state, answer_due, trouble: None, stuck: None, lost: 0, left_early: false }
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
        match self.step(platform, introduction) {
            Ok(connected) => connected.then_some(true),
            Err(fault) => {
                self.trouble = Some(fault);
                self.end(platform);
                Some(false)
            }
        }
    }

    /// `true` when the connection is there.
    fn step<P: Platform>(&mut self, platform: &mut P, introduction: &Message<'_>) -> Result<bool, PeerFault> {
        if let State::Connecting(socket, true) = self.state {
            platform.connected(socket).map_err(PeerFault::Unreachable)?;
            self.output.push(introduction).map_err(|_| PeerFault::Unreachable(NetError::NoSocketLeft))?;
            self.state = State::Introduced(socket);
        }
        self.flush(platform);
        if let State::Introduced(socket) = self.state {
            match platform.read(socket, self.answer.space()) {
                Ok(Transfer::Bytes(count)) => self.answer.filled(count),
                Ok(Transfer::WouldBlock) => {}
                Ok(Transfer::Closed) => return Err(PeerFault::Unanswered),
                Err(error) => return Err(PeerFault::Unreachable(error)),
            }
            match read_answer(self.answer.bytes()) {
                Answer::Incomplete => {}
                Answer::Accepted => {
                    self.state = State::Open(socket);
                    return Ok(true);
                }
                Answer::Rejected(code) => return Err(PeerFault::Refuses(code)),
                Answer::Wrong(error) => return Err(PeerFault::Bytes(error)),
            }
        }
        if self.state == State::Ended {
            return Err(self.trouble.unwrap_or(PeerFault::Unanswered));
        }
        let attempts = matches!(self.state, State::Connecting(..) | State::Introduced(_));
        if attempts && platform.now() < self.answer_due { Ok(false) } else { Err(PeerFault::Unanswered) }
    }

    /// When to give up the attempt that is under way.
    fn answer_due(&self) -> Option<Instant> {
        matches!(self.state, State::Connecting(..) | State::Introduced(_)).then_some(self.answer_due)
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
        let input = InBuffer::new(input);
        Self { input, socket: None, from: None, held: Held::NONE, readable: false, ended: false }
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
}

/// All connections with other federates.
#[derive(Debug)]
pub(crate) struct Peers<'s> {
    pub(super) outbound: &'s mut [Outbound<'s>],
    pub(super) inbound: &'s mut [Inbound<'s>],
    visitors: Visitors,
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
        Self { outbound, inbound, visitors: Visitors::default(), stale: false }
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
        if !PEERS || self.inbound.is_empty() {
            return Ok(None);
        }
        self.visitors.listen(platform).map(Some)
    }

    /// Begins to connect.
    pub(super) fn connect<P: Platform>(&mut self, platform: &mut P, index: usize, address: SocketAddrV4) {
        let Some(outbound) = self.outbound.get_mut(index).filter(|_| PEERS) else { return };
        outbound.end(platform);
        match platform.connect(address) {
            Ok(socket) => outbound.state = State::Connecting(socket, false),
            Err(error) => outbound.trouble = Some(PeerFault::Unreachable(error)),
        }
        outbound.answer_due = platform.now() + ANSWER_TIME_OUT;
    }

    /// Why the last attempt to connect to the federate with this index has failed.
    pub(super) fn trouble(&self, index: usize) -> Option<PeerFault> {
        self.outbound.get(index)?.trouble
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

    /// Takes connections that wait, and lets those in that say who they are, as long as this federate has not started
    /// with all of them. Bounded by the number of places.
    pub(super) fn welcome<P: Platform>(
        &mut self,
        platform: &mut P,
        federation_id: &[u8],
        awaited: &[u16],
        begun: bool,
    ) {
        if begun && self.inbound.iter().all(|inbound| inbound.from.is_some()) {
            return self.visitors.close(platform);
        }
        while let Some(Introduced { federate, socket, address }) = self.visitors.receive(platform, federation_id) {
            match self.place_for(platform, federate, awaited, begun) {
                Ok(place) => {
                    let inbound = &mut self.inbound[place];
                    (inbound.from, inbound.socket, inbound.readable) = (Some(federate), Some(socket), true);
                    // The first byte of a connection always finds room.
                    let _ = platform.write(socket, &[lf_wire::MessageType::Ack.byte()]);
                }
                Err(code) => refuse(platform, socket, address, code, self.visitors.refused.count()),
            }
        }
    }

    /// The place of a federate that has introduced itself, or why there is none.
    fn place_for<P: Platform>(
        &mut self,
        platform: &mut P,
        federate: FederateId,
        awaited: &[u16],
        begun: bool,
    ) -> Result<usize, RejectCode> {
        if let Some(before) = self.inbound.iter_mut().find(|inbound| inbound.from == Some(federate)) {
            // It may have come anew, because its first connection was lost.
            before.fill_now(platform);
            if begun || !before.ended {
                return Err(RejectCode::IdInUse);
            }
            before.close(platform);
        }
        let vacant = self.inbound.iter().position(|inbound| inbound.from.is_none());
        vacant.filter(|_| awaited.contains(&federate.0)).ok_or(RejectCode::IdOutOfRange)
    }

    /// Writes what is pending on all connections. `true` when nothing is left.
    pub(super) fn flush<P: Platform>(&mut self, platform: &mut P) -> bool {
        if !PEERS {
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
        if !PEERS {
            return false;
        }
        self.visitors.close(platform);
        for inbound in self.inbound.iter_mut().filter(|_| !hears) {
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
    pub(super) fn can_receive(&self) -> bool {
        PEERS && self.inbound.iter().any(|inbound| inbound.from.is_some())
    }

    /// Since when the federate with this index has taken nothing though this one waits for that.
    pub(super) fn stuck(&self) -> Option<(usize, Instant)> {
        if !PEERS {
            return None;
        }
        let stuck = |(index, outbound): (usize, &Outbound<'_>)| outbound.stuck.map(|since| (index, since));
        self.outbound.iter().enumerate().filter_map(stuck).min_by_key(|(_, since)| *since)
    }

    /// Says what to wait for; messages only while the program can take them.
    pub(super) fn set_interest<P: Platform>(&mut self, platform: &mut P, running: bool) {
        if !PEERS {
            return;
        }
        self.visitors.set_interest(platform);
        for inbound in self.inbound.iter_mut() {
            let wanted = !inbound.ended && running && !inbound.input.space().is_empty();
            if let Some(socket) = inbound.socket {
                platform.set_interest(socket, if wanted { Interest::READ } else { Interest::NONE });
            }
        }
        for outbound in self.outbound.iter() {
            outbound.set_interest(platform);
        }
    }

    /// A wait found this socket ready.
    pub(super) fn handle_ready(&mut self, ready: SocketId, interest: Interest) {
        if !PEERS {
            return;
        }
        self.visitors.handle_ready(ready);
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
    pub(super) fn poll_timeout(&mut self, running: bool) -> Deadline {
        if !PEERS {
            return Deadline::Never;
        }
        let unread = |inbound: &mut Inbound<'_>| {
            inbound.readable && inbound.from.is_some() && !inbound.ended && !inbound.input.space().is_empty()
        };
        if running && (self.stale || self.inbound.iter_mut().any(unread)) {
            return Deadline::Now;
        }
        let answers = self.outbound.iter().filter_map(Outbound::answer_due).min();
        self.visitors.poll_timeout().min(answers.into())
    }

    /// Ends all connections.
    pub(super) fn close<P: Platform>(&mut self, platform: &mut P) {
        if !PEERS {
            return;
        }
        self.visitors.close(platform);
        for outbound in self.outbound.iter_mut() {
            outbound.end(platform);
        }
        for inbound in self.inbound.iter_mut() {
            inbound.close(platform);
        }
    }
}
