// SPDX-License-Identifier: Apache-2.0
//! Devices of the simulation.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use lf_devices::embedded_hal::{i2c, spi};
use lf_devices::{
    AnalogInput, Channel, Device, Edge, EventPoster, I2cBus, Pin, Problem, PwmChannel, SensorDevice, SensorValue,
    SerialLine, SpiTarget,
};
use lf_model::time::{Instant, Interval};
use lf_model::{Outside, PhysicalLink};

use super::recording::Signal;
use super::simulation::Simulation;
use super::watch::{Lost, Watch};
use crate::outside::HostOutside;

/// The period of PWM, in nanoseconds.
const PERIOD: u32 = 20_000_000;
/// The maximum value of converters, and its millivolts.
const FULL_SCALE: (i32, i32) = (4095, 3300);

/// A device that the script simulates.
#[derive(Clone, Copy, Debug)]
pub struct Simulated {
    pub(super) name: &'static str,
}

impl Device for Simulated {
    fn name(&self) -> &'static str {
        self.name
    }
}

impl Pin for Simulated {
    type Watch = Watch;

    fn is_active_low(&self) -> bool {
        false
    }

    fn configure_output(&self, active: bool) -> Result<(), Problem> {
        Pin::set(self, active)
    }

    fn configure_input(&self) -> Result<(), Problem> {
        Simulation::of_program().reads(self.name)
    }

    fn set(&self, active: bool) -> Result<(), Problem> {
        Simulation::of_program().drives(self.name, Signal::Level(active));
        Ok(())
    }

    fn is_active(&self) -> Result<bool, Problem> {
        Ok(Simulation::of_program().signal(self.name) == Some(Signal::Level(true)))
    }

    fn watch(&self, edge: Edge, link: PhysicalLink, poster: EventPoster) -> Result<Watch, Problem> {
        let mut edges = Simulation::of_program().edges(self.name);
        edges.retain(|(_, level)| edge.is(*level == 1));
        watch(self.name, edges, link, poster)
    }
}

impl PwmChannel for Simulated {
    fn is_ready(&self) -> Result<(), Problem> {
        Ok(())
    }

    fn period(&self) -> u32 {
        PERIOD
    }

    fn set_pulse(&self, nanoseconds: u32) -> Result<(), Problem> {
        let part = f64::from(nanoseconds) / f64::from(PERIOD);
        Simulation::of_program().drives(self.name, Signal::Real(part));
        Ok(())
    }
}

impl AnalogInput for Simulated {
    fn configure(&self) -> Result<(), Problem> {
        Simulation::of_program().measures(self.name)
    }

    fn sample(&self) -> Result<i32, Problem> {
        let Some(Signal::Real(millivolts)) = Simulation::of_program().signal(self.name) else { return Ok(0) };
        let (most, at) = (f64::from(FULL_SCALE.0), f64::from(FULL_SCALE.1));
        #[expect(clippy::cast_possible_truncation, reason = "it is at most full scale")]
        let sample = (millivolts.clamp(0.0, at) * most / at).round() as i32;
        Ok(sample)
    }

    fn millivolts(&self, sample: i32) -> Result<i32, Problem> {
        let (most, at) = FULL_SCALE;
        Ok((sample * at + most / 2) / most)
    }
}

impl I2cBus for Simulated {
    fn is_ready(&self) -> Result<(), Problem> {
        Simulation::of_program().has_registers(self.name)
    }

    fn address(&self) -> Option<u8> {
        Simulation::of_program().address(self.name)
    }

    fn transaction(&self, address: u8, operations: &mut [i2c::Operation<'_>]) -> Result<(), Problem> {
        log::debug!("{} at {address:#x}: {operations:02x?}", self.name);
        Simulation::of_program().with_registers(self.name, Some(address), |registers| {
            let mut is_writing = false;
            for operation in operations {
                match operation {
                    i2c::Operation::Write(bytes) if is_writing => registers.write_on(bytes),
                    i2c::Operation::Write(bytes) => registers.write(bytes),
                    i2c::Operation::Read(bytes) => registers.read(bytes),
                }
                is_writing = matches!(operation, i2c::Operation::Write(_));
            }
        })
    }
}

impl SpiTarget for Simulated {
    fn is_ready(&self) -> Result<(), Problem> {
        Simulation::of_program().has_registers(self.name)
    }

    fn transaction(&self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), Problem> {
        log::debug!("{}: {operations:02x?}", self.name);
        Simulation::of_program().with_registers(self.name, None, |registers| {
            let mut command = None;
            for operation in operations {
                match operation {
                    spi::Operation::Read(bytes) => bytes.fill_with(|| registers.exchange(&mut command, 0)),
                    spi::Operation::Write(bytes) => {
                        for byte in *bytes {
                            registers.exchange(&mut command, *byte);
                        }
                    }
                    spi::Operation::Transfer(read, write) => {
                        for at in 0..read.len().max(write.len()) {
                            let received = registers.exchange(&mut command, write.get(at).copied().unwrap_or(0));
                            if let Some(byte) = read.get_mut(at) {
                                *byte = received;
                            }
                        }
                    }
                    spi::Operation::TransferInPlace(bytes) => {
                        for byte in bytes.iter_mut() {
                            *byte = registers.exchange(&mut command, *byte);
                        }
                    }
                    spi::Operation::DelayNs(ns) => thread::sleep(Duration::from_nanos((*ns).into())),
                }
            }
        })
    }
}

impl SerialLine for Simulated {
    type Watch = Watch;

    fn is_ready(&self) -> Result<(), Problem> {
        Simulation::of_program().arrivals(self.name).map(drop)
    }

    fn send(&self, bytes: &[u8]) -> Result<(), Problem> {
        log::debug!("{} sends \"{}\"", self.name, bytes.escape_ascii());
        Ok(())
    }

    fn receive(&self) -> Result<Option<u8>, Problem> {
        Simulation::of_program().receives(self.name)
    }

    fn pause(&self) {
        thread::sleep(Duration::from_micros(100));
    }

    fn watch(&self, link: PhysicalLink, poster: EventPoster) -> Result<Watch, Problem> {
        watch(self.name, Simulation::of_program().arrivals(self.name)?, link, poster)
    }
}

impl SensorDevice for Simulated {
    type Watch = Watch;

    fn is_ready(&self) -> Result<(), Problem> {
        Simulation::of_program().fetches(self.name)
    }

    fn fetch(&self) -> Result<(), Problem> {
        Simulation::of_program().fetches(self.name)
    }

    fn value(&self, channel: Channel) -> Result<SensorValue, Problem> {
        Simulation::of_program().measured(self.name, channel)
    }

    fn watch(&self, link: PhysicalLink, poster: EventPoster) -> Result<Watch, Problem> {
        watch(self.name, Simulation::of_program().samples(self.name), link, poster)
    }
}

/// Posts events from now on, with their times since the start.
fn watch(
    name: &'static str,
    events: Vec<(Interval, u8)>,
    link: PhysicalLink,
    poster: EventPoster,
) -> Result<Watch, Problem> {
    // The thread that posts events ends when this is dropped.
    let (alive, ended): (Sender<()>, _) = channel();
    let run = move || {
        let start = link.get_start_time();
        let now = link.get_physical_time();
        let mut lost = Lost::of(name);
        for (offset, value) in events.into_iter().filter(|(offset, _)| start + *offset > now) {
            if !wait_until(start + offset, &ended) {
                break;
            }
            lost.count(poster.post(value));
        }
    };
    let thread = thread::Builder::new().name(name.to_owned()).spawn(run);
    thread.map(|_| Watch::until_dropped(alive)).map_err(|error| Problem::Failed(error.raw_os_error().unwrap_or(0)))
}

/// Waits for a physical time. Returns `false` when the watch has ended before.
fn wait_until(time: Instant, ended: &Receiver<()>) -> bool {
    loop {
        let left = time.since(HostOutside::of_program().physical_time());
        if left <= Interval::ZERO {
            return true;
        }
        let left = Duration::from_nanos(u64::try_from(left.as_nanos()).unwrap_or(0));
        if ended.recv_timeout(left) == Err(RecvTimeoutError::Disconnected) {
            return false;
        }
    }
}
