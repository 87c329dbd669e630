// SPDX-License-Identifier: Apache-2.0
//! The devices of this process.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;
use std::sync::{Mutex, OnceLock, PoisonError};

use lf_model::Outside;
use lf_model::time::{Instant, Interval};

use super::recording::{self, Recording};
use super::script::Script;
use crate::outside::HostOutside;

static PROGRAM: OnceLock<Simulation> = OnceLock::new();

/// What inputs do, and what outputs did.
#[derive(Debug, Default)]
pub(crate) struct Simulation {
    federate: String,
    is_alone: bool,
    script: Script,
    recording: Option<PathBuf>,
    start: OnceLock<Instant>,
    pins: Mutex<Pins>,
}

#[derive(Debug, Default)]
struct Pins {
    inputs: BTreeSet<&'static str>,
    /// When outputs changed; without a recording only what they are.
    outputs: BTreeMap<&'static str, Vec<(Instant, bool)>>,
}

/// Ends the simulation when it is dropped: writes the recording.
#[derive(Debug)]
pub(crate) struct Running;

impl Simulation {
    /// The devices of the program that begins now, alone or as a federate. Its recording goes to a file.
    pub(crate) fn begin(federate: &str, is_alone: bool, script: Script, recording: Option<PathBuf>) -> Running {
        let simulation = Self { federate: federate.to_owned(), is_alone, script, recording, ..Self::default() };
        // One process runs one program; tests that run several have no devices.
        let _ = PROGRAM.set(simulation);
        Running
    }

    pub(super) fn of_program() -> &'static Self {
        PROGRAM.get_or_init(Self::default)
    }

    /// A pin is an input.
    pub(super) fn reads(&self, name: &'static str) {
        self.lock().inputs.insert(name);
    }

    /// An output has this level from now on.
    pub(super) fn drives(&self, name: &'static str, active: bool) {
        // The time is read under the lock, so that changes are in its order.
        let mut pins = self.lock();
        let now = HostOutside::of_program().physical_time();
        let changes = pins.outputs.entry(name).or_default();
        if changes.last().is_some_and(|(_, before)| *before == active) {
            return;
        }
        if self.recording.is_none() {
            changes.clear();
        }
        changes.push((now, active));
        drop(pins);
        log::debug!("{name} is {}", u8::from(active));
    }

    /// The level of a pin now: what an output was set to, or what the script says of an input.
    pub(super) fn is_active(&self, name: &'static str) -> bool {
        let pins = self.lock();
        if let Some((_, active)) = pins.outputs.get(name).and_then(|changes| changes.last()) {
            return *active;
        }
        drop(pins);
        let elapsed =
            self.start.get().map_or(Interval::ZERO, |start| HostOutside::of_program().physical_time().since(*start));
        let before = self.changes(name).iter().take_while(|(time, _)| *time <= elapsed);
        before.last().is_some_and(|(_, active)| *active)
    }

    /// What the script says of an input.
    pub(super) fn changes(&self, name: &str) -> &[(Interval, bool)] {
        self.script.changes(&self.federate, name)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Pins> {
        self.pins.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What all pins did until now, since the start.
    fn recorded(&self) -> Recording {
        let start = self.start.get().copied();
        let end = start.map_or(Interval::ZERO, |start| HostOutside::of_program().physical_time().since(start));
        let pins = self.lock();
        let since = |time: Instant| start.map_or(Interval::ZERO, |start| time.since(start));
        let driven = |(&name, changes): (&&'static str, &Vec<(Instant, bool)>)| {
            (name.to_owned(), changes.iter().map(|&(time, active)| (since(time), active)).collect())
        };
        let read = |&name: &&'static str| {
            (name.to_owned(), self.changes(name).iter().copied().take_while(|(time, _)| *time <= end).collect())
        };
        let recorded: BTreeMap<_, _> = pins.inputs.iter().map(read).chain(pins.outputs.iter().map(driven)).collect();
        Recording { federate: self.federate.clone(), pins: recorded.into_iter().collect() }
    }
}

/// The program starts, and with it the script.
pub(crate) fn starts(start: Instant) {
    if let Some(simulation) = PROGRAM.get() {
        simulation.start.get_or_init(|| start);
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let simulation = Simulation::of_program();
        let known = simulation.lock().inputs.clone();
        for name in simulation.script.unknown(&simulation.federate, simulation.is_alone, |name| known.contains(name)) {
            log::warn!("the script for devices has values of {name}, which this program has not read");
        }
        let Some(path) = &simulation.recording else { return };
        let write = || recording::write(BufWriter::new(File::create(path)?), &[simulation.recorded()]);
        if let Err(error) = write() {
            log::error!("cannot write what pins did to {}: {error}", path.display());
        }
    }
}
