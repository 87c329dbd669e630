// SPDX-License-Identifier: Apache-2.0
//! Signals in VCD files of any origin: this project, a logic analyser by `PulseView`, a simulator.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

use lf_linux::devices::recording::start_of;
use vcd::{Command, IdCode, Parser, ScopeItem, TimescaleUnit, Value};

use super::analysis::Edge;
use crate::failure::Failure;

/// A signal of one bit.
#[derive(Debug)]
pub(crate) struct Signal {
    /// The names of its scopes and its own, with dots between.
    pub(crate) name: String,
    pub(crate) edges: Vec<Edge>,
}

/// Reads the signals of files, on one axis of time. Files with a start time are aligned by that, others begin together.
pub(crate) fn read(files: &[impl AsRef<Path>]) -> Result<Vec<Signal>, Failure> {
    let mut parts = Vec::new();
    for file in files {
        let file = file.as_ref();
        let part = File::open(file).and_then(|content| signals(BufReader::new(content)));
        parts.push(part.map_err(|error| Failure::message(format!("cannot use {}: {error}", file.display())))?);
    }
    let first = parts.iter().filter_map(|(start, _)| *start).min().unwrap_or(0);
    let mut all: Vec<Signal> = Vec::new();
    for (file, (start, signals)) in files.iter().zip(parts) {
        #[expect(clippy::cast_precision_loss, reason = "recordings of one experiment begin within a hundred days")]
        let shift_ns = start.map_or(0.0, |start| (start - first) as f64);
        for mut signal in signals {
            if all.iter().any(|other| other.name == signal.name) {
                let name = &signal.name;
                let file = file.as_ref().display();
                return Err(Failure::message(format!("{file} has the signal {name}, and so has a file before it")));
            }
            signal.edges.iter_mut().for_each(|edge| edge.time_ns += shift_ns);
            all.push(signal);
        }
    }
    Ok(all)
}

/// Returns the signals of a file, and its start time if it has one.
fn signals(from: impl BufRead) -> io::Result<(Option<i64>, Vec<Signal>)> {
    let mut parser = Parser::new(from);
    let header = parser.parse_header()?;
    let unit_ns = match header.timescale {
        None => 1.0,
        Some((count, unit)) => f64::from(count) * nanoseconds(unit),
    };
    let start = start_of(&header.items);
    let mut found = Vec::new();
    collect("", header.items, &mut found);
    let mut levels: Vec<Option<bool>> = vec![None; found.len()];
    let mut time_ns = 0.0;
    for command in parser {
        match command? {
            #[expect(clippy::cast_precision_loss, reason = "numbers in use are far below 2^52")]
            Command::Timestamp(time) => time_ns = time as f64 * unit_ns,
            Command::ChangeScalar(code, value @ (Value::V0 | Value::V1)) => {
                let is_high = value == Value::V1;
                let of_code = found.iter_mut().zip(&mut levels).filter(|((of, _), _)| *of == code);
                for ((_, signal), level) in of_code {
                    // The first value of a signal is not an edge.
                    if level.replace(is_high).is_some_and(|before| before != is_high) {
                        signal.edges.push(Edge { time_ns, is_rising: is_high });
                    }
                }
            }
            _ => {}
        }
    }
    Ok((start, found.into_iter().map(|(_, signal)| signal).collect()))
}

fn collect(scope: &str, items: Vec<ScopeItem>, found: &mut Vec<(IdCode, Signal)>) {
    let inside = |name: &str| if scope.is_empty() { name.to_owned() } else { format!("{scope}.{name}") };
    for item in items {
        match item {
            ScopeItem::Scope(inner) => collect(&inside(&inner.identifier), inner.items, found),
            ScopeItem::Var(var) if var.size == 1 => {
                found.push((var.code, Signal { name: inside(&var.reference), edges: Vec::new() }));
            }
            _ => {}
        }
    }
}

fn nanoseconds(unit: TimescaleUnit) -> f64 {
    match unit {
        TimescaleUnit::S => 1e9,
        TimescaleUnit::MS => 1e6,
        TimescaleUnit::US => 1e3,
        TimescaleUnit::NS => 1.0,
        TimescaleUnit::PS => 1e-3,
        TimescaleUnit::FS => 1e-6,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// libsigrok writes several samples a line, microseconds, and a scope of its own.
    #[test]
    fn files_of_logic_analysers_are_read() {
        let text = "$date today $end $version libsigrok $end\n$comment 2 channels at 1 MHz $end\n$timescale 1 us $end\n\
                    $scope module libsigrok $end\n$var wire 1 ! D0 $end\n$var wire 1 \" D1 $end\n$upscope $end\n\
                    $enddefinitions $end\n#0 0! x\"\n#5 1! 0\"\n#7 1!\n#9 0! 1\"\n#10\n";
        let (start, signals) = signals(text.as_bytes()).expect("it is sound");
        assert_eq!(start, None);
        let edge = |time_ns, is_rising| Edge { time_ns, is_rising };
        assert_eq!(signals[0].name, "libsigrok.D0");
        assert_eq!(signals[0].edges, [edge(5000.0, true), edge(9000.0, false)]);
        assert_eq!(signals[1].edges, [edge(9000.0, true)]);
    }

    #[test]
    fn files_that_say_when_they_begin_are_aligned() {
        let folder = tempfile::tempdir().expect("there is room");
        let files = ["a", "b"].map(|name| folder.path().join(name));
        for (file, start) in files.iter().zip([1_700_000_000_000_000_500_i64, 1_700_000_000_000_000_000]) {
            let name = file.file_name().expect("it has one").display();
            let text = format!(
                "$comment start {start} $end\n$timescale 1 ns $end\n$scope module {name} $end\n\
                 $var wire 1 ! led0 $end\n$upscope $end\n$enddefinitions $end\n#0\n0!\n#100\n1!\n"
            );
            std::fs::write(file, text).expect("there is room");
        }
        let signals = read(&files).expect("they are sound");
        let edges: Vec<f64> = signals.iter().flat_map(|signal| &signal.edges).map(|edge| edge.time_ns).collect();
        assert_eq!(edges, [600.0, 100.0]);
        assert!(read(&[&files[0], &files[0]]).is_err());
    }
}
