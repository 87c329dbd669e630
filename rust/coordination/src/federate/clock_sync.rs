// SPDX-License-Identifier: Apache-2.0
//! Clock synchronization over UDP, while the federation runs.

use core::fmt;
use core::net::SocketAddrV4;

use lf_model::time::Instant;
use lf_wire::Message;

use super::config::ClockSync;
use super::machine::Federate;
use super::phase::Phase;
use crate::clock_sync::Line;

/// What a datagram led to.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Received {
    /// To be sent to where the datagram came from, at once; [`Federate::answer_leaves`] is told the time right before.
    pub answer: Option<Message<'static>>,
    /// [`Federate::clock`] has another rate from now on.
    pub corrected: bool,
    /// It came from somebody else than the RTI, and was ignored.
    pub stranger: bool,
}

/// What clock synchronization has found out.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ClockSyncReport {
    /// How many rounds were complete.
    pub exchanges: u32,
    /// How many of them were false, or contradicted the others.
    pub unused: u32,
    /// For how many the coded probe has shown a calm network.
    pub calm: u32,
    /// What they say.
    pub line: Option<Line>,
}

impl fmt::Display for ClockSyncReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { exchanges, unused, calm, line } = *self;
        write!(f, "{exchanges} rounds over UDP ({calm} on a calm network, {unused} of no use)")?;
        let Some(line) = line else { return Ok(()) };
        let drift_ns = -i64::from(line.drift_ppb);
        let verb = if drift_ns < 0 { "loses" } else { "gains" };
        write!(
            f,
            "; the own clock {verb} {} ns in a second; quickest round trips of about {} ns",
            drift_ns.unsigned_abs(),
            line.width.as_nanos()
        )
    }
}

impl Federate<'_> {
    /// A datagram has come on the port of [`Config::udp_port`](super::Config::udp_port); `now` is the time right after
    /// it was read.
    ///
    /// Never an error: what is lost, false or strange costs a round, and the clock goes on at its rate.
    pub fn handle_datagram(&mut self, now: Instant, from: SocketAddrV4, datagram: &[u8]) -> Received {
        let ClockSync::On { attenuation, .. } = self.config.clock_sync else { return Received::default() };
        if !matches!(self.phase, Phase::Starting | Phase::Running | Phase::Resigning) {
            return Received::default();
        }
        if self.config.rti.is_some_and(|rti| rti != *from.ip()) {
            return Received { stranger: true, ..Received::default() };
        }
        let heard = self.responder.handle(now, from, datagram);
        let mut corrected = false;
        if let Some(round) = heard.round {
            self.tracker.record(round);
            if let Some(line) = self.tracker.line() {
                self.clock.steer(now, &line, attenuation);
                corrected = true;
            }
        }
        let answer = heard.answer.then_some(Message::T3 { federate: self.config.id.0 });
        Received { answer, corrected, stranger: false }
    }

    /// The answer to a datagram is being sent; `now` is the time right before.
    pub fn answer_leaves(&mut self, now: Instant) {
        self.responder.answered(now);
    }

    /// What clock synchronization has found out; `None` unless it goes on while the federation runs.
    pub fn clock_sync_report(&self) -> Option<ClockSyncReport> {
        let ClockSync::On { .. } = self.config.clock_sync else { return None };
        let (exchanges, unused, calm) = self.tracker.counts();
        Some(ClockSyncReport { exchanges, unused, calm, line: self.tracker.line() })
    }
}
