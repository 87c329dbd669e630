// SPDX-License-Identifier: Apache-2.0
//! The correction of a clock that has an offset and a drift.

use lf_derive::outlined;
use lf_model::time::{Instant, Interval};

/// One second: the denominator of rates in parts per billion.
pub(super) const BILLION: i64 = 1_000_000_000;

/// The time by which the RTI's clock is ahead of the federate's own, as a line over time.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Line {
    /// A reading of the own clock.
    pub at: Instant,
    /// The offset to add to the own clock there.
    pub offset: Interval,
    /// The rate by which the RTI's clock is faster, in parts per billion.
    pub drift_ppb: i32,
    /// The usual distance of the bounds: the offset is wrong by at most half of it, and usually by far less.
    pub width: Interval,
}

impl Line {
    /// Returns the offset to add to the own clock at `own`.
    pub fn offset_at(&self, own: Instant) -> Interval {
        let elapsed = own.as_nanos().saturating_sub(self.at.as_nanos());
        Interval::from_nanos(self.offset.as_nanos().saturating_add(scale(elapsed, self.drift_ppb)))
    }
}

/// Returns `nanos` × `ppb` / 10⁹, rounded down, without overflow for any rate of less than 1.
#[outlined]
pub(super) fn scale(nanos: i64, ppb: i32) -> i64 {
    let ppb = i64::from(ppb);
    let (whole, rest) = (nanos.div_euclid(BILLION), nanos.rem_euclid(BILLION));
    whole.saturating_mul(ppb).saturating_add((rest * ppb).div_euclid(BILLION))
}
