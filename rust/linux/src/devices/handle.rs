// SPDX-License-Identifier: Apache-2.0
//! What `device!` gives, and what becomes of it: a simulated device, or the one that the script names.

use lf_devices::{DeviceError, Problem};

use super::backend::Backend;
use super::binding::Bound;
use super::hardware;
use super::simulated::Simulated;
use super::simulation::Simulation;

/// A pin that is driven: see [`lf_devices::Output`].
pub type Output = lf_devices::Output<Backend<hardware::Gpio>>;
/// A pin that is read: see [`lf_devices::Input`].
pub type Input = lf_devices::Input<Backend<hardware::Gpio>>;
/// A channel of PWM, whose period is 20 ms unless the script says another one: see [`lf_devices::Pwm`].
pub type Pwm = lf_devices::Pwm<Backend<hardware::KernelPwm>>;
/// A voltage that is measured, in the simulation with 12 bits for 3.3 V: see [`lf_devices::Adc`].
pub type Adc = lf_devices::Adc<Backend<hardware::KernelAdc>>;
/// An I²C bus: see [`lf_devices::I2c`].
pub type I2c = lf_devices::I2c<Backend<hardware::KernelI2c>>;
/// A device on an SPI bus: see [`lf_devices::Spi`].
pub type Spi = lf_devices::Spi<Backend<hardware::KernelSpi>>;
/// A serial line: see [`lf_devices::Uart`].
pub type Uart = lf_devices::Uart<Backend<hardware::Serial>>;
/// A sensor: see [`lf_devices::Sensor`].
pub type Sensor = lf_devices::Sensor<Backend<hardware::KernelSensor>>;

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
    /// When its driver is missing, is not ready or refuses.
    pub fn output(self) -> Result<Output, DeviceError> {
        Output::new(self.taken_by(hardware::Gpio::open)?, false)
    }

    /// Makes a pin an output, which is active at first.
    ///
    /// # Errors
    /// When its driver is missing, is not ready or refuses.
    pub fn output_active(self) -> Result<Output, DeviceError> {
        Output::new(self.taken_by(hardware::Gpio::open)?, true)
    }

    /// Makes a pin an input.
    ///
    /// # Errors
    /// When a line of the script has no level for it;
    /// where it is real, when the driver is missing, is not ready or refuses.
    pub fn input(self) -> Result<Input, DeviceError> {
        Input::new(self.taken_by(hardware::Gpio::open)?)
    }

    /// Takes a channel of PWM into use.
    ///
    /// # Errors
    /// When its driver is missing or is not ready.
    pub fn pwm(self) -> Result<Pwm, DeviceError> {
        Pwm::new(self.taken_by(hardware::KernelPwm::open)?)
    }

    /// Sets up a channel of an analog-to-digital converter.
    ///
    /// # Errors
    /// When a line of the script has no voltage for it;
    /// where it is real, when the driver is missing, is not ready or refuses.
    pub fn adc(self) -> Result<Adc, DeviceError> {
        Adc::new(self.taken_by(hardware::KernelAdc::open)?)
    }

    /// Takes an I²C bus into use, or one with a device on it.
    ///
    /// # Errors
    /// When the script has no registers for it;
    /// where it is real, when the driver is missing or is not ready.
    pub fn i2c(self) -> Result<I2c, DeviceError> {
        I2c::new(self.taken_by(hardware::KernelI2c::open)?)
    }

    /// Takes a device on an SPI bus into use.
    ///
    /// # Errors
    /// When the script has no registers for it;
    /// where it is real, when the driver is missing or is not ready.
    pub fn spi(self) -> Result<Spi, DeviceError> {
        Spi::new(self.taken_by(hardware::KernelSpi::open)?)
    }

    /// Takes a serial line into use.
    ///
    /// # Errors
    /// When a line of the script has no text for it;
    /// where it is real, when the driver is missing or is not ready.
    pub fn uart(self) -> Result<Uart, DeviceError> {
        Uart::new(self.taken_by(hardware::Serial::open)?)
    }

    /// Takes a sensor into use that the platform has a driver for.
    ///
    /// # Errors
    /// When the script has no channels for it;
    /// where it is real, when it is none, or its driver is missing or not ready.
    pub fn sensor(self) -> Result<Sensor, DeviceError> {
        Sensor::new(self.taken_by(hardware::KernelSensor::open)?)
    }

    /// The one place that decides whether a device is simulated.
    fn taken_by<R>(
        self,
        open: fn(&'static str, &'static Bound) -> Result<R, Problem>,
    ) -> Result<Backend<R>, DeviceError> {
        let Some(bound) = Simulation::of_program().bound(self.name) else {
            return Ok(Backend::Simulated(Simulated { name: self.name }));
        };
        open(self.name, bound).map(Backend::Real).map_err(|problem| DeviceError { device: self.name, problem })
    }
}
