// SPDX-License-Identifier: Apache-2.0
//! The handle that `device!` returns, and the devices that it can become: a simulated device, or the one that the
//! script names.

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
/// A channel of PWM, whose period is 20 ms unless the script has another one: see [`lf_devices::Pwm`].
pub type Pwm = lf_devices::Pwm<Backend<hardware::KernelPwm>>;
/// A voltage input, in the simulation with 12 bits for 3.3 V: see [`lf_devices::Adc`].
pub type Adc = lf_devices::Adc<Backend<hardware::KernelAdc>>;
/// An I²C bus: see [`lf_devices::I2c`].
pub type I2c = lf_devices::I2c<Backend<hardware::KernelI2c>>;
/// A device on an SPI bus: see [`lf_devices::Spi`].
pub type Spi = lf_devices::Spi<Backend<hardware::KernelSpi>>;
/// A serial line: see [`lf_devices::Uart`].
pub type Uart = lf_devices::Uart<Backend<hardware::Serial>>;
/// A sensor: see [`lf_devices::Sensor`].
pub type Sensor = lf_devices::Sensor<Backend<hardware::KernelSensor>>;

/// A device that has not been set up yet. The program's call determines its kind; on a board, the devicetree does.
#[derive(Clone, Copy, Debug)]
pub struct Handle {
    name: &'static str,
}

impl Handle {
    /// Returns the handle for `device!`.
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
    /// When no line of the script has a level for it; for a real pin, when the driver is missing, is not ready or
    /// refuses.
    pub fn input(self) -> Result<Input, DeviceError> {
        Input::new(self.taken_by(hardware::Gpio::open)?)
    }

    /// Opens a channel of PWM.
    ///
    /// # Errors
    /// When its driver is missing or is not ready.
    pub fn pwm(self) -> Result<Pwm, DeviceError> {
        Pwm::new(self.taken_by(hardware::KernelPwm::open)?)
    }

    /// Opens a channel of an analog-to-digital converter.
    ///
    /// # Errors
    /// When no line of the script has a voltage for it; for a real channel, when the driver is missing, is not ready or
    /// refuses.
    pub fn adc(self) -> Result<Adc, DeviceError> {
        Adc::new(self.taken_by(hardware::KernelAdc::open)?)
    }

    /// Opens an I²C bus, or one with a device on it.
    ///
    /// # Errors
    /// When the script has no registers for it; for a real bus, when the driver is missing or is not ready.
    pub fn i2c(self) -> Result<I2c, DeviceError> {
        I2c::new(self.taken_by(hardware::KernelI2c::open)?)
    }

    /// Opens a device on an SPI bus.
    ///
    /// # Errors
    /// When the script has no registers for it; for a real device, when the driver is missing or is not ready.
    pub fn spi(self) -> Result<Spi, DeviceError> {
        Spi::new(self.taken_by(hardware::KernelSpi::open)?)
    }

    /// Opens a serial line.
    ///
    /// # Errors
    /// When no line of the script has a text for it; for a real line, when the driver is missing or is not ready.
    pub fn uart(self) -> Result<Uart, DeviceError> {
        Uart::new(self.taken_by(hardware::Serial::open)?)
    }

    /// Opens a sensor that the platform has a driver for.
    ///
    /// # Errors
    /// When the script has no channels for it; for a real device, when it is not a sensor, or its driver is missing or
    /// not ready.
    pub fn sensor(self) -> Result<Sensor, DeviceError> {
        Sensor::new(self.taken_by(hardware::KernelSensor::open)?)
    }

    /// Decides, here only, whether a device is simulated.
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
