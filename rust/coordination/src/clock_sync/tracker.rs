// SPDX-License-Identifier: Apache-2.0
//! Tracks an offset and a drift by a stream of exchanges.
//!
//! Each exchange proves two bounds. T1 cannot have come before it was sent, so the RTI's clock is ahead of the
//! federate's by at least T1 − T2; and likewise for T3, by at most T4 − T3. The distance from the truth is the time in
//! the network, and among many messages in one direction one was fast. So a batch of exchanges keeps the highest lower
//! bound and the lowest upper bound, which may come from different exchanges, and its point lies between them: jitter
//! in one direction does not need a calm opposite direction at the same time, and more exchanges reduce it further.
//! This assumes, as every method has to, that the fastest messages take equally long in both directions.
//!
//! A line goes through the points of the last batches, and its slope is the drift: the median of the slopes between
//! any two points, so that a few wrong ones change nothing. Batches with distant bounds do not count.
//!
//! The distance of the bounds and the length of the points determine the *uncertainty* of the drift. At the beginning
//! any drift is possible. A batch is over when the uncertainty makes a larger difference within it than its bounds
//! leave open: while the drift is unknown, each exchange is a point, and two of them prove a large drift. A slope that
//! differs from the line's by less than the uncertainty counts only when the uncertainty is small.
//!
//! A clock that stood still for a while, like that of a simulated board on a busy computer, makes bounds that exclude
//! each other. Then the batch's fastest exchange counts by itself. The tracker leaves out an exchange that
//! contradicts the line. When many do, or all do for some time, the line is wrong: the tracker restarts and keeps only
//! the slope, with full uncertainty. The more often this happens, the shorter the batches become, because old
//! exchanges say nothing about a rate that changes quickly.

use lf_derive::outlined;
use lf_model::time::{Instant, Interval};

use super::clock_fault::ClockFault;
use super::estimator::Exchange;
use super::line::{Line, scale};
use super::responder::Round;

/// The number of batches that the line goes through.
const BATCHES: usize = 16;
/// The number of pairs of points, with that of the current batch.
const PAIRS: usize = (BATCHES + 1) * BATCHES / 2;
/// The duration of a batch.
const BATCH: Interval = Interval::from_secs(1);
/// The minimum duration of a batch that the uncertainty ends.
const BATCH_MIN: Interval = Interval::from_millis(125);
/// The number of exchanges in a batch, because only among several can a fast one be told from a slow one.
const EXCHANGES: u16 = 8;
/// The maximum number of halvings of both.
const HALVINGS_MAX: u8 = 3;
/// After this many batches without a restart, one halving is undone.
const STABLE_BATCHES: u8 = 32;
/// The tolerance by which T4 and the coded probe of a calm network come as far apart as they were sent: the stock
/// federate's guard band. Such an exchange is good by itself, without others to compare it with.
const GUARD_BAND: Interval = Interval::from_micros(100);
/// Insignificant differences: clocks tick, and processors do not answer at once.
const TOLERANCE_NS: i64 = 20_000;
/// The tolerance for contradictions with the line, in addition to twice the usual distance of the bounds.
const CONTRADICTION_NS: i64 = 100_000;
/// The amount by which the drift may have changed since it was found, or be wrong.
const DRIFT_SLACK_PPB: i32 = 50_000;
/// If this many more exchanges contradict the line than agree with it, the line is wrong.
const CONTRADICTIONS_MAX: u8 = 16;
/// The same number if none has agreed for the duration of a batch.
const CONTRADICTIONS_LONG: u8 = 4;
/// Without information, the clock may as well stand still.
const ANY_DRIFT_PPB: i32 = 1_000_000_000;
/// An uncertainty so small that any slope counts.
const UNCERTAINTY_SMALL_PPB: i32 = 100_000;
/// More drift than that of any oscillator: 10 ms in a second.
const DRIFT_LARGE_PPB: i32 = 10_000_000;
/// An error below this is not reported.
const REPORTED_ERROR_NS: i64 = 1_000_000;
/// This many points prove a drift, though the clock stood still between some of them.
const POINTS_SURE: usize = BATCHES / 2;
/// Points closer together than this are not compared.
const PAIR_MIN_NS: i64 = 400_000_000;

/// A bound of the offset, and the time at which it held. Relative to the first exchange.
#[derive(Clone, Copy, Debug)]
struct Bound {
    at: i64,
    offset: i64,
}

/// The exchanges that make one point of the line.
#[derive(Clone, Copy, Debug)]
struct Batch {
    begun: i64,
    lower: Bound,
    upper: Bound,
    /// The fastest exchange.
    best: (Bound, Bound),
    count: u16,
    /// The number of exchanges whose coded probe showed a calm network.
    pure: u16,
}

/// The result of a batch.
#[derive(Clone, Copy, Debug)]
struct Point {
    at: i64,
    offset: i64,
    /// The distance of the bounds.
    width: i64,
}

/// Collects exchanges; see the module's description for the line through them.
#[derive(Clone, Debug)]
pub struct Tracker {
    /// The origin of own clock and offset: offsets between a clock since boot and one since 1970 leave no room for sums
    /// of them.
    origin: Option<(i64, i64)>,
    points: heapless::Deque<Point, BATCHES>,
    open: Option<Batch>,
    line: Option<Line>,
    /// The line's slope, which survives a restart.
    drift_ppb: i32,
    /// The possible error of the slope, by the points that it was found from.
    uncertainty_ppb: i32,
    /// The number of halvings of a batch's duration.
    halvings: u8,
    /// The number of batches since that changed.
    stable_batches: u8,
    contradictions: u8,
    /// The time at which an exchange last agreed with the line.
    agreed: i64,
    /// The error of the line at the last restart.
    restart_error_ns: i64,
    seen: u32,
    unused: u32,
    pure: u32,
}

impl Default for Tracker {
    fn default() -> Self {
        Self::new()
    }
}

impl Tracker {
    /// Returns a tracker without exchanges.
    pub const fn new() -> Self {
        Self {
            origin: None,
            points: heapless::Deque::new(),
            open: None,
            line: None,
            drift_ppb: 0,
            uncertainty_ppb: ANY_DRIFT_PPB,
            halvings: 0,
            stable_batches: 0,
            contradictions: 0,
            agreed: 0,
            restart_error_ns: 0,
            seen: 0,
            unused: 0,
            pure: 0,
        }
    }

    /// Returns the line through the exchanges; `None` if there are too few.
    pub fn line(&self) -> Option<Line> {
        self.line
    }

    /// Returns the number of exchanges, the number of those that were false or contradicted the others, and the number
    /// of those whose coded probe showed a calm network.
    pub fn counts(&self) -> (u32, u32, u32) {
        (self.seen, self.unused, self.pure)
    }

    /// Returns what is wrong with the federate's clock, as far as that is known.
    pub fn fault(&self) -> Option<ClockFault> {
        let is_sure = self.points.len() >= POINTS_SURE && self.uncertainty_ppb <= DRIFT_LARGE_PPB;
        if is_sure && self.drift_ppb.saturating_abs() > DRIFT_LARGE_PPB {
            return Some(ClockFault::Drift(self.drift_ppb));
        }
        let is_unsteady = self.halvings == HALVINGS_MAX && self.restart_error_ns >= REPORTED_ERROR_NS;
        is_unsteady.then_some(ClockFault::Unsteady(Interval::from_nanos(self.restart_error_ns)))
    }

    /// Records one exchange, in a bounded number of steps.
    pub fn record(&mut self, round: Round) {
        let Round { exchange, gap } = round;
        self.seen = self.seen.saturating_add(1);
        let pure = gap.is_some_and(|gap| gap < GUARD_BAND);
        self.pure = self.pure.saturating_add(pure.into());
        let (lower, upper) = self.bounds(&exchange);
        if exchange.round_trip().as_nanos() < 0 || self.contradicts(lower, upper) {
            self.unused = self.unused.saturating_add(1);
            return;
        }
        let drift_ppb = self.drift_ppb;
        if let Some(batch) = self.open {
            let (lasts, point) = (lower.at.saturating_sub(batch.begun), batch.point(drift_ppb));
            if lasts >= BATCH_MIN.as_nanos() && scale(lasts, self.uncertainty_ppb) > point.width.saturating_abs() {
                self.close(point);
            }
        }
        let fresh = Batch { begun: lower.at, lower, upper, best: (lower, upper), count: 0, pure: 0 };
        let batch = self.open.get_or_insert(fresh);
        batch.add(lower, upper, pure, drift_ppb);
        let (Batch { begun, count, pure, .. }, point) = (*batch, batch.point(drift_ppb));
        let enough = EXCHANGES >> self.halvings;
        if upper.at.saturating_sub(begun) >= BATCH.as_nanos() >> self.halvings && count >= enough {
            self.close(point);
        } else if count.is_power_of_two() && (count >= enough || pure > 0) {
            self.fit(Some(point));
        }
    }

    /// Ends the current batch with this point.
    fn close(&mut self, point: Point) {
        self.open = None;
        if self.points.is_full() {
            self.points.pop_front();
        }
        // There is a free entry now.
        let _ = self.points.push_back(point);
        self.stable_batches = self.stable_batches.saturating_add(1);
        if self.stable_batches >= STABLE_BATCHES {
            self.stable_batches = 0;
            self.halvings = self.halvings.saturating_sub(1);
        }
        self.fit(None);
    }

    fn bounds(&mut self, exchange: &Exchange) -> (Bound, Bound) {
        let Exchange { t1, t2, t3, t4 } = *exchange;
        let (own, offset) = *self.origin.get_or_insert((t2.as_nanos(), exchange.offset().as_nanos()));
        let bound = |rti: Instant, at: Instant| Bound {
            at: at.as_nanos().saturating_sub(own),
            offset: rti.as_nanos().saturating_sub(at.as_nanos()).saturating_sub(offset),
        };
        (bound(t1, t2), bound(t4, t3))
    }

    /// Returns whether the line is neither between these bounds nor near them. Restarts when that happens too often.
    fn contradicts(&mut self, lower: Bound, upper: Bound) -> bool {
        let (Some(line), Some((own, offset))) = (self.line, self.origin) else { return false };
        let since = own.saturating_add(lower.at).saturating_sub(line.at.as_nanos());
        let slack_ppb = DRIFT_SLACK_PPB.saturating_add(self.uncertainty_ppb);
        let margin = line.width.as_nanos().saturating_mul(2).saturating_add(CONTRADICTION_NS);
        let margin = margin.saturating_add(scale(since.saturating_abs(), slack_ppb));
        let on_line = |bound: Bound| {
            let at = Instant::from_nanos(own.saturating_add(bound.at));
            line.offset_at(at).as_nanos().saturating_sub(offset)
        };
        let above = lower.offset.saturating_sub(on_line(lower));
        let below = on_line(upper).saturating_sub(upper.offset);
        let off = above.max(below);
        if off <= margin {
            self.contradictions = self.contradictions.saturating_sub(1);
            self.agreed = upper.at;
            return false;
        }
        self.contradictions += 1;
        let is_long = upper.at.saturating_sub(self.agreed) >= BATCH.as_nanos();
        if self.contradictions >= CONTRADICTIONS_MAX || is_long && self.contradictions >= CONTRADICTIONS_LONG {
            self.begin_anew(off);
        }
        true
    }

    /// Restarts with nothing but the slope, because the line has this error.
    fn begin_anew(&mut self, off: i64) {
        self.points.clear();
        (self.origin, self.open, self.line) = (None, None, None);
        self.uncertainty_ppb = ANY_DRIFT_PPB;
        (self.halvings, self.stable_batches) = ((self.halvings + 1).min(HALVINGS_MAX), 0);
        (self.contradictions, self.agreed, self.restart_error_ns) = (0, 0, off);
    }

    /// Fits the line to the points, and to that of the current batch.
    fn fit(&mut self, under_way: Option<Point>) {
        let Some((own, offset)) = self.origin else { return };
        let all: heapless::Vec<Point, { BATCHES + 1 }> = self.points.iter().copied().chain(under_way).collect();
        let Some(width) = median(all.iter().map(|point| point.width.saturating_abs())) else { return };
        let limit = width.saturating_mul(2).saturating_add(TOLERANCE_NS);
        let near: heapless::Vec<Point, { BATCHES + 1 }> =
            all.iter().copied().filter(|point| point.width.saturating_abs() <= limit).collect();
        let (Some(first), Some(last)) = (near.first(), near.last()) else { return };
        if let Some(found) = slope_ppb(&near) {
            let widest = near.iter().fold(width, |widest, point| widest.max(point.width.saturating_abs()));
            self.uncertainty_ppb = rate_ppb(widest, last.at.saturating_sub(first.at));
            let is_settled = near.len() >= 3 && self.uncertainty_ppb <= UNCERTAINTY_SMALL_PPB;
            if is_settled || found.abs_diff(self.drift_ppb) > self.uncertainty_ppb.unsigned_abs() {
                self.drift_ppb = found;
            }
        }
        let (drift_ppb, uncertainty_ppb) = (self.drift_ppb, self.uncertainty_ppb);
        let levels = near.iter().filter_map(|point| {
            let since = last.at.saturating_sub(point.at);
            // An uncertainty that moves a point by more than its bounds makes it useless for the offset now.
            let counts = scale(since, uncertainty_ppb) <= width;
            counts.then(|| point.offset.saturating_add(scale(since, drift_ppb)))
        });
        let Some(level) = middle_mean(levels) else { return };
        self.line = Some(Line {
            at: Instant::from_nanos(own.saturating_add(last.at)),
            offset: Interval::from_nanos(offset.saturating_add(level)),
            drift_ppb,
            width: Interval::from_nanos(width),
        });
    }
}

impl Batch {
    fn add(&mut self, lower: Bound, upper: Bound, pure: bool, drift_ppb: i32) {
        // Bounds of different times are compared as if they were of one time.
        let level = |bound: Bound| bound.offset.saturating_sub(scale(bound.at.saturating_sub(self.begun), drift_ppb));
        let (higher, deeper) = (level(lower) > level(self.lower), level(upper) < level(self.upper));
        if higher {
            self.lower = lower;
        }
        if deeper {
            self.upper = upper;
        }
        let distance = |(lower, upper): (Bound, Bound)| upper.offset.saturating_sub(lower.offset);
        if distance((lower, upper)) < distance(self.best) {
            self.best = (lower, upper);
        }
        self.count = self.count.saturating_add(1);
        self.pure = self.pure.saturating_add(pure.into());
    }

    fn point(&self, drift_ppb: i32) -> Point {
        let between = |lower: Bound, upper: Bound| {
            let apart = upper.offset.saturating_sub(lower.offset);
            let width = apart.saturating_sub(scale(upper.at.saturating_sub(lower.at), drift_ppb));
            let at = lower.at.saturating_add(upper.at.saturating_sub(lower.at) / 2);
            Point { at, offset: lower.offset.saturating_add(apart / 2), width }
        };
        let point = between(self.lower, self.upper);
        if point.width < -TOLERANCE_NS { between(self.best.0, self.best.1) } else { point }
    }
}

/// Returns the median of the slopes between any two points, in parts per billion; `None` if none are far enough apart.
fn slope_ppb(points: &[Point]) -> Option<i32> {
    let mut slopes: heapless::Vec<i64, PAIRS> = heapless::Vec::new();
    for (index, one) in points.iter().enumerate() {
        for other in &points[index + 1..] {
            let run = other.at.saturating_sub(one.at);
            if run >= PAIR_MIN_NS {
                // There are no more pairs than that.
                let _ = slopes.push(rate_ppb(other.offset.saturating_sub(one.offset), run).into());
            }
        }
    }
    slopes.sort_unstable();
    slopes.get(slopes.len() / 2).and_then(|slope| i32::try_from(*slope).ok())
}

/// Returns a slope in parts per billion, at most [`ANY_DRIFT_PPB`]; exact to a part per million.
#[outlined]
fn rate_ppb(rise: i64, run: i64) -> i32 {
    let limit = i64::from(ANY_DRIFT_PPB);
    let ppb = rise.saturating_mul(1_000_000) / (run / 1_000).max(1);
    i32::try_from(ppb.clamp(-limit, limit)).unwrap_or(ANY_DRIFT_PPB)
}

fn sorted(values: impl Iterator<Item = i64>) -> heapless::Vec<i64, { BATCHES + 1 }> {
    let mut values: heapless::Vec<i64, { BATCHES + 1 }> = values.collect();
    values.sort_unstable();
    values
}

fn median(values: impl Iterator<Item = i64>) -> Option<i64> {
    let values = sorted(values);
    values.get(values.len() / 2).copied()
}

/// Returns the mean of the half in the middle.
fn middle_mean(values: impl Iterator<Item = i64>) -> Option<i64> {
    let values = sorted(values);
    let quarter = values.len() / 4;
    let middle = values.get(quarter..values.len() - quarter)?;
    let first = *middle.first()?;
    let sum = middle.iter().fold(0_i64, |sum, value| sum.saturating_add(value.saturating_sub(first)));
    Some(first.saturating_add(sum / i64::try_from(middle.len()).unwrap_or(1)))
}
