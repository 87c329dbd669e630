// SPDX-License-Identifier: Apache-2.0
//! What an oscilloscope at two pins shows, as `lfz scope` tells it: how far apart the clocks are that toggle them
//! (thesis, figure 6.3).

use std::path::Path;
use std::process::Command;

use serde::Deserialize;

use crate::Result;

/// The edges of a pin beside those of another one.
#[derive(Debug, PartialEq)]
pub struct Pins {
    /// The pin that the other one is compared with.
    pub reference: String,
    /// The other one.
    pub compared: String,
    /// For each edge that both have: seconds after the first one, and how much later the other pin's is, in µs.
    pub points: Vec<[f64; 2]>,
    /// The line through them: its value in µs at the first edge, and its slope in µs/s.
    pub line: (f64, f64),
    /// The most that an edge is early or late, in µs.
    pub worst_us: f64,
}

#[derive(Deserialize)]
struct Recording {
    signals: Vec<Signal>,
}

#[derive(Deserialize)]
struct Signal {
    signal: String,
}

#[derive(Deserialize)]
struct Report {
    reference: String,
    compared: Vec<ComparedPin>,
}

#[derive(Deserialize)]
struct ComparedPin {
    signal: String,
    delay: Option<PinDelay>,
    drift: Option<Drift>,
    pairs: Vec<Pair>,
}

#[derive(Deserialize)]
struct PinDelay {
    min_us: f64,
    max_us: f64,
}

#[derive(Deserialize)]
struct Drift {
    slope_us_per_s: f64,
    offset_us: f64,
}

#[derive(Deserialize)]
struct Pair {
    time_ns: f64,
    delay_ns: f64,
}

/// Compares the first pin of a recording with the first one of another participant, or with the next one.
///
/// # Errors
/// When `lfz` cannot read it, or it does not have two pins with edges in common.
pub fn read_pins(lfz: &Path, recording: &Path) -> Result<Pins> {
    let Recording { signals } = serde_json::from_str(&scope(lfz, recording, &[])?)?;
    let (one, other) = two_of(&signals)
        .ok_or("the recording has fewer than two pins; record a program that toggles one in each federate")?;
    pins_in(&scope(lfz, recording, &["--reference", one, "--compare", other])?)
}

/// What `lfz scope` says of a recording.
fn scope(lfz: &Path, recording: &Path, words: &[&str]) -> Result<String> {
    let output = Command::new(lfz).arg("scope").arg(recording).args(words).arg("--json").output()?;
    if output.status.success() {
        Ok(String::from_utf8(output.stdout)?)
    } else {
        Err(String::from_utf8_lossy(&output.stderr).trim().trim_start_matches("error: ").into())
    }
}

fn two_of(signals: &[Signal]) -> Option<(&str, &str)> {
    let (one, others) = signals.split_first()?;
    let participant = |signal: &Signal| signal.signal.split('.').next().map(str::to_owned);
    let other = others.iter().find(|other| participant(other) != participant(one)).or(others.first())?;
    Some((&one.signal, &other.signal))
}

fn pins_in(report: &str) -> Result<Pins> {
    let Report { reference, mut compared } = serde_json::from_str(report)?;
    let ComparedPin { signal, delay, drift, pairs } = compared.pop().ok_or("lfz scope has compared nothing")?;
    let (Some(delay), Some(drift), Some(first)) = (delay, drift, pairs.first()) else {
        return Err("the pins have too few edges in common; record the program for longer".into());
    };
    let first_ns = first.time_ns;
    let begin_us = drift.offset_us + drift.slope_us_per_s * first_ns / 1e9;
    Ok(Pins {
        reference,
        compared: signal,
        points: pairs.iter().map(|pair| [(pair.time_ns - first_ns) / 1e9, pair.delay_ns / 1e3]).collect(),
        line: (begin_us, drift.slope_us_per_s),
        worst_us: delay.min_us.abs().max(delay.max_us.abs()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pins_of_two_participants_are_compared() {
        let two = |names: &[&str]| {
            let signals: Vec<_> = names.iter().map(|name| Signal { signal: (*name).to_owned() }).collect();
            two_of(&signals).map(|(one, other)| format!("{one} {other}"))
        };
        assert_eq!(two(&["a.led0", "a.led1", "b.led0"]).as_deref(), Some("a.led0 b.led0"));
        assert_eq!(two(&["logic.D0", "logic.D1"]).as_deref(), Some("logic.D0 logic.D1"));
        assert_eq!(two(&["a.led0"]), None);
    }

    #[test]
    fn times_count_from_the_first_edge() {
        let report = r#"{
            "reference": "a.led0", "edges": 3, "window_us": 500.0,
            "compared": [{
                "signal": "b.led0", "edges": 3, "missing": 0, "extra": 0, "histogram": null,
                "delay": { "count": 3, "min_us": -30.0, "max_us": 22.0 },
                "drift": { "slope_us_per_s": 26.0, "offset_us": -56.0, "residual_us": 0.0 },
                "pairs": [{ "time_ns": 1e9, "delay_ns": -3e4 }, { "time_ns": 2e9, "delay_ns": -4e3 },
                          { "time_ns": 3e9, "delay_ns": 2.2e4 }]
            }]
        }"#;
        let pins = pins_in(report).expect("it has all");
        let points = vec![[0.0, -30.0], [1.0, -4.0], [2.0, 22.0]];
        let (reference, compared) = ("a.led0".to_owned(), "b.led0".to_owned());
        assert_eq!(pins, Pins { reference, compared, points, line: (-30.0, 26.0), worst_us: 30.0 });
        let error = pins_in(r#"{ "reference": "a", "compared": [{ "signal": "b", "pairs": [] }] }"#);
        assert!(error.is_err_and(|error| error.to_string().contains("too few edges in common")));
    }
}
