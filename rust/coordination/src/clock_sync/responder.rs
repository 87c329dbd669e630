// SPDX-License-Identifier: Apache-2.0
//! The federate's side of the rounds over UDP.
//!
//! A round is T1, T3, T4 and the coded probe, and any of them can be lost, come twice, or come after what was sent
//! later. Nothing on the wire says to which round a datagram belongs, but its time does: the RTI begins a round only
//! when the one before is over, so a T4 that is earlier than the T1 at hand belongs to an earlier round, and a T1 that
//! is not later than the last one is a copy or a straggler. What is lost costs its own round and no other.
//!
//! Datagrams can be made up by any program that sends from the RTI's address. An RTI has one UDP port, so the rounds of
//! the first one count, and others only when that has been silent for long; and times that are far off the own clock,
//! which was set over TCP, are ignored. Both are told. It bounds what somebody can do who cannot be told from the RTI.

use lf_model::time::{Instant, Interval};
use lf_wire::{Decoded, Limits, Message, decode};

use super::trouble::Trouble;
use super::{Exchange, ROUND_TIME_OUT};
use crate::Endpoint;

/// No RTI begins rounds in quicker succession: a T1 that follows another one so closely is no new round, and is not
/// answered, as in the stock federate.
const ROUND_MIN: Interval = Interval::from_millis(1);

/// After how long without a round from the RTI's port those of another one are taken.
const PORT_SILENCE: Interval = Interval::from_secs(10);
/// How far a time may be off the own clock. It was set over TCP, and no oscillator takes it so far within an hour; a
/// computer that was asleep is farther off, and its times are of no use.
const OFF_MAX: Interval = Interval::from_secs(60);

/// What a datagram led to.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Heard {
    /// A round is complete.
    pub round: Option<Round>,
    /// T3 is to be sent to where the datagram came from, at once; then [`Responder::answered`].
    pub answer: bool,
    /// Why it was ignored, if somebody should know.
    pub trouble: Option<Trouble>,
}

/// A complete round: its exchange, with what the coded probe said about the network.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Round {
    /// The exchange.
    pub exchange: Exchange,
    /// How much farther apart, or closer together, T4 and the coded probe came than they were sent; `None` if the probe
    /// was lost.
    pub gap: Option<Interval>,
}

/// One round at a time, as far as it is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    /// T1 is next.
    Idle,
    /// T1 has come, T3 is to be sent.
    Asked,
    /// T3 was sent at this time; T4 is next.
    Answered(Instant),
    /// T4 has come, at this time; the coded probe is next.
    Complete(Exchange, Instant),
}

/// Takes part in the RTI's rounds.
#[derive(Clone, Debug)]
pub struct Responder {
    stage: Stage,
    /// The last T1: what it said, when it came, and from where.
    last: Option<(Instant, Instant, Endpoint)>,
}

impl Default for Responder {
    fn default() -> Self {
        Self::new()
    }
}

impl Responder {
    /// Before the first round.
    pub const fn new() -> Self {
        Self { stage: Stage::Idle, last: None }
    }

    /// A datagram from the RTI's address has come; `now` is the time right after it was read, and `physical` what the
    /// RTI's clock shows then as far as that is known.
    pub fn handle(&mut self, now: Instant, physical: Option<Instant>, from: Endpoint, datagram: &[u8]) -> Heard {
        let message = match decode(datagram, &Limits::NONE) {
            Ok(Decoded::Complete { message, len }) if len == datagram.len() => message,
            _ => return Heard::default(),
        };
        if let Some(trouble) = self.check(now, physical, from, &message) {
            return Heard { trouble: Some(trouble), ..Heard::default() };
        }
        match message {
            Message::T1(t1) => self.begin(now, Instant::from_nanos(t1), from),
            Message::T4(t4) => self.complete(now, Instant::from_nanos(t4), from),
            Message::CodedProbe(t5) => self.probe(now, Instant::from_nanos(t5), from),
            _ => Heard::default(),
        }
    }

    /// T3 is being sent; `now` is the time right before. What delays it after this makes the exchange slower, and a
    /// slow exchange counts less; a time after the sending could make a disturbed exchange look quick.
    pub fn answered(&mut self, now: Instant) {
        if self.stage == Stage::Asked {
            self.stage = Stage::Answered(now);
        }
    }

    /// Why a datagram is ignored: it is from another port than the rounds, or its time cannot be the RTI's.
    fn check(&self, now: Instant, physical: Option<Instant>, from: Endpoint, message: &Message<'_>) -> Option<Trouble> {
        let (Message::T1(time) | Message::T4(time) | Message::CodedProbe(time)) = *message else { return None };
        if let Some((_, came, sender)) = self.last
            && sender != from
            && now.since(came) < PORT_SILENCE
        {
            return Some(Trouble::OtherPort { port: sender.port, other: from.port });
        }
        let off = Instant::from_nanos(time).since(physical?);
        (off.as_nanos().saturating_abs() > OFF_MAX.as_nanos()).then_some(Trouble::FarOff(off))
    }

    fn begin(&mut self, now: Instant, t1: Instant, from: Endpoint) -> Heard {
        if let Some((last, came, _)) = self.last
            && now.since(came) < ROUND_TIME_OUT
        {
            if t1 <= last {
                return Heard::default();
            }
            if matches!(self.stage, Stage::Answered(_)) && t1.since(last) < ROUND_MIN {
                self.stage = Stage::Idle;
                return Heard::default();
            }
        }
        let round = match self.stage {
            Stage::Complete(exchange, _) => Some(Round { exchange, gap: None }),
            _ => None,
        };
        self.stage = Stage::Asked;
        self.last = Some((t1, now, from));
        Heard { round, answer: true, trouble: None }
    }

    fn complete(&mut self, now: Instant, t4: Instant, from: Endpoint) -> Heard {
        if let (Stage::Answered(t3), Some((t1, t2, sender))) = (self.stage, self.last)
            && sender == from
            && t4 >= t1
        {
            self.stage = Stage::Complete(Exchange { t1, t2, t3, t4 }, now);
        }
        Heard::default()
    }

    fn probe(&mut self, now: Instant, t5: Instant, from: Endpoint) -> Heard {
        let Stage::Complete(exchange, came) = self.stage else { return Heard::default() };
        if self.last.is_none_or(|(.., sender)| sender != from) || t5 < exchange.t4 {
            return Heard::default();
        }
        self.stage = Stage::Idle;
        let apart = now.since(came).as_nanos().saturating_sub(t5.since(exchange.t4).as_nanos());
        let gap = Some(Interval::from_nanos(apart.saturating_abs()));
        Heard { round: Some(Round { exchange, gap }), ..Heard::default() }
    }
}
