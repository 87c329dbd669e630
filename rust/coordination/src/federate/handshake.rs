// SPDX-License-Identifier: Apache-2.0
//! From the connection to the start: authentication, `FED_IDS` and ACK, `NEIGHBOR_STRUCTURE` and `UDP_PORT`, initial
//! clock synchronization, start barrier.

use lf_model::time::Instant;
use lf_wire::Message;

use super::config::{ClockSync, Coordination};
use super::error::FederateError;
use super::event::Event;
use super::machine::Federate;
use super::phase::Phase;
use crate::Deadline;
use crate::auth::{Nonce, Proof};
use crate::clock_sync::{ClockCorrection, Estimate, Estimator, Exchange};

/// The initial clock synchronization, as far as it is.
#[derive(Clone, Debug)]
pub(super) struct Synchronization {
    estimator: Estimator,
    /// T1 and T2 of the exchange under way.
    begun: Option<(Instant, Instant)>,
    t3: T3,
}

/// The reply of the exchange under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum T3 {
    /// It is to be sent.
    Due,
    /// It is in the out-buffer.
    Leaving,
    /// It was written at this time.
    Written(Instant),
}

impl Synchronization {
    pub(super) const fn new() -> Self {
        Self { estimator: Estimator::new(), begun: None, t3: T3::Due }
    }

    /// T3 has gone to the out-buffer.
    pub(super) fn t3_leaves(&mut self) {
        self.t3 = T3::Leaving;
    }

    /// The out-buffer has been written.
    pub(super) fn written(&mut self, now: Instant) {
        if self.t3 == T3::Leaving {
            self.t3 = T3::Written(now);
        }
    }

    /// T1 has come; whether it is its turn.
    fn begin(&mut self, t1: Instant, t2: Instant) -> bool {
        let turn = self.begun.is_none();
        if turn {
            self.begun = Some((t1, t2));
            self.t3 = T3::Due;
        }
        turn
    }

    /// T4 has come; returns how many exchanges there were, or `None` if it is not its turn.
    fn complete(&mut self, t4: Instant) -> Option<u16> {
        let t3 = match self.t3 {
            T3::Due => return None,
            // The event loop has not said when T3 was written. The time that it took here then counts as on the way.
            T3::Leaving => self.begun?.1,
            T3::Written(t3) => t3,
        };
        let (t1, t2) = self.begun.take()?;
        self.estimator.record(Exchange { t1, t2, t3, t4 });
        Some(self.estimator.seen())
    }
}

impl Federate<'_> {
    pub(super) fn introduce(&mut self, now: Instant, nonce: Nonce) {
        self.outbox.clear();
        if self.config.authentication.is_some() {
            self.phase = Phase::Authenticating;
            self.nonce = nonce;
            self.outbox.fed_nonce = Some(nonce);
        } else {
            self.phase = Phase::Introducing;
            self.outbox.fed_ids = true;
        }
        self.patience = Deadline::At(now + self.config.connect_time_out);
    }

    /// A message before the start.
    pub(super) fn handle_early<'m>(&mut self, now: Instant, message: &Message<'m>) -> Result<Event<'m>, FederateError> {
        match (self.phase, *message) {
            (_, Message::Failed) => Err(FederateError::RtiFailed),
            (Phase::Meeting, Message::AddressQueryReply { port, address }) => {
                Ok(self.handle_address(now, port, address))
            }
            // Answers to nothing that this federate asked; they do no harm.
            (_, Message::AddressQueryReply { .. }) => Ok(Event::None),
            // Also after the ACK: the stock RTI rejects with code 4 what comes in another order than it expects.
            (_, Message::Reject(code)) => Err(FederateError::Rejected(code)),
            (Phase::Authenticating, Message::RtiResponse { nonce, hmac }) if self.outbox.fed_nonce.is_none() => {
                self.authenticate(nonce, hmac).map(|()| Event::None)
            }
            (Phase::Introducing, Message::Ack) if !self.outbox.fed_ids => {
                self.accepted(now);
                Ok(Event::Accepted)
            }
            (Phase::Synchronizing, Message::T1(t1)) if self.sync.begin(Instant(t1), now) => {
                self.outbox.t3 = true;
                self.expect_clock_sync(now);
                Ok(Event::None)
            }
            (Phase::Synchronizing, Message::T4(t4)) => match self.sync.complete(Instant(t4)) {
                None => Err(self.unexpected(message)),
                Some(seen) => Ok(self.exchanged(now, seen)),
            },
            (Phase::Meeting | Phase::Starting, Message::T1(_)) => Err(match self.config.clock_sync.trials() {
                0 => self.unexpected(message),
                trials => FederateError::TrialsDiffer { trials },
            }),
            (Phase::Starting, Message::Timestamp(start)) if self.outbox.timestamp.is_none() => {
                let start = Instant(start);
                self.phase = Phase::Running;
                self.start = Some(start);
                Ok(Event::Started(start))
            }
            _ => Err(self.unexpected(message)),
        }
    }

    /// The RTI has kept this federate waiting beyond [`Federate::poll_timeout`].
    pub(super) fn lose_patience(&mut self, now: Instant) -> Result<Event<'static>, FederateError> {
        match (self.phase, self.sync.estimator.estimate()) {
            (Phase::Authenticating | Phase::Introducing, _) => Err(FederateError::NoAnswer),
            (Phase::Synchronizing, None) => Err(FederateError::NoClockSync),
            // The RTI makes fewer exchanges than this federate was told; those that there were will do.
            (Phase::Synchronizing, Some(estimate)) => Ok(self.synchronized(now, estimate)),
            (Phase::Meeting, _) => {
                self.meet(now);
                Ok(Event::None)
            }
            _ => {
                self.patience = Deadline::Never;
                Ok(Event::None)
            }
        }
    }

    /// The RTI has answered this federate's nonce. A right answer is repaid in kind, and the introduction follows.
    fn authenticate(&mut self, nonce: Nonce, proof: Proof) -> Result<(), FederateError> {
        let (key, id) = (self.config.federation_id, self.config.id.0);
        let response = self.config.authentication.and_then(|answer| answer(key, id, self.nonce, &proof, nonce));
        self.outbox.fed_response = Some(response.ok_or(FederateError::RtiNotAuthentic)?);
        self.outbox.fed_ids = true;
        self.phase = Phase::Introducing;
        Ok(())
    }

    fn accepted(&mut self, now: Instant) {
        self.outbox.neighbor_structure = true;
        self.outbox.udp_port = true;
        match self.config.clock_sync {
            ClockSync::Off => self.be_ready(now),
            ClockSync::Init { .. } | ClockSync::On { .. } => {
                self.phase = Phase::Synchronizing;
                self.expect_clock_sync(now);
            }
        }
    }

    fn expect_clock_sync(&mut self, now: Instant) {
        self.patience = Deadline::At(now + self.config.clock_sync_time_out);
    }

    /// One exchange is complete, `seen` in all.
    fn exchanged(&mut self, now: Instant, seen: u16) -> Event<'static> {
        let trials = self.config.clock_sync.trials();
        match self.sync.estimator.estimate() {
            Some(estimate) if seen >= trials => self.synchronized(now, estimate),
            _ => {
                self.expect_clock_sync(now);
                Event::None
            }
        }
    }

    fn synchronized(&mut self, now: Instant, estimate: Estimate) -> Event<'static> {
        self.clock = ClockCorrection::with_offset(estimate.offset);
        self.be_ready(now);
        Event::ClockCorrected(estimate)
    }

    /// Tells the RTI where this federate is, connects to others, and then tells the RTI the time, by which it chooses
    /// the start time.
    fn be_ready(&mut self, now: Instant) {
        self.outbox.t3 = false;
        // Where nothing is granted, nothing can be taken back.
        self.outbox.in_turn = self.config.coordination == Coordination::Centralized;
        self.outbox.advertisement = self.config.listening;
        self.meet(now);
    }
}
