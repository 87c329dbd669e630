// SPDX-License-Identifier: Apache-2.0
//! The schedule of attempts to connect to the RTI.

use lf_model::time::{Instant, Interval};

use super::config::{CONNECT_RETRY, CONNECT_TIME_OUT};

/// The next step towards a connection with the RTI.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ConnectStep {
    /// Try to connect.
    Attempt,
    /// Ask again at this time of the own clock.
    WaitUntil(Instant),
    /// Tell the user that the RTI cannot be reached.
    GiveUp,
}

/// Schedules attempts to connect to the RTI: at once, then at most every [`CONNECT_RETRY`], until [`CONNECT_TIME_OUT`]
/// has passed. Poll it whenever there is neither a connection nor an attempt. Keep it until the RTI has accepted the
/// federate, so that an RTI which closes each connection at once is tried with pauses and not without end.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ConnectRetry {
    next: Instant,
    give_up: Instant,
    pause: Interval,
}

impl ConnectRetry {
    /// Returns a schedule whose first attempt is due at once; `now` is the own clock.
    pub fn new(now: Instant) -> Self {
        Self::with_times(now, CONNECT_RETRY, CONNECT_TIME_OUT)
    }

    /// Returns a schedule with other times than the usual ones.
    pub fn with_times(now: Instant, pause: Interval, time_out: Interval) -> Self {
        Self { next: now, give_up: now + time_out, pause }
    }

    /// Restarts the time for attempts; the next one is not due earlier for that.
    pub fn renew(&mut self, now: Instant) {
        self.give_up = now + CONNECT_TIME_OUT;
    }

    /// Makes the next attempt due now, because it is of another kind than the last one.
    pub fn retry_now(&mut self, now: Instant) {
        self.next = self.next.min(now);
    }

    /// Returns the time of the last attempt; before the first one, a pause before that is due.
    pub fn last(&self) -> Instant {
        self.next - self.pause
    }

    /// Returns the time at which the last attempt ends, whatever its outcome.
    pub const fn give_up(&self) -> Instant {
        self.give_up
    }

    /// Returns the next step. It is `Attempt` once per attempt that is due.
    pub fn poll(&mut self, now: Instant) -> ConnectStep {
        if now >= self.give_up {
            return ConnectStep::GiveUp;
        }
        if now < self.next {
            return ConnectStep::WaitUntil(self.next.min(self.give_up));
        }
        self.next = now + self.pause;
        ConnectStep::Attempt
    }
}
