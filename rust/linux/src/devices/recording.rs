// SPDX-License-Identifier: Apache-2.0
//! What pins did, as VCD: the format of logic analysers, which `PulseView` and `GTKWave` read.

use std::collections::BTreeMap;
use std::io::{self, Write};

use lf_model::time::Interval;
use vcd::{IdCode, TimescaleUnit, Value, Writer};

/// The changes of a pin, in order.
pub(crate) type Changes = Vec<(Interval, bool)>;

/// Writes the changes of all pins of a federate; times are since the start, and those before it are the start's.
///
/// # Errors
/// When the file cannot be written.
pub(crate) fn write(to: impl Write, federate: &str, pins: &BTreeMap<&'static str, Changes>) -> io::Result<()> {
    let mut vcd = Writer::new(to);
    vcd.timescale(1, TimescaleUnit::NS)?;
    vcd.add_module(federate)?;
    let names: Vec<(IdCode, &Changes)> = pins
        .iter()
        .map(|(name, changes)| Ok((vcd.add_wire(1, &reference(name))?, changes)))
        .collect::<io::Result<_>>()?;
    vcd.upscope()?;
    vcd.enddefinitions()?;
    let at_start = |changes: &Changes| changes.iter().take_while(|(time, _)| *time <= Interval::ZERO).last().copied();
    vcd.timestamp(0)?;
    for &(id, changes) in &names {
        vcd.change_scalar(id, at_start(changes).map_or(Value::V0, |(_, active)| value(active)))?;
    }
    let later = names.iter().flat_map(|&(id, changes)| changes.iter().map(move |&(time, active)| (time, id, active)));
    let mut later: Vec<_> = later.filter(|(time, ..)| *time > Interval::ZERO).collect();
    later.sort_by_key(|(time, ..)| *time);
    let mut now = Interval::ZERO;
    for (time, id, active) in later {
        if time != now {
            now = time;
            vcd.timestamp(u64::try_from(time.as_nanos()).unwrap_or(0))?;
        }
        vcd.change_scalar(id, value(active))?;
    }
    vcd.flush()
}

/// The name of a pin, where brackets would be those of a bus.
fn reference(name: &str) -> String {
    name.replace([' ', ']'], "").replace(['.', '['], "_")
}

fn value(active: bool) -> Value {
    if active { Value::V1 } else { Value::V0 }
}
