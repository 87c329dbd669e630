// SPDX-License-Identifier: Apache-2.0
//! The RTI's side of the rounds over UDP, for one federate.

use lf_model::time::{Instant, Interval};

use super::ROUND_TIME_OUT;

/// The shortest time that the RTI waits for an answer.
const TIME_OUT_MIN: Interval = Interval::from_millis(100);

/// The current round with a federate, and the time that its answer may take.
///
/// T3 does not say which T1 it answers. So while an answer may still come, no other round begins with that federate;
/// otherwise a late T3 would count as a fast one. The time-out adapts to the network: a lost T3 costs little on a fast
/// network, and a slow network has up to [`ROUND_TIME_OUT`].
///
/// T4 does not name its T1 either, but its time does: a T1 is always later than the T4 of the round before.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Poll {
    stage: Stage,
    time_out: Interval,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Stage {
    /// No round has begun.
    Idle,
    /// T1 was sent at this time; T3 may come.
    Begun(Instant),
    /// T3 was answered at this time.
    Answered(Instant),
}

impl Poll {
    /// No round has begun.
    pub const NONE: Self = Self { stage: Stage::Idle, time_out: ROUND_TIME_OUT };

    /// Begins a round, unless one is under way whose answer may still come.
    pub fn begin(&mut self, now: Instant) -> bool {
        match self.stage {
            Stage::Begun(begun) if now.since(begun) < self.time_out => return false,
            Stage::Begun(_) => self.time_out = self.time_out.saturating_add(self.time_out).min(ROUND_TIME_OUT),
            // Coarse clocks can show the time of the last T4 for a while.
            Stage::Answered(at) if now == at => return false,
            Stage::Idle | Stage::Answered(_) => {}
        }
        self.stage = Stage::Begun(now);
        true
    }

    /// Handles T3. Returns `true` if it was expected, and has to be answered.
    pub fn answer(&mut self, now: Instant) -> bool {
        let Stage::Begun(begun) = self.stage else { return false };
        self.stage = Stage::Answered(now);
        let ample = now.since(begun).as_nanos().max(0).saturating_mul(8);
        let less = self.time_out.as_nanos() / 8 * 7;
        self.time_out = Interval::from_nanos(ample.max(less)).clamp(TIME_OUT_MIN, ROUND_TIME_OUT);
        true
    }
}
