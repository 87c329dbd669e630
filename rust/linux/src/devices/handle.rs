// SPDX-License-Identifier: Apache-2.0
//! Devices by the simulation.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use lf_devices::embedded_hal::{i2c, spi};
use lf_devices::{
    AnalogInput, Channel, Device, DeviceError, Edge, EventPoster, I2cBus, Pin, Problem, PwmChannel, SensorDevice,
    SensorValue, SerialLine, SpiTarget,
};
use lf_model::time::{Instant, Interval};
use lf_model::{Outside, PhysicalLink};
use lf_runtime::{DeviceRemark, tell};
use log::Level;

use super::recording::Signal;
use super::simulation::Simulation;
use crate::outside::HostOutside;

/// A pin that is driven: see [`lf_devices::Output`].
pub type Output = lf_devices::Output<Handle>;
/// A pin that is read: see [`lf_devices::Input`].
pub type Input = lf_devices::Input<Handle>;
/// A channel of PWM, whose period is 20 ms: see [`lf_devices::Pwm`].
pub type Pwm = lf_devices::Pwm<Handle>;
/// A voltage that is measured, with 12 bits for 3.3 V: see [`lf_devices::Adc`].
pub type Adc = lf_devices::Adc<Handle>;
/// An I²C bus: see [`lf_devices::I2c`].
pub type I2c = lf_devices::I2c<Handle>;
/// A device on an SPI bus: see [`lf_devices::Spi`].
pub type Spi = lf_devices::Spi<Handle>;
/// A serial line: see [`lf_devices::Uart`].
pub type Uart = lf_devices::Uart<Handle>;
/// A sensor: see [`lf_devices::Sensor`].
pub type Sensor = lf_devices::Sensor<Handle>;

/// The period of PWM, in nanoseconds.
const PERIOD: u32 = 20_000_000;
/// What converters have at most, and at how many millivolts.
const FULL_SCALE: (i32, i32) = (4095, 3300);

/// A device, which has not been set up yet. What it is its methods say; on a board, its devicetree.
#[derive(Clone, Copy, Debug)]
pub struct Handle {
    name: &'static str,
}

impl Handle {
    /// What `device!` gives.
    #[doc(hidden)]
    pub const fn named(name: &'static str) -> Self {
        Self { name }
    }

    /// Makes a pin an output, which is inactive at first.
    ///
    /// # Errors
    /// None; on boards, when the driver is missing, is not ready or refuses.
    pub fn output(self) -> Result<Output, DeviceError> {
        Output::new(self, false)
    }

    /// Makes a pin an output, which is active at first.
    ///
    /// # Errors
    /// None; on boards, when the driver is missing, is not ready or refuses.
    pub fn output_active(self) -> Result<Output, DeviceError> {
        Output::new(self, true)
    }

    /// Makes a pin an input.
    ///
    /// # Errors
    /// When a line of the script has no level for it; on boards, when the driver is missing, is not ready or refuses.
    pub fn input(self) -> Result<Input, DeviceError> {
        Input::new(self)
    }

    /// Takes a channel of PWM into use.
    ///
    /// # Errors
    /// None; on boards, when the driver is missing or is not ready.
    pub fn pwm(self) -> Result<Pwm, DeviceError> {
        Pwm::new(self)
    }

    /// Sets up a channel of an analog-to-digital converter.
    ///
    /// # Errors
    /// When a line of the script has no voltage for it; on boards, when the driver is missing, is not ready or refuses.
    pub fn adc(self) -> Result<Adc, DeviceError> {
        Adc::new(self)
    }

    /// Takes an I²C bus into use, or one with a device on it.
    ///
    /// # Errors
    /// When the script has no registers for it; on boards, when the driver is missing or is not ready.
    pub fn i2c(self) -> Result<I2c, DeviceError> {
        I2c::new(self)
    }

    /// Takes a device on an SPI bus into use.
    ///
    /// # Errors
    /// When the script has no registers for it; on boards, when the driver is missing or is not ready.
    pub fn spi(self) -> Result<Spi, DeviceError> {
        Spi::new(self)
    }

    /// Takes a serial line into use.
    ///
    /// # Errors
    /// When a line of the script has no text for it; on boards, when the driver is missing or is not ready.
    pub fn uart(self) -> Result<Uart, DeviceError> {
        Uart::new(self)
    }

    /// Takes a sensor into use that the platform has a driver for.
    ///
    /// # Errors
    /// When the script has no channels for it; on boards, when it is none, or its driver is missing or not ready.
    pub fn sensor(self) -> Result<Sensor, DeviceError> {
        Sensor::new(self)
    }
}

impl Device for Handle {
    fn name(&self) -> &'static str {
        self.name
    }
}

impl Pin for Handle {
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
        Watch::new(self.name, edges, link, poster)
    }
}

impl PwmChannel for Handle {
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

impl AnalogInput for Handle {
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

impl I2cBus for Handle {
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

impl SpiTarget for Handle {
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

impl SerialLine for Handle {
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
        Watch::new(self.name, Simulation::of_program().arrivals(self.name)?, link, poster)
    }
}

impl SensorDevice for Handle {
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
        Watch::new(self.name, Simulation::of_program().samples(self.name), link, poster)
    }
}

/// The interrupts of a device, until this is dropped.
#[derive(Debug)]
pub struct Watch {
    /// When it is gone the thread ends that makes them.
    _alive: Sender<()>,
}

impl Watch {
    /// Posts what happens from now on, with its times since the start.
    fn new(
        name: &'static str,
        events: Vec<(Interval, u8)>,
        link: PhysicalLink,
        poster: EventPoster,
    ) -> Result<Self, Problem> {
        let (alive, ended) = channel::<()>();
        let run = move || {
            let start = link.get_start_time();
            let now = link.get_physical_time();
            let mut lost = 0;
            for (offset, value) in events.into_iter().filter(|(offset, _)| start + *offset > now) {
                if !wait_until(start + offset, &ended) {
                    break;
                }
                if poster.post(value).is_err() {
                    lost += 1;
                } else if lost > 0 {
                    tell_of_lost(name, std::mem::take(&mut lost));
                }
            }
            tell_of_lost(name, lost);
        };
        let thread = thread::Builder::new().name(name.to_owned()).spawn(run);
        thread.map(|_| Self { _alive: alive }).map_err(|error| Problem::Failed(error.raw_os_error().unwrap_or(0)))
    }
}

/// Waits for a physical time; `false` when the watch has ended before.
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

fn tell_of_lost(device: &'static str, events: u32) {
    if events > 0 {
        tell(Level::Warn, &DeviceRemark::EventsLost { device, events });
    }
}
