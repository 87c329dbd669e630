// SPDX-License-Identifier: Apache-2.0
//! When to try to connect to the RTI.

use lf_model::time::{Instant, Interval};

use super::config::{CONNECT_RETRY, CONNECT_TIME_OUT};

/// What to do about the connection to the RTI now.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ConnectStep {
    /// Try to connect.
    Attempt,
    /// Ask again at this time of the own clock.
    WaitUntil(Instant),
    /// Tell the user that the RTI cannot be reached.
    GiveUp,
}

/// Tells when to try to connect to the RTI: at once, then at most every [`CONNECT_RETRY`], until [`CONNECT_TIME_OUT`]
/// has passed. Ask whenever there is no connection and no attempt under way. Keep it until the RTI has accepted the
/// federate, so that an RTI which closes each connection at once is not tried without pause, nor for ever.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ConnectRetry {
    next: Instant,
    give_up: Instant,
    pause: Interval,
}

impl ConnectRetry {
    /// The first attempt is due at once; `now` is the own clock.
    pub fn new(now: Instant) -> Self {
        Self::with_times(now, CONNECT_RETRY, CONNECT_TIME_OUT)
    }

    /// The same with other times than the usual ones.
    pub fn with_times(now: Instant, pause: Interval, time_out: Interval) -> Self {
        Self { next: now, give_up: now + time_out, pause }
    }

    /// The time for attempts begins anew; the next one is not due earlier for that.
    pub fn renew(&mut self, now: Instant) {
        self.give_up = now + CONNECT_TIME_OUT;
    }

    /// The next attempt is due now, because it is of another kind than the last one.
    pub fn hurry(&mut self, now: Instant) {
        self.next = self.next.min(now);
    }

    /// When the last attempt was made; before the first one, a pause before that is due.
    pub fn last(&self) -> Instant {
        self.next - self.pause
    }

    /// When the last attempt is over, whatever its outcome.
    pub const fn give_up(&self) -> Instant {
        self.give_up
    }

    /// What to do now. `Attempt` is given once per attempt that is due.
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
