// SPDX-License-Identifier: Apache-2.0
//! The correction from a federate's own clock to the federation's physical time.

use lf_derive::outlined;
use lf_model::time::{Instant, Interval};

use super::DATAGRAMS;
use super::line::{BILLION, Line, scale};

/// The fastest rate at which a [`ClockCorrection`] removes an error: 50 ms in a second, in parts per billion.
///
/// Far below 1, so that time goes on while it is slowed down, and far above the drift of any quartz.
pub const SLEW_PPB_MAX: i32 = 50_000_000;

/// The largest drift that a [`ClockCorrection`] corrects: 100 ms in a second, in parts per billion.
///
/// Quartzes drift by less than a thousandth of it, oscillators without one by a tenth, and a clock whose frequency is
/// configured wrong by anything.
pub const DRIFT_PPB_MAX: i32 = 100_000_000;

/// One second, in the type of a rate.
const PPB: i32 = 1_000_000_000;

/// Computes the federation's physical time from a federate's own clock.
///
/// The initial synchronization *creates* a correction ([`ClockCorrection::with_offset`]) before the time is used; this
/// is the only step. Later information only changes the rate ([`ClockCorrection::slew`],
/// [`ClockCorrection::set_drift`]), and no rate is below zero, so physical time never runs backwards. All arithmetic is
/// in integers, exact to 1 ns per change of rate.
///
/// Between changes, physical time is one rising line, or two while an error is removed, and is rounded down once. So
/// rounding never makes it run backwards either, and [`ClockCorrection::local`] is exact.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ClockCorrection {
    /// The beginning of the present period of constant rate, by the own clock.
    local: i64,
    /// The same instant in physical time.
    physical: i64,
    /// The rate by which physical time is always faster than the own clock, in parts per billion.
    drift_ppb: i32,
    /// The part of an error that is still to be removed.
    error: i64,
}

impl Default for ClockCorrection {
    fn default() -> Self {
        Self::NONE
    }
}

impl ClockCorrection {
    /// No correction: physical time is the own clock.
    pub const NONE: Self = Self { local: 0, physical: 0, drift_ppb: 0, error: 0 };

    /// Returns a correction that adds `offset` to the own clock.
    pub const fn with_offset(offset: Interval) -> Self {
        Self { local: 0, physical: offset.as_nanos(), drift_ppb: 0, error: 0 }
    }

    /// Returns whether `next` follows from this one by a step, and not by a change of rate.
    pub fn is_step(&self, next: &Self) -> bool {
        self.physical(Instant::from_nanos(next.local)).as_nanos() != next.physical
    }

    /// Returns physical time at `local` of the own clock.
    ///
    /// Later readings of the own clock give later or equal physical times, as long as they are not before the last
    /// change of rate.
    #[outlined]
    pub fn physical(&self, local: Instant) -> Instant {
        let elapsed = local.as_nanos().saturating_sub(self.local);
        if !DATAGRAMS {
            return Instant::from_nanos(self.physical.saturating_add(elapsed));
        }
        let (ppb, made_up) = if self.is_made_up(elapsed) {
            (self.drift_ppb, if elapsed < 0 { 0 } else { self.error })
        } else {
            (self.slewing_ppb(), 0)
        };
        let advanced = elapsed.saturating_add(scale(elapsed, ppb)).saturating_add(made_up);
        Instant::from_nanos(self.physical.saturating_add(advanced))
    }

    /// Returns the earliest reading of the own clock at which physical time has reached `physical`, to wait for.
    pub fn local(&self, physical: Instant) -> Instant {
        let ahead = physical.as_nanos().saturating_sub(self.physical);
        let elapsed = if !DATAGRAMS {
            ahead
        } else if ahead <= 0 {
            unscale(ahead, self.drift_ppb)
        } else {
            // The error is removed first; then time goes on without it.
            let slewing = unscale(self.error.saturating_abs(), SLEW_PPB_MAX - PPB);
            let meanwhile = unscale(ahead, self.slewing_ppb());
            if meanwhile < slewing {
                meanwhile
            } else {
                unscale(ahead.saturating_sub(self.error), self.drift_ppb).max(slewing)
            }
        };
        Instant::from_nanos(self.local.saturating_add(elapsed))
    }

    /// Adopts the line's rate from `now` of the own clock on, and removes the error from it: at once what exceeds the
    /// line's bounds, and 1/`attenuation` of the rest.
    ///
    /// Removes it at the rate [`SLEW_PPB_MAX`]. Called after each exchange, this reduces the error step by step and
    /// smooths the small changes of the line.
    pub fn steer(&mut self, now: Instant, line: &Line, attenuation: u16) {
        self.set_drift(now, line.drift_ppb);
        let offset = self.physical(now).as_nanos().saturating_sub(now.as_nanos());
        let error = line.offset_at(now).as_nanos().saturating_sub(offset);
        let width = line.width.as_nanos().saturating_abs();
        let small = error.clamp(width.saturating_neg(), width);
        self.slew(now, Interval::from_nanos(error - small + small / i64::from(attenuation.max(1))));
    }

    /// Removes `error` from `now` of the own clock on: positive when physical time is behind the RTI's.
    ///
    /// Removes it at the rate [`SLEW_PPB_MAX`]; the rest of an earlier error is dropped.
    pub fn slew(&mut self, now: Instant, error: Interval) {
        self.begin_period(now);
        self.error = error.as_nanos();
    }

    /// Makes physical time faster than the own clock by `ppb` parts per billion, from `now` of the own clock on.
    ///
    /// Limits the rate to ±[`DRIFT_PPB_MAX`].
    pub fn set_drift(&mut self, now: Instant, ppb: i32) {
        self.begin_period(now);
        self.drift_ppb = ppb.clamp(-DRIFT_PPB_MAX, DRIFT_PPB_MAX);
    }

    /// Moves the beginning of the period to `now` without a change of physical time there.
    fn begin_period(&mut self, now: Instant) {
        let elapsed = now.as_nanos().saturating_sub(self.local);
        let physical = self.physical(now).as_nanos();
        self.error = self.error.saturating_sub(self.made_up(elapsed));
        self.local = now.as_nanos();
        self.physical = physical;
    }

    /// Returns the part of the error that is removed after `elapsed` of this period.
    fn made_up(&self, elapsed: i64) -> i64 {
        let most = scale(elapsed.max(0), SLEW_PPB_MAX);
        self.error.clamp(most.saturating_neg(), most)
    }

    /// Returns whether the error is removed completely after `elapsed` of this period.
    fn is_made_up(&self, elapsed: i64) -> bool {
        self.error == 0 || elapsed < 0 || self.made_up(elapsed) == self.error
    }

    /// Returns the rate by which physical time is faster than the own clock while the error is removed.
    fn slewing_ppb(&self) -> i32 {
        self.drift_ppb.saturating_add(if self.error < 0 { -SLEW_PPB_MAX } else { SLEW_PPB_MAX })
    }
}

/// Returns the smallest number x with x + x × `ppb` / 10⁹ ≥ `nanos`, that is `nanos` / (1 + `ppb` / 10⁹) rounded up,
/// without overflow for any rate between -1 and 1.
#[outlined]
fn unscale(nanos: i64, ppb: i32) -> i64 {
    let rate = BILLION.saturating_add(ppb.into()).max(1);
    let (whole, rest) = (nanos.div_euclid(rate), nanos.rem_euclid(rate));
    whole.saturating_mul(BILLION).saturating_add((rest * BILLION + rate - 1) / rate)
}
