// SPDX-License-Identifier: Apache-2.0
//! From a stream of exchanges to an offset and a drift.
//!
//! Each exchange says two things that are certain. T1 cannot have come before it was sent, so the RTI's clock is ahead
//! of the federate's by T1 − T2 at least; and T3 likewise, so it is ahead by T4 − T3 at most. How much is missing to
//! the truth is what the network took, and of many messages in one direction one was quick. So a stretch of time keeps
//! the highest lower bound and the lowest upper bound, which may come from different exchanges, and between them is its
//! point: jitter on one way does not need a calm way back at the same moment, and the more exchanges there are, the
//! less is left of it. This assumes what every method has to assume, that the quickest messages take equally long in
//! both directions.
//!
//! Through the points of the last stretches goes a line, of which the slope is the drift: the median of the slopes
//! between any two of them, so that a few wrong ones change nothing. Stretches whose bounds are far apart do not count.
//!
//! How far the bounds of the points are apart, and how long the points, says how much of the drift is still in *doubt*.
//! At the beginning it can be anything. A stretch is over when the doubt makes more of a difference within it than its
//! bounds leave open: where the drift is unknown, each exchange is a point, and two of them tell a large drift. A slope
//! that differs from the line's by less than the doubt is taken only when there is hardly any doubt.
//!
//! A clock that stood still for a moment, as that of a simulated board does while its computer is busy, makes bounds
//! that exclude each other. Then the stretch's quickest exchange counts by itself. An exchange that contradicts the
//! line is left out. When many do, or all do for some time, the line is wrong: all begins anew but for the slope, which
//! is in doubt again. The more often this happens, the shorter stretches become, for where a rate changes quickly, what
//! was long ago says nothing about now.

use lf_model::time::{Instant, Interval};

use super::estimator::Exchange;
use super::line::{Line, scale};
use super::responder::Round;
use super::trouble::Trouble;

/// How many stretches the line goes through.
const STRETCHES: usize = 16;
/// Pairs of as many points, with that of the stretch under way.
const PAIRS: usize = (STRETCHES + 1) * STRETCHES / 2;
/// How long a stretch lasts.
const STRETCH: Interval = Interval::from_secs(1);
/// The same at least, where it is over because of the doubt.
const STRETCH_MIN: Interval = Interval::from_millis(125);
/// How many exchanges a stretch has, for only among several can a quick one be told from a slow one.
const EXCHANGES: u16 = 8;
/// How often both are halved at most.
const HASTE_MAX: u8 = 3;
/// So many stretches without a new beginning take back one of these.
const CALM: u8 = 32;
/// T4 and the coded probe of a calm network come as far apart as they were sent, but for this: the stock federate's
/// guard band. Such an exchange is known to be good without others to compare it with.
const GUARD_BAND: Interval = Interval::from_micros(100);
/// Differences that are no sign of anything: clocks tick, and processors do not answer at once.
const TOLERANCE_NS: i64 = 20_000;
/// What an exchange may contradict the line by, in addition to twice the usual distance of the bounds.
const CONTRADICTION_NS: i64 = 100_000;
/// How much the drift may have changed since it was found, or be wrong.
const DRIFT_SLACK_PPB: i32 = 50_000;
/// So many more exchanges contradict the line than agree with it: it is wrong.
const CONTRADICTIONS_MAX: u8 = 16;
/// The same, where none has agreed for as long as a stretch lasts.
const CONTRADICTIONS_LONG: u8 = 4;
/// Where nothing is known, the clock may as well stand still.
const ANY_DRIFT_PPB: i32 = 1_000_000_000;
/// Hardly any doubt: a slope is taken whatever it is.
const UNCERTAINTY_SMALL_PPB: i32 = 100_000;
/// More drift than that of any oscillator: 10 ms in a second.
const DRIFT_LARGE_PPB: i32 = 10_000_000;
/// Times that are off by less are no trouble.
const ASTRAY_NS: i64 = 1_000_000;
/// So many points tell a drift for sure, though the clock stood still between some of them.
const POINTS_SURE: usize = STRETCHES / 2;
/// Points closer together than this are not compared.
const PAIR_MIN_NS: i64 = 400_000_000;

/// A bound of the offset, and when it held. Relative to the first exchange.
#[derive(Clone, Copy, Debug)]
struct Bound {
    at: i64,
    offset: i64,
}

/// The exchanges of a stretch of time.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    begun: i64,
    lower: Bound,
    upper: Bound,
    /// The quickest exchange.
    best: (Bound, Bound),
    count: u16,
    /// Exchanges whose coded probe has shown a calm network.
    pure: u16,
}

/// What a stretch says.
#[derive(Clone, Copy, Debug)]
struct Point {
    at: i64,
    offset: i64,
    /// The distance of the bounds.
    width: i64,
}

/// Collects exchanges; see the module's description for what it makes of them.
#[derive(Clone, Debug)]
pub struct Tracker {
    /// Where own clock and offset are counted from: offsets between a clock since boot and one since 1970 do not leave
    /// room for sums of them.
    origin: Option<(i64, i64)>,
    points: heapless::Deque<Point, STRETCHES>,
    open: Option<Stretch>,
    line: Option<Line>,
    /// The line's slope, which outlives it.
    drift_ppb: i32,
    /// How far from the truth that may be, by the points that it was found from.
    uncertainty_ppb: i32,
    /// How often the length of a stretch is halved.
    haste: u8,
    /// How many stretches are over since that changed.
    calm: u8,
    contradictions: u8,
    /// When an exchange last agreed with the line.
    agreed: i64,
    /// How far the line was off when all began anew.
    astray: i64,
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
    /// Without exchanges.
    pub const fn new() -> Self {
        Self {
            origin: None,
            points: heapless::Deque::new(),
            open: None,
            line: None,
            drift_ppb: 0,
            uncertainty_ppb: ANY_DRIFT_PPB,
            haste: 0,
            calm: 0,
            contradictions: 0,
            agreed: 0,
            astray: 0,
            seen: 0,
            unused: 0,
            pure: 0,
        }
    }

    /// What the exchanges say; `None` as long as there are too few.
    pub fn line(&self) -> Option<Line> {
        self.line
    }

    /// How many exchanges there were; how many of them were false or contradicted the others; and for how many the
    /// coded probe has shown a calm network.
    pub fn counts(&self) -> (u32, u32, u32) {
        (self.seen, self.unused, self.pure)
    }

    /// What is wrong with the federate's clock, as far as that is known.
    pub fn trouble(&self) -> Option<Trouble> {
        let is_sure = self.points.len() >= POINTS_SURE && self.uncertainty_ppb <= DRIFT_LARGE_PPB;
        if is_sure && self.drift_ppb.saturating_abs() > DRIFT_LARGE_PPB {
            return Some(Trouble::Drift(self.drift_ppb));
        }
        let is_unsteady = self.haste == HASTE_MAX && self.astray >= ASTRAY_NS;
        is_unsteady.then_some(Trouble::Unsteady(Interval::from_nanos(self.astray)))
    }

    /// Takes one exchange into account. Takes a bounded number of steps.
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
        if let Some(stretch) = self.open {
            let (lasts, point) = (lower.at.saturating_sub(stretch.begun), stretch.point(drift_ppb));
            if lasts >= STRETCH_MIN.as_nanos() && scale(lasts, self.uncertainty_ppb) > point.width.saturating_abs() {
                self.close(point);
            }
        }
        let fresh = Stretch { begun: lower.at, lower, upper, best: (lower, upper), count: 0, pure: 0 };
        let stretch = self.open.get_or_insert(fresh);
        stretch.add(lower, upper, pure, drift_ppb);
        let (Stretch { begun, count, pure, .. }, point) = (*stretch, stretch.point(drift_ppb));
        let enough = EXCHANGES >> self.haste;
        if upper.at.saturating_sub(begun) >= STRETCH.as_nanos() >> self.haste && count >= enough {
            self.close(point);
        } else if count.is_power_of_two() && (count >= enough || pure > 0) {
            self.fit(Some(point));
        }
    }

    /// The stretch under way is over, and this is its point.
    fn close(&mut self, point: Point) {
        self.open = None;
        if self.points.is_full() {
            self.points.pop_front();
        }
        // There is a place now.
        let _ = self.points.push_back(point);
        self.calm = self.calm.saturating_add(1);
        if self.calm >= CALM {
            self.calm = 0;
            self.haste = self.haste.saturating_sub(1);
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

    /// Whether the line is not between these bounds, nor near them. Begins anew when that is so too often.
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
        let is_long = upper.at.saturating_sub(self.agreed) >= STRETCH.as_nanos();
        if self.contradictions >= CONTRADICTIONS_MAX || is_long && self.contradictions >= CONTRADICTIONS_LONG {
            self.begin_anew(off);
        }
        true
    }

    /// Forgets all but the slope, because the line is so far off.
    fn begin_anew(&mut self, off: i64) {
        self.points.clear();
        (self.origin, self.open, self.line) = (None, None, None);
        self.uncertainty_ppb = ANY_DRIFT_PPB;
        (self.haste, self.calm) = ((self.haste + 1).min(HASTE_MAX), 0);
        (self.contradictions, self.agreed, self.astray) = (0, 0, off);
    }

    /// Lays the line through the points, and that of the stretch under way.
    fn fit(&mut self, under_way: Option<Point>) {
        let Some((own, offset)) = self.origin else { return };
        let all: heapless::Vec<Point, { STRETCHES + 1 }> = self.points.iter().copied().chain(under_way).collect();
        let Some(width) = median(all.iter().map(|point| point.width.saturating_abs())) else { return };
        let limit = width.saturating_mul(2).saturating_add(TOLERANCE_NS);
        let near: heapless::Vec<Point, { STRETCHES + 1 }> =
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
            // What the doubt moves by more than the bounds leave open says nothing of where the clock is now.
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

impl Stretch {
    fn add(&mut self, lower: Bound, upper: Bound, pure: bool, drift_ppb: i32) {
        // Bounds of different times are compared as if they were of one.
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

/// The median of the slopes between any two points, in parts per thousand million; `None` if none are far enough apart.
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

/// So much in so long, in parts per thousand million and no more than [`ANY_DRIFT_PPB`]; exact to a part per million.
#[cfg_attr(target_pointer_width = "32", inline(never))]
fn rate_ppb(rise: i64, run: i64) -> i32 {
    let limit = i64::from(ANY_DRIFT_PPB);
    let ppb = rise.saturating_mul(1_000_000) / (run / 1_000).max(1);
    i32::try_from(ppb.clamp(-limit, limit)).unwrap_or(ANY_DRIFT_PPB)
}

fn sorted(values: impl Iterator<Item = i64>) -> heapless::Vec<i64, { STRETCHES + 1 }> {
    let mut values: heapless::Vec<i64, { STRETCHES + 1 }> = values.collect();
    values.sort_unstable();
    values
}

fn median(values: impl Iterator<Item = i64>) -> Option<i64> {
    let values = sorted(values);
    values.get(values.len() / 2).copied()
}

/// The mean of the half in the middle.
fn middle_mean(values: impl Iterator<Item = i64>) -> Option<i64> {
    let values = sorted(values);
    let quarter = values.len() / 4;
    let middle = values.get(quarter..values.len() - quarter)?;
    let first = *middle.first()?;
    let sum = middle.iter().fold(0_i64, |sum, value| sum.saturating_add(value.saturating_sub(first)));
    Some(first.saturating_add(sum / i64::try_from(middle.len()).unwrap_or(1)))
}
