// SPDX-License-Identifier: Apache-2.0
//! `lfz run --vcd`: what the pins of all federates did, in one file.
//!
//! Each federate writes a file of its own, whose times are since the start of the federation by the federation's clock
//! (see `lf_linux`). So the files agree on time, as the channels of one oscilloscope do.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use lf_compiler::plan::{Federate, Plan};
use vcd::{Command, IdCode, Parser, ScopeItem, TimescaleUnit, Value, Writer};

use crate::failure::Failure;

/// The file into which a federate writes what its pins do.
pub(crate) fn file(folder: &Path, federate: &Federate) -> PathBuf {
    folder.join(format!("{}.vcd", federate.name))
}

/// Takes away what an earlier run has left.
pub(crate) fn clear(plan: &Plan, folder: &Path) {
    for federate in &plan.federates {
        // What cannot be removed cannot be written either, and that is told.
        let _ = std::fs::remove_file(file(folder, federate));
    }
}

/// Makes one file of those that the federates have written; says how many pins there are. A federate that was ended
/// before it could write has none.
///
/// # Errors
/// When one is not understood, or the result cannot be written.
pub(crate) fn merge(plan: &Plan, folder: &Path, to: &Path) -> Result<usize, Failure> {
    let mut parts = Vec::new();
    for federate in &plan.federates {
        let path = file(folder, federate);
        match File::open(&path).and_then(|part| Part::read(&federate.name, BufReader::new(part))) {
            Ok(part) => parts.push(part),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(Failure::message(format!("cannot use {}: {error}", path.display()))),
        }
    }
    File::create(to)
        .and_then(|file| write(&parts, BufWriter::new(file)))
        .map_err(|error| Failure::message(format!("cannot write {}: {error}", to.display())))
}

/// What the pins of a federate did.
struct Part {
    federate: String,
    pins: Vec<(IdCode, String)>,
    /// Nanoseconds, which pin, what it was then.
    changes: Vec<(u64, IdCode, Value)>,
}

impl Part {
    fn read(federate: &str, from: impl Read) -> io::Result<Self> {
        let mut parser = Parser::new(BufReader::new(from));
        let header = parser.parse_header()?;
        let mut part = Self { federate: federate.to_owned(), pins: Vec::new(), changes: Vec::new() };
        for scope in header.items {
            let ScopeItem::Scope(scope) = scope else { continue };
            for item in scope.items {
                if let ScopeItem::Var(pin) = item {
                    part.pins.push((pin.code, pin.reference));
                }
            }
        }
        let mut now = 0;
        for command in parser {
            match command? {
                Command::Timestamp(time) => now = time,
                Command::ChangeScalar(pin, value) => part.changes.push((now, pin, value)),
                _ => {}
            }
        }
        Ok(part)
    }
}

fn write(parts: &[Part], to: impl Write) -> io::Result<usize> {
    let mut vcd = Writer::new(to);
    vcd.timescale(1, TimescaleUnit::NS)?;
    let (mut pins, mut changes) = (0, Vec::new());
    for Part { federate, pins: own, changes: what } in parts {
        vcd.add_module(federate)?;
        for (before, name) in own {
            let now = vcd.add_wire(1, name)?;
            pins += 1;
            let of_pin = what.iter().filter(|(_, pin, _)| pin == before);
            changes.extend(of_pin.map(|&(time, _, value)| (time, now, value)));
        }
        vcd.upscope()?;
    }
    vcd.enddefinitions()?;
    changes.sort_by_key(|(time, ..)| *time);
    let mut last = None;
    for (time, pin, value) in changes {
        if last != Some(time) {
            last = Some(time);
            vcd.timestamp(time)?;
        }
        vcd.change_scalar(pin, value)?;
    }
    vcd.flush()?;
    Ok(pins)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pins_of_all_federates_are_on_one_axis() {
        let part = |federate: &str, pin: &str, at: u64| {
            let text = format!(
                "$timescale 1 ns $end\n$scope module {federate} $end\n$var wire 1 ! {pin} $end\n$upscope $end\n\
                 $enddefinitions $end\n#0\n0!\n#{at}\n1!\n"
            );
            Part::read(federate, text.as_bytes()).expect("it is sound")
        };
        let mut merged = Vec::new();
        let pins = write(&[part("a", "led0", 30), part("b", "led0", 20)], &mut merged).expect("memory takes it");
        let text = String::from_utf8(merged).expect("it is text");
        assert_eq!(pins, 2);
        assert_eq!(
            text,
            "$timescale 1 ns $end\n$scope module a $end\n$var wire 1 ! led0 $end\n$upscope $end\n\
             $scope module b $end\n$var wire 1 \" led0 $end\n$upscope $end\n$enddefinitions $end\n\
             #0\n0!\n0\"\n#20\n1\"\n#30\n1!\n"
        );
        assert!(Part::read("a", "$scope".as_bytes()).is_err());
    }
}
