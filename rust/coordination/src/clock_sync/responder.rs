// SPDX-License-Identifier: Apache-2.0
//! The federate's side of the rounds over UDP.
//!
//! A round is T1, T3, T4 and the coded probe. Each of them can be lost, come twice, or come after a later one. A
//! datagram does not name its round, but its time does: the RTI begins a round only when the one before is over, so a
//! T4 that is earlier than the current T1 belongs to an earlier round, and a T1 that is not later than the last one is
//! a copy or a straggler. A lost datagram costs its own round and no other.
//!
//! Any program that can send from the RTI's address can forge datagrams. An RTI has one UDP port, so the rounds of the
//! first port count, and another port counts only when the first has been silent for long; times that are far off the
//! own clock, which was set over TCP, are ignored. Both are logged. This bounds the effect of a sender that cannot be
//! told from the RTI.

use lf_model::time::{Instant, Interval};
use lf_wire::{Decoded, Limits, Message, decode};

use super::clock_fault::ClockFault;
use super::{Exchange, ROUND_TIME_OUT};
use crate::Endpoint;

/// The shortest time between rounds of any RTI: a T1 that follows another one more closely is not a new round, and is
/// not answered, as in the stock federate.
const ROUND_MIN: Interval = Interval::from_millis(1);

/// The silence of the RTI's port after which rounds of another port count.
const PORT_SILENCE: Interval = Interval::from_secs(10);
/// The largest accepted distance of a time from the own clock. The clock was set over TCP, and no oscillator drifts so
/// far within an hour. The times of a computer that was asleep are farther off and cannot be used.
const OFF_MAX: Interval = Interval::from_secs(60);

/// The outcome of a datagram.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Response {
    /// The complete round, if this datagram completed one.
    pub round: Option<Round>,
    /// Whether to send T3 at once to the source of the datagram; call [`Responder::answered`] then.
    pub answer: bool,
    /// The reason why it was ignored, if that should be logged.
    pub fault: Option<ClockFault>,
}

/// A complete round: its exchange, and what the coded probe showed about the network.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Round {
    /// The exchange.
    pub exchange: Exchange,
    /// The time by which T4 and the coded probe came farther apart, or closer together, than they were sent; `None` if
    /// the probe was lost.
    pub gap: Option<Interval>,
}

/// The progress of the current round.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    /// T1 is next.
    Idle,
    /// T1 has come; T3 has to be sent.
    Asked,
    /// T3 was sent at this time; T4 is next.
    Answered(Instant),
    /// T4 has come, at this time; the coded probe is next.
    Complete(Exchange, Instant),
}

/// Answers the RTI's rounds.
#[derive(Clone, Debug)]
pub struct Responder {
    stage: Stage,
    /// The last T1: its time, its arrival, and its source.
    last: Option<(Instant, Instant, Endpoint)>,
}

impl Default for Responder {
    fn default() -> Self {
        Self::new()
    }
}

impl Responder {
    /// Returns a responder before the first round.
    pub const fn new() -> Self {
        Self { stage: Stage::Idle, last: None }
    }

    /// Handles a datagram from the RTI's address; `now` is the time right after it was read, and `physical` the RTI's
    /// clock then, as far as it is known.
    pub fn handle(&mut self, now: Instant, physical: Option<Instant>, from: Endpoint, datagram: &[u8]) -> Response {
        let message = match decode(datagram, &Limits::NONE) {
            Ok(Decoded::Complete { message, len }) if len == datagram.len() => message,
            _ => return Response::default(),
        };
        if let Some(fault) = self.check(now, physical, from, &message) {
            return Response { fault: Some(fault), ..Response::default() };
        }
        match message {
            Message::T1(t1) => self.begin(now, Instant::from_nanos(t1), from),
            Message::T4(t4) => self.complete(now, Instant::from_nanos(t4), from),
            Message::CodedProbe(t5) => self.probe(now, Instant::from_nanos(t5), from),
            _ => Response::default(),
        }
    }

    /// Records that T3 is sent; `now` is the time right before. A later delay makes the exchange slower, and a slow
    /// exchange counts less; a time after the sending could make a disturbed exchange look fast.
    pub fn answered(&mut self, now: Instant) {
        if self.stage == Stage::Asked {
            self.stage = Stage::Answered(now);
        }
    }

    /// Returns the reason to ignore a datagram: it is from another port than the rounds, or its time cannot be the
    /// RTI's.
    fn check(
        &self,
        now: Instant,
        physical: Option<Instant>,
        from: Endpoint,
        message: &Message<'_>,
    ) -> Option<ClockFault> {
        let (Message::T1(time) | Message::T4(time) | Message::CodedProbe(time)) = *message else { return None };
        if let Some((_, came, sender)) = self.last
            && sender != from
            && now.since(came) < PORT_SILENCE
        {
            return Some(ClockFault::OtherPort { port: sender.port, other: from.port });
        }
        let off = Instant::from_nanos(time).since(physical?);
        (off.as_nanos().saturating_abs() > OFF_MAX.as_nanos()).then_some(ClockFault::FarOff(off))
    }

    fn begin(&mut self, now: Instant, t1: Instant, from: Endpoint) -> Response {
        if let Some((last, came, _)) = self.last
            && now.since(came) < ROUND_TIME_OUT
        {
            if t1 <= last {
                return Response::default();
            }
            if matches!(self.stage, Stage::Answered(_)) && t1.since(last) < ROUND_MIN {
                self.stage = Stage::Idle;
                return Response::default();
            }
        }
        let round = match self.stage {
            Stage::Complete(exchange, _) => Some(Round { exchange, gap: None }),
            _ => None,
        };
        self.stage = Stage::Asked;
        self.last = Some((t1, now, from));
        Response { round, answer: true, fault: None }
    }

    fn complete(&mut self, now: Instant, t4: Instant, from: Endpoint) -> Response {
        if let (Stage::Answered(t3), Some((t1, t2, sender))) = (self.stage, self.last)
            && sender == from
            && t4 >= t1
        {
            self.stage = Stage::Complete(Exchange { t1, t2, t3, t4 }, now);
        }
        Response::default()
    }

    fn probe(&mut self, now: Instant, t5: Instant, from: Endpoint) -> Response {
        let Stage::Complete(exchange, came) = self.stage else { return Response::default() };
        if self.last.is_none_or(|(.., sender)| sender != from) || t5 < exchange.t4 {
            return Response::default();
        }
        self.stage = Stage::Idle;
        let apart = now.since(came).as_nanos().saturating_sub(t5.since(exchange.t4).as_nanos());
        let gap = Some(Interval::from_nanos(apart.saturating_abs()));
        Response { round: Some(Round { exchange, gap }), ..Response::default() }
    }
}
