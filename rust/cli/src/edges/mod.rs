// SPDX-License-Identifier: Apache-2.0
//! `lfz scope`: compares the edges of pins in recordings, as an oscilloscope does.

mod analysis;
mod file;
mod plot;
mod report;
mod table;

use std::process::ExitCode;

use serde::Serialize;

use crate::args::{EdgeKind, ScopeArgs};
use crate::failure::Failure;
use crate::terminal;
use analysis::{Histogram, Line, Pair, Statistics};
use file::Signal;
use report::{Comparison, Listing, Report};

/// Compares signals with a reference, or lists them.
pub(crate) fn execute(arguments: &ScopeArgs) -> Result<ExitCode, Failure> {
    let mut signals = file::read(&arguments.files)?;
    for signal in &mut signals {
        signal.edges.retain(|edge| match arguments.edges {
            EdgeKind::Both => true,
            EdgeKind::Rising => edge.is_rising,
            EdgeKind::Falling => !edge.is_rising,
        });
    }
    let Some(name) = &arguments.reference else {
        return if arguments.json { print_json(&Listing::of(&signals)) } else { print(table::signals(&signals)) };
    };
    let reference = find(&signals, name)?;
    let compared = match arguments.compare.as_slice() {
        [] => signals.iter().filter(|signal| signal.name != *name).collect(),
        names => names.iter().map(|name| find(&signals, name)).collect::<Result<Vec<_>, _>>()?,
    };
    let window_ns = match arguments.window {
        Some(window) => window.as_secs_f64() * 1e9,
        None => analysis::usual_window_ns(&reference.edges),
    };
    let report = Report {
        reference: name.clone(),
        edges: reference.edges.len(),
        window_us: window_ns / 1e3,
        compared: compared.iter().map(|signal| compare(reference, signal, window_ns, arguments.bins)).collect(),
    };
    if let Some(file) = &arguments.svg {
        let shown: Vec<&Signal> = std::iter::once(reference).chain(compared).collect();
        plot::write(file, &report, &shown)
            .map_err(|error| Failure::message(format!("cannot draw {}: {error}", file.display())))?;
    }
    if arguments.json { print_json(&report) } else { print(table::report(&report)) }
}

fn print(text: String) -> Result<ExitCode, Failure> {
    terminal::print(text)?;
    Ok(ExitCode::SUCCESS)
}

fn print_json(value: &impl Serialize) -> Result<ExitCode, Failure> {
    print(serde_json::to_string_pretty(value).map_err(|error| Failure::message(error.to_string()))?)
}

fn find<'s>(signals: &'s [Signal], name: &str) -> Result<&'s Signal, Failure> {
    signals.iter().find(|signal| signal.name == name).ok_or_else(|| {
        let names: Vec<&str> = signals.iter().map(|signal| signal.name.as_str()).collect();
        Failure::message(format!("there is no signal {name}; there are {}", names.join(", ")))
    })
}

fn compare(reference: &Signal, signal: &Signal, window_ns: f64, bins: usize) -> Comparison {
    let pairs = analysis::pair(&reference.edges, &signal.edges, window_ns);
    let drift = Line::through(&pairs.matched);
    let shown = |pair: &Pair| drift.as_ref().map_or(pair.delay_ns / 1e3, |line| line.distance_us(pair));
    let distances: Vec<f64> = pairs.matched.iter().map(shown).collect();
    Comparison {
        signal: signal.name.clone(),
        edges: signal.edges.len(),
        missing: pairs.missing,
        extra: pairs.extra,
        delay: Statistics::of(&pairs.matched),
        histogram: Histogram::of(&distances, bins),
        drift,
        pairs: pairs.matched,
    }
}

#[cfg(test)]
mod tests {
    use super::analysis::Edge;
    use super::*;

    /// Returns the pins of two boards, of which one gains 26 µs in a second, has a jitter of 1 µs and misses an edge.
    fn boards() -> [Signal; 2] {
        let edge = |index: u32| Edge { time_ns: f64::from(index) * 5e8, is_rising: index % 2 == 1 };
        let late = |index: u32| {
            let at = edge(index);
            let shake = if index.is_multiple_of(3) { 1e3 } else { 0.0 };
            Edge { time_ns: at.time_ns + 100e3 + at.time_ns * 26e-6 + shake, ..at }
        };
        let a = Signal { name: "a.led0".to_owned(), edges: (1..=120).map(edge).collect() };
        let b = Signal { name: "b.led0".to_owned(), edges: (1..=120).filter(|index| *index != 7).map(late).collect() };
        [a, b]
    }

    fn report() -> Report {
        let [a, b] = boards();
        let compared = vec![compare(&a, &b, 1e7, 8)];
        Report { reference: a.name, edges: a.edges.len(), window_us: 1e4, compared }
    }

    #[test]
    fn delays_and_drift_are_told() {
        insta::assert_snapshot!(table::report(&report()));
    }

    /// Other programs read this output: additions do no harm, but renamed keys do.
    #[test]
    fn programs_are_told_signals_and_comparisons() {
        let [mut a, mut b] = boards();
        let listing = serde_json::to_string_pretty(&Listing::of(&[a, b])).expect("it has no maps");
        [a, b] = boards();
        a.edges.truncate(4);
        b.edges.truncate(4);
        let compared = vec![compare(&a, &b, 1e7, 2)];
        let report = Report { reference: a.name, edges: a.edges.len(), window_us: 1e4, compared };
        let report = serde_json::to_string_pretty(&report).expect("it has no maps");
        insta::assert_snapshot!(format!("{listing}\n\n{report}"));
    }

    #[test]
    fn the_picture_has_delays_distances_and_waves() {
        let folder = tempfile::tempdir().expect("there is room");
        let file = folder.path().join("edges.svg");
        let [a, b] = boards();
        plot::write(&file, &report(), &[&a, &b]).expect("it can be drawn");
        let svg = std::fs::read_to_string(&file).expect("it is there");
        for text in ["a.led0", "b.led0", "26.0 µs/s", "distance from the line", "</svg>"] {
            assert!(svg.contains(text), "{text}");
        }
    }
}
