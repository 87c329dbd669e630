// SPDX-License-Identifier: Apache-2.0
//! Recordings of pins as VCD, the format of logic analysers, which `PulseView` and `GTKWave` read.

use std::io::{self, BufRead, Write};

use lf_model::time::{Instant, Interval};
use vcd::{Command, IdCode, Parser, ScopeItem, TimescaleUnit, Value, VarType, Writer};

/// The signal of a device from a time on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Signal {
    /// The level of a pin: active or not.
    Level(bool),
    /// The duty cycle of an output, or a voltage in millivolts.
    Real(f64),
}

/// The changes of a device, in order; times are since the start, and those before it are the start's.
pub type Changes = Vec<(Interval, Signal)>;

/// The recording of the pins of a federate.
#[derive(Debug)]
pub struct Recording {
    /// The federate.
    pub federate: String,
    /// Its start, by the clock that all recordings of a run share.
    pub start: Option<Instant>,
    /// Its pins.
    pub pins: Vec<(String, Changes)>,
}

impl Recording {
    /// Reads the recording of one federate that [`write`] has written.
    ///
    /// # Errors
    /// When it cannot be read, or is not understood.
    pub fn read(federate: &str, from: impl BufRead) -> io::Result<Self> {
        let mut parser = Parser::new(from);
        let header = parser.parse_header()?;
        let start = start_of(&header.items).map(Instant::from_nanos);
        let (mut codes, mut pins) = (Vec::new(), Vec::new());
        for scope in header.items {
            let ScopeItem::Scope(scope) = scope else { continue };
            for item in scope.items {
                if let ScopeItem::Var(pin) = item {
                    codes.push(pin.code);
                    pins.push((pin.reference, Changes::new()));
                }
            }
        }
        let mut now = Interval::ZERO;
        for command in parser {
            match command? {
                Command::Timestamp(time) => now = Interval::from_nanos(i64::try_from(time).unwrap_or(i64::MAX)),
                Command::ChangeScalar(code, value) => {
                    if let Some(pin) = codes.iter().position(|pin| *pin == code) {
                        pins[pin].1.push((now, Signal::Level(value == Value::V1)));
                    }
                }
                Command::ChangeReal(code, value) => {
                    if let Some(pin) = codes.iter().position(|pin| *pin == code) {
                        pins[pin].1.push((now, Signal::Real(value)));
                    }
                }
                _ => {}
            }
        }
        Ok(Self { federate: federate.to_owned(), start, pins })
    }
}

/// Returns the start of a recording.
#[must_use]
pub fn start_of(items: &[ScopeItem]) -> Option<i64> {
    items.iter().find_map(|item| match item {
        ScopeItem::Comment(comment) => comment.trim().strip_prefix(START)?.trim().parse().ok(),
        _ => None,
    })
}

/// The beginning of a comment with the start, in nanoseconds since 1970.
const START: &str = "start ";

/// Writes the pins of these federates on one time axis, which begins with the first that has started.
///
/// # Errors
/// When it cannot be written.
pub fn write(to: impl Write, recordings: &[Recording]) -> io::Result<()> {
    let mut vcd = Writer::new(to);
    let first = recordings.iter().filter_map(|recording| recording.start).min();
    if let Some(first) = first {
        vcd.comment(&format!("{START}{}", first.as_nanos()))?;
    }
    vcd.timescale(1, TimescaleUnit::NS)?;
    let mut all: Vec<(IdCode, Changes)> = Vec::new();
    for Recording { federate, start, pins } in recordings {
        let shift = start.zip(first).map_or(Interval::ZERO, |(start, first)| start.since(first));
        // The state at the start was the state before it, too.
        let shifted = |time: Interval| match time.as_nanos() {
            ..=0 => Interval::ZERO,
            after => Interval::from_nanos(after.saturating_add(shift.as_nanos())),
        };
        vcd.add_module(federate)?;
        for (name, changes) in pins {
            let is_real = changes.first().is_some_and(|(_, signal)| matches!(signal, Signal::Real(_)));
            let (kind, bits) = if is_real { (VarType::Real, 64) } else { (VarType::Wire, 1) };
            let changes = changes.iter().map(|&(time, signal)| (shifted(time), signal)).collect();
            all.push((vcd.add_var(kind, bits, &reference(name), None)?, changes));
        }
        vcd.upscope()?;
    }
    vcd.enddefinitions()?;
    vcd.timestamp(0)?;
    for (id, changes) in &all {
        let at_start = changes.iter().take_while(|(time, _)| *time <= Interval::ZERO).last();
        let nothing = match changes.first() {
            Some((_, Signal::Real(_))) => Signal::Real(0.0),
            _ => Signal::Level(false),
        };
        change(&mut vcd, *id, at_start.map_or(nothing, |(_, signal)| *signal))?;
    }
    let later = all.iter().flat_map(|(id, changes)| changes.iter().map(move |&(time, signal)| (time, *id, signal)));
    let mut later: Vec<_> = later.filter(|(time, ..)| *time > Interval::ZERO).collect();
    later.sort_by_key(|(time, ..)| *time);
    let mut now = Interval::ZERO;
    for (time, id, signal) in later {
        if time != now {
            now = time;
            vcd.timestamp(u64::try_from(time.as_nanos()).unwrap_or(0))?;
        }
        change(&mut vcd, id, signal)?;
    }
    vcd.flush()
}

fn change<W: Write>(vcd: &mut Writer<W>, id: IdCode, signal: Signal) -> io::Result<()> {
    match signal {
        Signal::Level(active) => vcd.change_scalar(id, active),
        Signal::Real(value) => vcd.change_real(id, value),
    }
}

/// Returns the name of a pin without brackets, which would be those of a bus.
fn reference(name: &str) -> String {
    name.replace([' ', ']'], "").replace(['.', '['], "_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measurements_are_written_and_read() {
        let changes = vec![(Interval::ZERO, Signal::Real(0.25)), (Interval::from_nanos(7), Signal::Real(-1.5))];
        let recording = Recording {
            federate: "a".to_owned(),
            start: Some(Instant::from_nanos(1_700_000_000_000_000_000)),
            pins: vec![("fan".to_owned(), changes.clone())],
        };
        let mut written = Vec::new();
        write(&mut written, std::slice::from_ref(&recording)).expect("memory takes it");
        let read = Recording::read("a", written.as_slice()).expect("it is sound");
        assert_eq!(read.start, recording.start);
        assert_eq!(read.pins, [("fan".to_owned(), changes)]);
    }

    #[test]
    fn a_participant_that_starts_later_is_shown_later() {
        let part = |start, at| Recording {
            federate: "a".to_owned(),
            start: Some(Instant::from_nanos(start)),
            pins: vec![("led0".to_owned(), vec![(Interval::from_nanos(at), Signal::Level(true))])],
        };
        let mut merged = Vec::new();
        write(&mut merged, &[part(1000, 5), part(1200, 7)]).expect("memory takes it");
        let text = String::from_utf8(merged).expect("it is text");
        assert!(text.starts_with("$comment\n    start 1000\n$end\n"), "{text}");
        assert!(text.ends_with("#0\n0!\n0\"\n#5\n1!\n#207\n1\"\n"), "{text}");
    }

    #[test]
    fn the_pins_of_all_federates_are_on_one_axis() {
        let part = |federate: &str, pin: &str, at: u64| {
            let text = format!(
                "$timescale 1 ns $end\n$scope module {federate} $end\n$var wire 1 ! {pin} $end\n$upscope $end\n\
                 $enddefinitions $end\n#0\n0!\n#{at}\n1!\n"
            );
            Recording::read(federate, text.as_bytes()).expect("it is sound")
        };
        let mut merged = Vec::new();
        let parts = [part("a", "led0", 30), part("b", "led0", 20)];
        write(&mut merged, &parts).expect("memory takes it");
        let text = String::from_utf8(merged).expect("it is text");
        assert_eq!(parts.iter().map(|part| part.pins.len()).sum::<usize>(), 2);
        assert_eq!(
            text,
            "$timescale 1 ns $end\n$scope module a $end\n$var wire 1 ! led0 $end\n$upscope $end\n\
             $scope module b $end\n$var wire 1 \" led0 $end\n$upscope $end\n$enddefinitions $end\n\
             #0\n0!\n0\"\n#20\n1\"\n#30\n1!\n"
        );
        assert!(Recording::read("a", "$scope".as_bytes()).is_err());
    }
}
