// SPDX-License-Identifier: Apache-2.0
//! A connection to a federate to which this one sends directly. The sending side makes it; the other one accepts or
//! refuses it, and then only ever ends it.

use lf_coordination::peer::{IntroductionReply, read_answer};
use lf_coordination::{Deadline, Endpoint};
use lf_model::time::{Instant, Interval};
use lf_wire::{InBuffer, Message, OutBuffer};

use crate::connection::Connection;
use crate::error::PeerFault;
#[cfg(feature = "security")]
use crate::platform::Participant;
use crate::platform::{Interest, NetError, Platform, SocketId, Transfer};

/// The time within which another federate has to answer a connection; then it is made anew.
const ANSWER_TIME_OUT: Interval = Interval::from_secs(10);

/// A connection to a federate to which this one sends directly, with its memory.
#[derive(Debug)]
pub struct Outbound<'s> {
    connection: Connection<'s>,
    answer: InBuffer<[u8; 2]>,
    stage: ConnectStage,
    /// The statement of the next introduction whether this federate is transient. LF 0.12 accepts no introduction that
    /// says it, LF 0.13 none that does not, and the release of the receiver is unknown: so each attempt uses the other
    /// form. That of LF 0.13 is the first, because a receiver of LF 0.12 refuses it at once, while one of LF 0.13 would
    /// wait for the rest of the other form.
    says_transient: Option<bool>,
    /// The end of the wait for the other federate's answer.
    answer_due: Instant,
    /// The fault of the last attempt to connect.
    pub(super) fault: Option<PeerFault>,
    /// The time since which a message has had no room.
    pub(super) blocked_since: Option<Instant>,
    /// The minimum number of messages that the other federate cannot have received, because it has left.
    pub(super) lost: u64,
    /// Whether the other federate has left before this one: what was in transit then may be lost too.
    pub(super) left_early: bool,
    /// The number of outputs whose end has been sent.
    pub(super) ends_sent: usize,
    /// The time at which to look for the other federate, which is transient and has come.
    #[cfg(feature = "transients")]
    wanted: Option<Instant>,
}

/// The stage of the connection.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum ConnectStage {
    /// It is not to be made yet.
    Absent,
    /// An attempt is open; `true` when the socket reports an outcome.
    Connecting(SocketId, bool),
    /// This federate has sent its introduction, and the other one has not answered.
    Introduced,
    /// Messages can be sent.
    Open,
    /// The other one has left.
    Ended,
}

impl<'s> Outbound<'s> {
    /// Returns a connection that is still to be made, with a send buffer in this memory.
    pub fn new(output: &'s mut [u8]) -> Self {
        Self {
            connection: Connection::new(&mut [], output),
            answer: InBuffer::new([0; 2]),
            stage: ConnectStage::Absent,
            says_transient: Some(false),
            answer_due: Instant::NEVER,
            fault: None,
            blocked_since: None,
            lost: 0,
            left_early: false,
            ends_sent: 0,
            #[cfg(feature = "transients")]
            wanted: None,
        }
    }

    /// Handles that the other federate, which is transient, has come or left.
    #[cfg(feature = "transients")]
    pub(super) fn expect<P: Platform>(&mut self, platform: &mut P, is_here: bool) {
        if is_here {
            // It may have been found before the start. The end of an earlier instance comes before this one.
            self.detect_end_now(platform);
            self.wanted = (!self.is_open()).then(|| platform.now());
        } else {
            self.wanted = None;
            self.end(platform);
            self.stage = ConnectStage::Absent;
        }
    }

    /// Returns whether to look for the other federate now.
    #[cfg(feature = "transients")]
    pub(super) fn is_wanted(&self, now: Instant) -> bool {
        self.wanted.is_some_and(|wanted| wanted <= now) && !self.is_attempt()
    }

    /// Sets the time at which to look for the other federate again; `None` when it has been found.
    #[cfg(feature = "transients")]
    pub(super) fn look_again(&mut self, at: Option<Instant>) {
        self.wanted = at;
    }

    /// Returns whether messages can be sent.
    pub(super) fn is_open(&self) -> bool {
        self.stage == ConnectStage::Open
    }

    /// Returns what the next introduction has to say about whether this federate is transient.
    pub(super) fn says_transient(&self) -> Option<bool> {
        self.says_transient
    }

    /// Returns the send buffer.
    pub(super) fn output(&mut self) -> &mut OutBuffer<&'s mut [u8]> {
        &mut self.connection.output
    }

    /// Returns whether everything has been sent.
    pub(super) fn is_empty(&self) -> bool {
        self.connection.output.is_empty()
    }

    /// Returns the capacity of the send buffer in bytes.
    pub(super) fn capacity(&self) -> usize {
        self.connection.output.capacity()
    }

    /// Counts one more message for a federate that has left. Returns `true` for the first.
    pub(super) fn lose(&mut self) -> bool {
        self.lost = self.lost.saturating_add(1);
        self.lost == 1
    }

    /// Records that a message has no room.
    pub(super) fn is_full(&mut self, now: Instant) {
        self.blocked_since = self.blocked_since.or(Some(now));
    }

    /// Begins to connect to this federate.
    pub(super) fn connect<P: Platform>(&mut self, platform: &mut P, federate: u16, address: Endpoint) {
        self.end(platform);
        self.ends_sent = 0;
        match platform.connect(address) {
            Ok(socket) => {
                #[cfg(feature = "security")]
                platform.require(socket, Participant::Federate(federate));
                #[cfg(not(feature = "security"))]
                let _ = federate;
                self.stage = ConnectStage::Connecting(socket, false);
            }
            Err(error) => self.fault = Some(PeerFault::Unreachable(error)),
        }
        self.answer_due = platform.now() + ANSWER_TIME_OUT;
    }

    /// Writes what is pending. A broken connection ends.
    pub(super) fn flush<P: Platform>(&mut self, platform: &mut P) {
        let before = self.connection.output.pending().len();
        let is_sound = self.connection.flush(platform);
        if self.connection.output.pending().len() < before {
            self.blocked_since = None;
        }
        if !is_sound {
            self.lose_peer(platform);
        }
    }

    /// Handles that the other side has ended the connection.
    fn lose_peer<P: Platform>(&mut self, platform: &mut P) {
        self.left_early |= self.stage == ConnectStage::Open;
        self.end(platform);
    }

    /// Ends the connection: the other side has left, or cannot be reached; or this one has sent everything.
    pub(super) fn end<P: Platform>(&mut self, platform: &mut P) {
        if let ConnectStage::Connecting(socket, _) = self.stage {
            platform.close(socket);
        }
        // At least its last message is not complete.
        let loses = self.stage == ConnectStage::Open && !self.is_empty();
        self.lost = self.lost.saturating_add(u64::from(loses));
        self.stage = ConnectStage::Ended;
        self.connection.close(platform);
        self.answer.clear();
        self.blocked_since = None;
    }

    /// Advances a connection that is being made. Returns `Some` when it is there (`true`), or cannot be made (`false`).
    pub(super) fn establish<P: Platform>(&mut self, platform: &mut P, introduction: &Message<'_>) -> Option<bool> {
        match self.step(platform, introduction) {
            Ok(connected) => connected.then_some(true),
            Err(fault) => {
                // A refusal says more than the silence that ends the other form.
                if !matches!((self.fault, fault), (Some(PeerFault::Refuses(_)), PeerFault::Unanswered)) {
                    self.fault = Some(fault);
                }
                self.end(platform);
                Some(false)
            }
        }
    }

    /// Does the next step. Returns `true` when the connection is there.
    fn step<P: Platform>(&mut self, platform: &mut P, introduction: &Message<'_>) -> Result<bool, PeerFault> {
        if let ConnectStage::Connecting(socket, true) = self.stage {
            platform.connected(socket).map_err(PeerFault::Unreachable)?;
            self.connection.open(socket);
            self.stage = ConnectStage::Introduced;
            self.output().push(introduction).map_err(|_| PeerFault::Unreachable(NetError::NoSocketLeft))?;
            self.says_transient = self.says_transient.xor(Some(false));
        }
        self.flush(platform);
        if let (ConnectStage::Introduced, Some(socket)) = (self.stage, self.connection.socket()) {
            match platform.read(socket, self.answer.space()) {
                Ok(Transfer::Bytes(count)) => self.answer.filled(count),
                Ok(Transfer::WouldBlock) => {}
                Ok(Transfer::Closed) => return Err(PeerFault::Unanswered),
                Err(error) => return Err(PeerFault::Unreachable(error)),
            }
            match read_answer(self.answer.bytes()) {
                IntroductionReply::Incomplete => {}
                IntroductionReply::Accepted => {
                    self.stage = ConnectStage::Open;
                    return Ok(true);
                }
                IntroductionReply::Rejected(code) => return Err(PeerFault::Refuses(code)),
                IntroductionReply::Wrong(error) => return Err(PeerFault::Bytes(error)),
            }
        }
        if self.stage == ConnectStage::Ended {
            return Err(self.fault.unwrap_or(PeerFault::Unanswered));
        }
        if self.is_attempt() && platform.now() < self.answer_due { Ok(false) } else { Err(PeerFault::Unanswered) }
    }

    fn is_attempt(&self) -> bool {
        matches!(self.stage, ConnectStage::Connecting(..) | ConnectStage::Introduced)
    }

    /// Returns when to give up the open attempt.
    pub(super) fn poll_timeout(&self) -> Deadline {
        if self.is_attempt() { Deadline::At(self.answer_due) } else { Deadline::Never }
    }

    /// Returns when to look for the other federate.
    #[cfg(feature = "transients")]
    pub(super) fn poll_search(&self) -> Deadline {
        if self.is_attempt() { Deadline::Never } else { self.wanted.into() }
    }

    /// Reads the end of the other side, which never says anything else, if a wait has reported input.
    pub(super) fn detect_end<P: Platform>(&mut self, platform: &mut P) {
        if let (ConnectStage::Open, Some(socket)) = (self.stage, self.connection.socket())
            && self.connection.take_readable()
            && !matches!(platform.read(socket, &mut [0; 1]), Ok(Transfer::WouldBlock | Transfer::Bytes(_)))
        {
            self.lose_peer(platform);
        }
    }

    pub(super) fn set_interest<P: Platform>(&self, platform: &mut P) {
        if let ConnectStage::Connecting(socket, _) = self.stage {
            platform.set_interest(socket, Interest::WRITE);
        } else if let Some(socket) = self.connection.socket() {
            platform.set_interest(socket, Interest { readable: true, writable: !self.is_empty() });
        }
    }

    /// Reads the end of the other side, though no wait has reported it.
    pub(super) fn detect_end_now<P: Platform>(&mut self, platform: &mut P) {
        self.connection.mark_readable();
        self.detect_end(platform);
    }

    /// Handles that a wait found this socket ready.
    pub(super) fn handle_ready(&mut self, ready: SocketId, interest: Interest) {
        self.connection.handle_ready(ready, interest);
        if let ConnectStage::Connecting(socket, has_outcome) = &mut self.stage {
            *has_outcome |= *socket == ready;
        }
    }
}
