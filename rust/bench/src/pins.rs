// SPDX-License-Identifier: Apache-2.0
//! What an oscilloscope at two pins shows: how far apart the clocks are that toggle them (thesis, figure 6.3).

use std::io::BufRead;

use lf_linux::devices::recording::{Recording, Signal};

use crate::Result;

/// The moments in ns at which the first pin of each participant changes, in a recording as `lfz` writes it: a VCD file
/// with one scope for each.
///
/// # Errors
/// When it cannot be read, or does not have pins of two participants.
pub fn read_pins(from: impl BufRead) -> Result<[(String, Vec<i64>); 2]> {
    let recording = Recording::read("", from)?;
    let mut pins = recording.pins.into_iter().map(|(name, changes)| {
        let levels = changes.into_iter().filter(|(_, signal)| matches!(signal, Signal::Level(_)));
        // What a pin is at first is no edge.
        (name, levels.skip(1).map(|(at, _)| at.as_nanos()).collect())
    });
    match (pins.next(), pins.next()) {
        (Some(one), Some(other)) => Ok([one, other]),
        _ => Err("the recording has fewer than two pins; record a program that toggles one in each federate".into()),
    }
}

/// How far the edges of one pin come after those of another one that should come at the same time: when, in seconds
/// after the first one, and by how much, in µs. An edge without one of the other pin within `reach_ns` is left out.
#[expect(clippy::cast_precision_loss, reason = "recordings are far shorter than 2^53 ns")]
pub fn offsets(one: &[i64], other: &[i64], reach_ns: i64) -> Vec<[f64; 2]> {
    let Some(first) = one.first() else { return Vec::new() };
    let nearest = |edge: &i64| {
        let place = other.partition_point(|candidate| candidate < edge);
        let around = &other[place.saturating_sub(1)..(place + 1).min(other.len())];
        let nearest = around.iter().min_by_key(|candidate| (**candidate - edge).abs())?;
        let offset = nearest - edge;
        (offset.abs() <= reach_ns).then(|| [(edge - first) as f64 / 1e9, offset as f64 / 1e3])
    };
    one.iter().filter_map(nearest).collect()
}

/// The line through points with the least squares, as its value at 0 and its slope; none for fewer than two values of
/// x.
#[expect(clippy::cast_precision_loss, reason = "there are few points")]
pub fn trend(points: &[[f64; 2]]) -> Option<(f64, f64)> {
    let count = points.len() as f64;
    let mean = |of: fn(&[f64; 2]) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|point| point[0]), mean(|point| point[1]));
    let spread: f64 = points.iter().map(|point| (point[0] - x).powi(2)).sum();
    let slope = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum::<f64>() / spread;
    slope.is_finite().then_some((y - slope * x, slope))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drifting_clock_is_a_line() {
        let one: Vec<i64> = (0..60).map(|second| 1_000_000_000 * second).collect();
        // 26 µs/s, from 100 µs on; one edge is missing.
        let mut other: Vec<i64> = one.iter().map(|at| at + 100_000 + at / 1_000_000 * 26).collect();
        other.remove(7);
        let points = offsets(&one, &other, 250_000_000);
        assert_eq!(points.len(), 59);
        let (begin, slope) = trend(&points).expect("there are points");
        assert!((begin - 100.0).abs() < 1e-6 && (slope - 26.0).abs() < 1e-6, "{begin} {slope}");
        assert_eq!(trend(&points[..1]), None);
        assert_eq!(offsets(&[], &other, 1), Vec::<[f64; 2]>::new());
    }

    #[test]
    fn edges_are_read_from_a_recording() {
        let text = "$timescale 1 ns $end\n$scope module a $end\n$var wire 1 ! led0 $end\n$upscope $end\n\
                    $scope module b $end\n$var wire 1 \" led0 $end\n$upscope $end\n$enddefinitions $end\n\
                    #0\n0!\n0\"\n#20\n1\"\n#30\n1!\n#70\n0!\n";
        let [(_, one), (_, other)] = read_pins(text.as_bytes()).expect("it is sound");
        assert_eq!((one, other), (vec![30, 70], vec![20]));
        let error = read_pins("$enddefinitions $end\n".as_bytes()).expect_err("there is no pin");
        assert!(error.to_string().contains("fewer than two pins"), "{error}");
    }
}
