// SPDX-License-Identifier: Apache-2.0
//! The devices of this process.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use lf_devices::{Channel, Problem, SensorValue};
use lf_model::time::{Instant, Interval};

use super::binding::Bound;
use super::line::Value;
use super::recording::{self, Recording, Signal};
use super::registers::Registers;
use super::script::{Change, Script};
use crate::outside::HostOutside;

static PROGRAM: OnceLock<Simulation> = OnceLock::new();

/// The inputs and the recorded outputs of a program's devices.
#[derive(Debug, Default)]
pub(crate) struct Simulation {
    federate: String,
    is_alone: bool,
    script: Script,
    recording: Option<PathBuf>,
    devices: Mutex<Devices>,
}

#[derive(Debug, Default)]
struct Devices {
    /// All devices that the program has opened.
    used: BTreeSet<&'static str>,
    /// The script's values of input pins and of voltages.
    inputs: BTreeMap<&'static str, Vec<(Interval, Signal)>>,
    /// The changes of outputs and real inputs; without a recording only the last one.
    outputs: BTreeMap<&'static str, Vec<(Instant, Signal)>>,
    /// The registers that programs have written, per device and address.
    registers: BTreeMap<(&'static str, u8), Registers>,
    /// The number of received bytes of each line.
    received: BTreeMap<&'static str, usize>,
    /// The times of the last measurements of sensors.
    fetched: BTreeMap<&'static str, Interval>,
}

/// Ends the simulation when it is dropped: writes the recording.
#[derive(Debug)]
pub(crate) struct Running;

impl Simulation {
    /// Begins the simulation for the program that begins now, alone or as a federate. Its recording goes to a file.
    pub(crate) fn begin(federate: &str, is_alone: bool, script: Script, recording: Option<PathBuf>) -> Running {
        let simulation = Self { federate: federate.to_owned(), is_alone, script, recording, ..Self::default() };
        // One process runs one program; tests that run several have no devices.
        let _ = PROGRAM.set(simulation);
        Running
    }

    pub(super) fn of_program() -> &'static Self {
        PROGRAM.get_or_init(Self::default)
    }

    /// Opens a pin as an input.
    pub(super) fn reads(&self, name: &'static str) -> Result<(), Problem> {
        let mut active = false;
        let mut levels = Vec::new();
        for Change { at, value, line } in self.changes(name) {
            let level = match value {
                Value::Number(0.0) => false,
                Value::Number(1.0) => true,
                _ => return Err(Problem::Script { line: *line, expected: "a pin is 0 or 1" }),
            };
            if std::mem::replace(&mut active, level) != level {
                levels.push((*at, Signal::Level(level)));
            }
        }
        self.takes_input(name, levels);
        Ok(())
    }

    /// Opens a voltage input.
    pub(super) fn measures(&self, name: &'static str) -> Result<(), Problem> {
        let voltage = |change: &Change| match change.value {
            Value::Number(millivolts) => Ok((change.at, Signal::Real(millivolts))),
            _ => Err(Problem::Script { line: change.line, expected: "a voltage is a number of millivolts" }),
        };
        let voltages = self.changes(name).iter().map(voltage).collect::<Result<_, _>>()?;
        self.takes_input(name, voltages);
        Ok(())
    }

    fn takes_input(&self, name: &'static str, changes: Vec<(Interval, Signal)>) {
        let mut devices = self.lock();
        devices.used.insert(name);
        devices.inputs.insert(name, changes);
    }

    /// Returns the binding of a device, if it is not simulated.
    pub(super) fn bound(&self, name: &'static str) -> Option<&Bound> {
        self.lock().used.insert(name);
        self.script.bound(&self.federate, name)
    }

    /// Sets an output from now on.
    pub(super) fn drives(&self, name: &'static str, signal: Signal) {
        // The time is read under the lock, so that changes are in its order.
        let devices = self.lock();
        self.notes(devices, name, HostOutside::of_program().clock().now(), signal);
    }

    /// Records a change of a real device at this time of the computer's clock.
    #[cfg(feature = "devices")]
    pub(super) fn sees(&self, name: &'static str, time: Instant, signal: Signal) {
        self.notes(self.lock(), name, time, signal);
    }

    fn notes(&self, mut devices: MutexGuard<'_, Devices>, name: &'static str, now: Instant, signal: Signal) {
        let changes = devices.outputs.entry(name).or_default();
        if changes.last().is_some_and(|(_, before)| *before == signal) {
            return;
        }
        if self.recording.is_none() {
            changes.clear();
        }
        changes.push((now, signal));
        drop(devices);
        match signal {
            Signal::Level(active) => log::debug!("{name} is {}", u8::from(active)),
            Signal::Real(value) => log::debug!("{name} is {value}"),
        }
    }

    /// Returns the signal of a device now: the last value of an output, or the script's value of an input.
    pub(super) fn signal(&self, name: &'static str) -> Option<Signal> {
        let elapsed = Self::elapsed();
        let devices = self.lock();
        if let Some((_, signal)) = devices.outputs.get(name).and_then(|changes| changes.last()) {
            return Some(*signal);
        }
        let changes = devices.inputs.get(name)?;
        changes.iter().take_while(|(time, _)| *time <= elapsed).last().map(|(_, signal)| *signal)
    }

    /// Returns when the levels of an input change, and to which.
    pub(super) fn edges(&self, name: &'static str) -> Vec<(Interval, u8)> {
        let devices = self.lock();
        let changes = devices.inputs.get(name).into_iter().flatten();
        changes.map(|(time, signal)| (*time, u8::from(*signal == Signal::Level(true)))).collect()
    }

    /// Opens a device with registers. Devices on a bus that the program names are in the script by its name.
    pub(super) fn has_registers(&self, name: &'static str) -> Result<(), Problem> {
        self.lock().used.insert(name);
        if self.script.parts(&self.federate, name).any(|(part, _)| part.register().is_some()) {
            return Ok(());
        }
        Err(Problem::NotSimulated { example: "a register and its bytes, such as [0x00] 0x1980" })
    }

    /// Returns the address of a device that the script has with one.
    pub(super) fn address(&self, name: &str) -> Option<u8> {
        self.script.parts(&self.federate, name).find_map(|(part, _)| part.address)
    }

    /// Calls a function with the registers of the device of this name and address, as they are now. A device that the
    /// script has without an address answers at all of them.
    pub(super) fn with_registers<R>(
        &self,
        name: &'static str,
        address: Option<u8>,
        act: impl FnOnce(&mut Registers) -> R,
    ) -> Result<R, Problem> {
        let is_here = |of_part: Option<u8>| of_part.is_none() || of_part == address;
        let mut found = false;
        let mut devices = self.lock();
        let elapsed = Self::elapsed();
        let registers = devices.registers.entry((name, address.unwrap_or_default())).or_default();
        for (part, changes) in self.script.parts(&self.federate, name) {
            let Some(register) = part.register().filter(|_| is_here(part.address)) else { continue };
            found = true;
            let Some(change) = changes.iter().take_while(|change| change.at <= elapsed).last() else { continue };
            let expected = "a register is its bytes, such as 0x1980, or a number up to 255";
            let values = bytes(&change.value).ok_or(Problem::Script { line: change.line, expected })?;
            for (register, bytes) in (register..=u8::MAX).zip(values) {
                registers.becomes(register, change.at, &bytes);
            }
        }
        if !found {
            // The bus driver's error without an answer.
            return Err(Problem::Failed(rustix::io::Errno::IO.raw_os_error()));
        }
        registers.now = elapsed;
        Ok(act(registers))
    }

    /// Returns the bytes that come on a serial line, and when.
    pub(super) fn arrivals(&self, name: &'static str) -> Result<Vec<(Interval, u8)>, Problem> {
        let mut arrivals = Vec::new();
        self.lock().used.insert(name);
        for change in self.changes(name) {
            let Value::Text(text) = &change.value else {
                let expected = "a serial line receives a text, such as \"on\\n\"";
                return Err(Problem::Script { line: change.line, expected });
            };
            arrivals.extend(text.iter().map(|byte| (change.at, *byte)));
        }
        Ok(arrivals)
    }

    /// Returns the next unread byte of a line.
    pub(super) fn receives(&self, name: &'static str) -> Result<Option<u8>, Problem> {
        let arrivals = self.arrivals(name)?;
        let elapsed = Self::elapsed();
        let mut devices = self.lock();
        let read = devices.received.entry(name).or_default();
        let next = arrivals.get(*read).filter(|(time, _)| *time <= elapsed).map(|(_, byte)| *byte);
        *read += usize::from(next.is_some());
        Ok(next)
    }

    /// Makes a sensor measure; it has to be in the script.
    pub(super) fn fetches(&self, name: &'static str) -> Result<(), Problem> {
        let is_channel = |name: &str| Channel::ALL.iter().any(|channel| channel.name() == name);
        if !self.script.parts(&self.federate, name).any(|(part, _)| is_channel(part.name)) {
            return Err(Problem::NotSimulated { example: "a channel and its value, such as [ambient_temp] 21.5" });
        }
        let elapsed = Self::elapsed();
        let mut devices = self.lock();
        devices.used.insert(name);
        devices.fetched.insert(name, elapsed);
        Ok(())
    }

    /// Returns the last measurement of a sensor.
    pub(super) fn measured(&self, name: &'static str, channel: Channel) -> Result<SensorValue, Problem> {
        let fetched = self.lock().fetched.get(name).copied().unwrap_or(Interval::ZERO);
        let of_channel = self.script.parts(&self.federate, name).filter(|(part, _)| part.name == channel.name());
        let changes = of_channel.last().ok_or(Problem::NotSupported)?.1;
        match changes.iter().take_while(|change| change.at <= fetched).last() {
            None => Ok(SensorValue::default()),
            Some(Change { value: Value::Number(number), .. }) => {
                #[expect(clippy::cast_possible_truncation, reason = "what a sensor measures is much smaller")]
                let micro = (number * 1e6).round() as i64;
                Ok(SensorValue::from_micro(micro))
            }
            Some(change) => Err(Problem::Script { line: change.line, expected: "a sensor measures a number" }),
        }
    }

    /// Returns when any channel of a sensor changes.
    pub(super) fn samples(&self, name: &str) -> Vec<(Interval, u8)> {
        let changes = self.script.parts(&self.federate, name).flat_map(|(_, changes)| changes);
        let times: BTreeSet<Interval> = changes.map(|change| change.at).collect();
        times.into_iter().map(|time| (time, 0)).collect()
    }

    fn changes(&self, name: &str) -> &[Change] {
        self.script.changes(&self.federate, name)
    }

    /// Returns the time since the start.
    fn elapsed() -> Interval {
        let outside = HostOutside::of_program();
        outside.start().map_or(Interval::ZERO, |start| outside.clock().now().since(start))
    }

    fn lock(&self) -> MutexGuard<'_, Devices> {
        self.devices.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the recording of all pins and voltages until now, since the start.
    fn recorded(&self) -> Recording {
        let start = HostOutside::of_program().start();
        let end = Self::elapsed();
        let devices = self.lock();
        let since = |time: Instant| start.map_or(Interval::ZERO, |start| time.since(start));
        let driven = |(&name, changes): (&&'static str, &Vec<(Instant, Signal)>)| {
            (name.to_owned(), changes.iter().map(|&(time, signal)| (since(time), signal)).collect())
        };
        let read = |(&name, changes): (&&'static str, &Vec<(Interval, Signal)>)| {
            (name.to_owned(), changes.iter().copied().take_while(|(time, _)| *time <= end).collect())
        };
        let recorded: BTreeMap<_, _> =
            devices.inputs.iter().map(read).chain(devices.outputs.iter().map(driven)).collect();
        Recording { federate: self.federate.clone(), start, pins: recorded.into_iter().collect() }
    }
}

/// Returns the registers of a line of the script.
fn bytes(value: &Value) -> Option<Vec<Vec<u8>>> {
    match value {
        Value::Bytes(bytes) => Some(bytes.clone()),
        Value::Number(number) => {
            (0..=u8::MAX).find(|byte| f64::from(*byte).total_cmp(number).is_eq()).map(|byte| vec![vec![byte]])
        }
        Value::Text(_) => None,
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let simulation = Simulation::of_program();
        let used = simulation.lock().used.clone();
        let has_used = |name: &str| used.contains(name);
        for (line, name) in simulation.script.unknown(&simulation.federate, simulation.is_alone, has_used) {
            log::warn!("the script for devices has values of {name} (line {line}), which this program has not read");
        }
        let Some(path) = &simulation.recording else { return };
        let write = || recording::write(BufWriter::new(File::create(path)?), &[simulation.recorded()]);
        if let Err(error) = write() {
            log::error!("cannot write what pins did to {}: {error}", path.display());
        }
    }
}
