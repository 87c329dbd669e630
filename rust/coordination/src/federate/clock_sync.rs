// SPDX-License-Identifier: Apache-2.0
//! The clock of a federate: the exchanges that set it before the start, and the rounds over UDP that steer it while the
//! federation runs.

use core::fmt;

use lf_model::time::{Instant, Interval};
use lf_texts::say;
use lf_wire::Message;

use super::config::{ClockSync, Config};
use super::needs::Needs;
use crate::Endpoint;
use crate::clock_sync::{
    ClockCorrection, ClockFault, DATAGRAMS, Estimate, Estimator, Exchange, Line, Responder, Tracker,
};

/// The outcome of a datagram.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Received {
    /// The answer to send at once to where the datagram came from. Call [`Federate::answer_leaves`] with the time right
    /// before.
    ///
    /// [`Federate::answer_leaves`]: super::Federate::answer_leaves
    pub answer: Option<Message<'static>>,
    /// Whether [`Federate::clock`](super::Federate::clock) has a new rate from now on.
    pub corrected: bool,
    /// Whether the datagram came from a sender other than the RTI, and was ignored.
    pub stranger: bool,
    /// A problem of the federate's own clock, or of the times that it receives.
    pub fault: Option<ClockFault>,
}

/// The results of clock synchronization.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ClockSyncReport {
    /// The number of complete rounds.
    pub exchanges: u32,
    /// The number of rounds that were false or contradicted the others.
    pub unused: u32,
    /// The number of rounds whose coded probe showed a calm network.
    pub calm: u32,
    /// Offset and drift, as far as they are known.
    pub line: Option<Line>,
}

impl fmt::Display for ClockSyncReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { exchanges, unused, calm, line } = *self;
        say!(f, "{exchanges} rounds over UDP ({calm} on a calm network, {unused} of no use)")?;
        let Some(line) = line else { return Ok(()) };
        let drift_ns = -i64::from(line.drift_ppb);
        let verb = if drift_ns < 0 { "loses" } else { "gains" };
        say!(
            f,
            "; the own clock {verb} {} ns in a second; quickest round trips of about {} ns",
            drift_ns.unsigned_abs(),
            line.width.as_nanos()
        )
    }
}

/// The clock of a federate.
#[derive(Clone, Debug)]
pub(super) struct Clock {
    correction: ClockCorrection,
    /// The exchanges before the start.
    pub(super) initial: Synchronization,
    /// The rounds, where there can be rounds over UDP.
    rounds: [Rounds; DATAGRAMS as usize],
}

/// The state of the rounds over UDP.
#[derive(Clone, Debug)]
struct Rounds {
    responder: Responder,
    tracker: Tracker,
}

impl Clock {
    /// Returns a clock that shows this much less than physical time.
    pub(super) const fn new(offset: Interval) -> Self {
        Self {
            correction: ClockCorrection::with_offset(offset),
            initial: Synchronization::new(),
            rounds: [const { Rounds { responder: Responder::new(), tracker: Tracker::new() } }; DATAGRAMS as usize],
        }
    }

    /// Returns the correction from the federate's own clock to the federation's physical time.
    pub(super) fn correction(&self) -> &ClockCorrection {
        &self.correction
    }

    /// Sets the clock, before its time is used for the first time.
    pub(super) fn set(&mut self, estimate: &Estimate) {
        self.correction = ClockCorrection::with_offset(estimate.offset);
    }

    /// Handles a datagram; `now` is the time right after it was read.
    pub(super) fn handle_datagram(
        &mut self,
        config: &Config<'_, impl Needs>,
        now: Instant,
        from: Endpoint,
        datagram: &[u8],
    ) -> Received {
        let ClockSync::On { attenuation, .. } = config.clock_sync else { return Received::default() };
        if config.rti.is_some_and(|rti| rti != from.ip) {
            return Received { stranger: true, ..Received::default() };
        }
        let Some(Rounds { responder, tracker }) = self.rounds.first_mut() else { return Received::default() };
        let heard = responder.handle(now, Some(self.correction.physical(now)), from, datagram);
        let (mut corrected, mut fault) = (false, heard.fault);
        if let Some(round) = heard.round {
            tracker.record(round);
            fault = fault.or(tracker.fault());
            if let Some(line) = tracker.line() {
                self.correction.steer(now, &line, attenuation);
                corrected = true;
            }
        }
        let answer = heard.answer.then_some(Message::T3 { federate: config.id.0 });
        Received { answer, corrected, stranger: false, fault }
    }

    /// Records that the answer to a datagram is sent at `now`, the time right before.
    pub(super) fn answer_leaves(&mut self, now: Instant) {
        if let Some(rounds) = self.rounds.first_mut() {
            rounds.responder.answered(now);
        }
    }

    /// Returns the results of the rounds.
    pub(super) fn report(&self) -> ClockSyncReport {
        let Some(Rounds { tracker, .. }) = self.rounds.first() else { return ClockSyncReport::default() };
        let (exchanges, unused, calm) = tracker.counts();
        ClockSyncReport { exchanges, unused, calm, line: tracker.line() }
    }
}

/// The state of the initial clock synchronization.
#[derive(Clone, Debug)]
pub(super) struct Synchronization {
    estimator: Estimator,
    /// T1 and T2 of the current exchange.
    begun: Option<(Instant, Instant)>,
    t3: T3,
}

/// The reply of the current exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum T3 {
    /// It has to be sent.
    Due,
    /// It is in the out-buffer.
    Leaving,
    /// It was written at this time.
    Written(Instant),
}

impl Synchronization {
    const fn new() -> Self {
        Self { estimator: Estimator::new(), begun: None, t3: T3::Due }
    }

    /// Records that T3 has gone to the out-buffer.
    pub(super) fn t3_leaves(&mut self) {
        self.t3 = T3::Leaving;
    }

    /// Records that the out-buffer has been written.
    pub(super) fn written(&mut self, now: Instant) {
        if self.t3 == T3::Leaving {
            self.t3 = T3::Written(now);
        }
    }

    /// Handles T1; returns whether it was expected.
    pub(super) fn begin(&mut self, t1: Instant, t2: Instant) -> bool {
        let is_expected = self.begun.is_none();
        if is_expected {
            self.begun = Some((t1, t2));
            self.t3 = T3::Due;
        }
        is_expected
    }

    /// Handles T4; returns the number of exchanges so far, or `None` if it was not expected.
    pub(super) fn complete(&mut self, t4: Instant) -> Option<u16> {
        let t3 = match self.t3 {
            T3::Due => return None,
            // The event loop has not said when T3 was written. Its time in this federate then counts as time on the
            // way.
            T3::Leaving => self.begun?.1,
            T3::Written(t3) => t3,
        };
        let (t1, t2) = self.begun.take()?;
        self.estimator.record(Exchange { t1, t2, t3, t4 });
        Some(self.estimator.seen())
    }

    /// Returns the estimate from all exchanges, if there was one.
    pub(super) fn estimate(&self) -> Option<Estimate> {
        self.estimator.estimate()
    }
}
