// SPDX-License-Identifier: Apache-2.0
//! Compares the edges of two signals: the pairs, their distances, and the change of these. No I/O.
//!
//! Times are in nanoseconds, as floating-point numbers, which are exact for a hundred days.

use serde::Serialize;

/// A change of a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Edge {
    pub(crate) time_ns: f64,
    pub(crate) is_rising: bool,
}

/// Edges of two signals that belong together: the time of the first one, and the delay of the other one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Pair {
    pub(crate) time_ns: f64,
    pub(crate) delay_ns: f64,
}

/// The pairs of edges of two signals.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Pairs {
    pub(crate) matched: Vec<Pair>,
    /// Edges of the reference that the other signal does not have, and the other way round.
    pub(crate) missing: usize,
    pub(crate) extra: usize,
}

/// Finds the edges that belong together: those of one kind that are each other's nearest, and not further apart than
/// the window. Both signals are in the order of time.
pub(crate) fn pair(reference: &[Edge], compared: &[Edge], window_ns: f64) -> Pairs {
    let mut pairs = Pairs::default();
    for is_rising in [true, false] {
        let times = |edges: &[Edge]| -> Vec<f64> {
            edges.iter().filter(|edge| edge.is_rising == is_rising).map(|edge| edge.time_ns).collect()
        };
        let (reference, compared) = (times(reference), times(compared));
        for (index, &time_ns) in reference.iter().enumerate() {
            let Some(other) = nearest(&compared, time_ns) else { continue };
            let delay_ns = compared[other] - time_ns;
            if delay_ns.abs() <= window_ns && nearest(&reference, compared[other]) == Some(index) {
                pairs.matched.push(Pair { time_ns, delay_ns });
            }
        }
    }
    pairs.matched.sort_by(|one, other| one.time_ns.total_cmp(&other.time_ns));
    pairs.missing = reference.len() - pairs.matched.len();
    pairs.extra = compared.len() - pairs.matched.len();
    pairs
}

/// Returns the index of the nearest of these times, the earlier one of two.
fn nearest(times: &[f64], time: f64) -> Option<usize> {
    let after = times.partition_point(|other| *other < time);
    let candidates = [after.checked_sub(1), Some(after).filter(|after| *after < times.len())];
    let distance = |index: &usize| (times[*index] - time).abs();
    let nearest = candidates.into_iter().flatten().min_by(|one, other| distance(one).total_cmp(&distance(other)));
    // Of edges at the same time the first one counts, so that being nearest is mutual.
    nearest.map(|index| times.partition_point(|other| *other < times[index]))
}

/// Returns the maximum distance of edges of one signal and kind from their partners such that these cannot be those of
/// the next one: half of the usual distance from edge to edge of a kind.
pub(crate) fn usual_window_ns(reference: &[Edge]) -> f64 {
    let mut distances: Vec<f64> = [true, false]
        .into_iter()
        .flat_map(|is_rising| {
            let times: Vec<f64> =
                reference.iter().filter(|edge| edge.is_rising == is_rising).map(|edge| edge.time_ns).collect();
            times.windows(2).map(|two| two[1] - two[0]).collect::<Vec<_>>()
        })
        .collect();
    distances.sort_by(f64::total_cmp);
    quantile(&distances, 0.5).map_or(f64::INFINITY, |distance| distance / 2.0)
}

/// The statistics of delays.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Statistics {
    pub(crate) count: usize,
    pub(crate) min_us: f64,
    pub(crate) mean_us: f64,
    pub(crate) median_us: f64,
    pub(crate) p99_us: f64,
    pub(crate) max_us: f64,
    /// The standard deviation.
    pub(crate) sigma_us: f64,
}

impl Statistics {
    /// Returns the statistics of at least one pair.
    pub(crate) fn of(pairs: &[Pair]) -> Option<Self> {
        let mut delays: Vec<f64> = pairs.iter().map(|pair| pair.delay_ns / 1e3).collect();
        delays.sort_by(f64::total_cmp);
        let mean_us = mean(&delays)?;
        let squares: f64 = delays.iter().map(|delay| (delay - mean_us).powi(2)).sum();
        Some(Self {
            count: delays.len(),
            min_us: *delays.first()?,
            mean_us,
            median_us: quantile(&delays, 0.5)?,
            p99_us: quantile(&delays, 0.99)?,
            max_us: *delays.last()?,
            sigma_us: if delays.len() < 2 { 0.0 } else { (squares / (count(delays.len()) - 1.0)).sqrt() },
        })
    }
}

/// The straight line through delays by least squares.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Line {
    pub(crate) slope_us_per_s: f64,
    /// The standard error of the slope.
    pub(crate) slope_error_us_per_s: f64,
    /// The value at the time 0.
    pub(crate) offset_us: f64,
    /// The standard deviation around the line.
    pub(crate) residual_us: f64,
    /// The median of the slopes between delays that are half of the recording apart, which single edges that a busy
    /// computer delayed do not change (Theil's incomplete method).
    pub(crate) median_slope_us_per_s: f64,
}

impl Line {
    /// Returns the line through at least three pairs that are not all at one time.
    pub(crate) fn through(pairs: &[Pair]) -> Option<Self> {
        if pairs.len() < 3 {
            return None;
        }
        let (times, delays): (Vec<f64>, Vec<f64>) =
            pairs.iter().map(|pair| (pair.time_ns / 1e9, pair.delay_ns / 1e3)).unzip();
        let (middle, mean_us) = (mean(&times)?, mean(&delays)?);
        let spread: f64 = times.iter().map(|time| (time - middle).powi(2)).sum();
        if spread <= 0.0 {
            return None;
        }
        let both: f64 = times.iter().zip(&delays).map(|(time, delay)| (time - middle) * (delay - mean_us)).sum();
        let slope_us_per_s = both / spread;
        let mut line = Self {
            slope_us_per_s,
            slope_error_us_per_s: 0.0,
            offset_us: mean_us - slope_us_per_s * middle,
            residual_us: 0.0,
            median_slope_us_per_s: median_slope_us_per_s(pairs)?,
        };
        let squares: f64 = pairs.iter().map(|pair| line.distance_us(pair).powi(2)).sum();
        line.residual_us = (squares / (count(pairs.len()) - 2.0)).sqrt();
        line.slope_error_us_per_s = line.residual_us / spread.sqrt();
        Some(line)
    }

    /// Returns the value of the line at a time in seconds.
    pub(crate) fn at_us(&self, time_s: f64) -> f64 {
        self.offset_us + self.slope_us_per_s * time_s
    }

    /// Returns the distance of a delay above the line.
    pub(crate) fn distance_us(&self, pair: &Pair) -> f64 {
        pair.delay_ns / 1e3 - self.at_us(pair.time_ns / 1e9)
    }
}

/// Returns the median slope of at least two pairs that are not all at one time.
fn median_slope_us_per_s(pairs: &[Pair]) -> Option<f64> {
    let later = &pairs[pairs.len() / 2..];
    let seconds = |earlier: &Pair, later: &Pair| (later.time_ns - earlier.time_ns) / 1e9;
    let apart = pairs.iter().zip(later).filter(|(earlier, later)| seconds(earlier, later) > 0.0);
    let slope = |(earlier, later): (&Pair, &Pair)| (later.delay_ns - earlier.delay_ns) / 1e3 / seconds(earlier, later);
    let mut slopes: Vec<f64> = apart.map(slope).collect();
    slopes.sort_by(f64::total_cmp);
    quantile(&slopes, 0.5)
}

/// The number of values in each of several intervals of one width.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Histogram {
    /// The beginning of the first interval.
    pub(crate) from_us: f64,
    pub(crate) width_us: f64,
    pub(crate) counts: Vec<usize>,
}

impl Histogram {
    /// Returns the histogram of at least one value, in this many intervals.
    pub(crate) fn of(values_us: &[f64], intervals: usize) -> Option<Self> {
        let from_us = values_us.iter().copied().min_by(f64::total_cmp)?;
        let to_us = values_us.iter().copied().max_by(f64::total_cmp)?;
        // Equal values are in one interval of a nanosecond.
        let width_us = ((to_us - from_us) / count(intervals)).max(0.001);
        let mut counts = vec![0; intervals];
        for value in values_us {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is limited by the number")]
            let interval = ((value - from_us) / width_us) as usize;
            // The greatest value is the end of the last one.
            counts[interval.min(intervals - 1)] += 1;
        }
        Some(Self { from_us, width_us, counts })
    }
}

/// Returns the smallest value that is not below this part of all. They are in order.
fn quantile(sorted: &[f64], part: f64) -> Option<f64> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is limited by the number")]
    let rank = (part * count(sorted.len())).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied()
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / count(values.len()))
}

#[expect(clippy::cast_precision_loss, reason = "nobody has 2^52 edges")]
fn count(number: usize) -> f64 {
    number as f64
}

#[cfg(test)]
mod tests {
    use proptest::collection::vec;
    use proptest::prelude::*;

    use super::*;

    /// Returns the edges of a pin that toggles after such pauses, in nanoseconds.
    fn toggles(pauses: &[u32]) -> Vec<Edge> {
        let mut time_ns = 0.0;
        let edge = |(index, pause): (usize, &u32)| {
            time_ns += f64::from(*pause);
            Edge { time_ns, is_rising: index % 2 == 0 }
        };
        pauses.iter().enumerate().map(edge).collect()
    }

    fn later(edges: &[Edge], by: impl Fn(usize) -> f64) -> Vec<Edge> {
        let moved = |(index, edge): (usize, &Edge)| Edge { time_ns: edge.time_ns + by(index), ..*edge };
        edges.iter().enumerate().map(moved).collect()
    }

    proptest! {
        /// Two boards differ by less than half of any pause: each edge finds its own partner.
        #[test]
        fn every_edge_finds_its_partner(
            pauses in vec(1000_u32..100_000, 2..200),
            delays in vec(-499_i32..499, 200),
        ) {
            let reference = toggles(&pauses);
            let compared = later(&reference, |index| f64::from(delays[index]));
            let pairs = pair(&reference, &compared, 500.0);
            prop_assert_eq!((pairs.missing, pairs.extra), (0, 0));
            let found: Vec<f64> = pairs.matched.iter().map(|pair| pair.delay_ns).collect();
            prop_assert_eq!(found, delays[..reference.len()].iter().map(|delay| f64::from(*delay)).collect::<Vec<_>>());
        }

        /// An edge that one of them lacks is counted, and changes nothing for the others.
        #[test]
        fn a_lost_edge_is_missing_alone(pauses in vec(1000_u32..100_000, 3..100), lost: prop::sample::Index) {
            let reference = toggles(&pauses);
            let mut compared = later(&reference, |_| 100.0);
            compared.remove(lost.index(reference.len()));
            let pairs = pair(&reference, &compared, 500.0);
            prop_assert_eq!((pairs.missing, pairs.extra), (1, 0));
            prop_assert!(pairs.matched.iter().all(|pair| (pair.delay_ns - 100.0).abs() < 1e-3));
            let pairs = pair(&compared, &reference, 500.0);
            prop_assert_eq!((pairs.missing, pairs.extra), (0, 1));
        }

        /// Whatever the edges are, none is in two pairs or beyond the window, and all are counted.
        #[test]
        fn no_edge_is_used_twice(
            one in vec(0_u32..3000, 0..60),
            other in vec(0_u32..3000, 0..60),
            window in 0_u32..5000,
        ) {
            let (one, other) = (toggles(&one), toggles(&other));
            let pairs = pair(&one, &other, window.into());
            prop_assert_eq!(pairs.matched.len() + pairs.missing, one.len());
            prop_assert_eq!(pairs.matched.len() + pairs.extra, other.len());
            prop_assert!(pairs.matched.iter().all(|pair| pair.delay_ns.abs() <= window.into()));
        }

        /// The line through points of a line is that line, whatever its slope.
        #[test]
        fn a_drift_is_found(
            slope in -500.0_f64..500.0,
            offset in -1e4_f64..1e4,
            pauses in vec(10_000_u32..1_000_000_000, 3..100),
        ) {
            let edges = toggles(&pauses);
            let pairs: Vec<Pair> = edges
                .iter()
                .map(|edge| Pair {
                    time_ns: edge.time_ns,
                    delay_ns: 1e3 * (offset + slope * edge.time_ns / 1e9),
                })
                .collect();
            let line = Line::through(&pairs).expect("there are three at different times");
            let seconds = edges.last().expect("there are some").time_ns / 1e9;
            prop_assert!((line.at_us(0.0) - offset).abs() < 1e-3);
            prop_assert!((line.at_us(seconds) - offset - slope * seconds).abs() < 1e-3);
            prop_assert!(line.residual_us < 1e-3);
            let found = line.median_slope_us_per_s;
            prop_assert!((found - slope).abs() < 1e-3);
        }

        /// A histogram has each value once, and as many intervals as asked for.
        #[test]
        fn all_values_are_in_the_histogram(values in vec(-1e6_f64..1e6, 1..300), intervals in 1_usize..50) {
            let histogram = Histogram::of(&values, intervals).expect("there are values");
            prop_assert_eq!(histogram.counts.len(), intervals);
            prop_assert_eq!(histogram.counts.iter().sum::<usize>(), values.len());
        }

        /// The numbers about delays are in order, whatever the delays are.
        #[test]
        fn statistics_are_in_order(delays in vec(-1e9_f64..1e9, 1..300)) {
            let pairs: Vec<Pair> = delays.iter().map(|&delay_ns| Pair { time_ns: 0.0, delay_ns }).collect();
            let of = Statistics::of(&pairs).expect("there are some");
            prop_assert!(of.min_us <= of.median_us && of.median_us <= of.p99_us && of.p99_us <= of.max_us);
            prop_assert!(of.min_us <= of.mean_us + 1e-6 && of.mean_us <= of.max_us + 1e-6 && of.sigma_us >= 0.0);
            prop_assert!(Line::through(&pairs).is_none());
        }
    }

    #[test]
    fn single_edges_that_are_held_up_do_not_change_the_median_slope() {
        let held_up = |index: u32| if index.is_multiple_of(10) { 5e6 } else { 0.0 };
        let delay = |index: u32| f64::from(index) * 26e3 + held_up(index);
        let pairs: Vec<Pair> =
            (0..101).map(|index| Pair { time_ns: f64::from(index) * 1e9, delay_ns: delay(index) }).collect();
        let line = Line::through(&pairs).expect("there are enough");
        assert!((line.median_slope_us_per_s - 26.0).abs() < 1e-6);
    }

    #[test]
    fn the_window_is_half_of_the_usual_distance() {
        assert!((usual_window_ns(&toggles(&[10, 500, 500, 500, 500, 500])) - 500.0).abs() < 1e-9);
        assert!(usual_window_ns(&toggles(&[10, 500])).is_infinite());
    }

    #[test]
    fn the_error_of_the_slope_is_that_of_the_textbook() {
        let delays = [1.0, 3.0, 2.0, 5.0];
        let pairs: Vec<Pair> =
            (0_u32..).zip(delays).map(|(x, y)| Pair { time_ns: f64::from(x) * 1e9, delay_ns: y * 1e3 }).collect();
        let line = Line::through(&pairs).expect("there are four");
        // By hand: the slope is 5.5 / 5, the squares around the line are 2.7.
        assert!((line.slope_us_per_s - 1.1).abs() < 1e-9 && (line.offset_us - 1.1).abs() < 1e-9);
        assert!((line.residual_us - 1.35_f64.sqrt()).abs() < 1e-9);
        assert!((line.slope_error_us_per_s - (1.35_f64 / 5.0).sqrt()).abs() < 1e-9);
    }
}
