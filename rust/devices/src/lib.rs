// SPDX-License-Identifier: Apache-2.0
//! Devices as bodies see them: pins, PWM, ADCs, buses, serial lines and sensors, and what of them schedules physical
//! actions.
//!
//! A platform says with a trait such as [`Pin`] what it can do with a device, and bodies get [`Output`] and [`Input`]
//! of it, with the traits of `embedded-hal` and `embedded-io`, so that a driver crate runs on all platforms. Nothing
//! here allocates, and nothing is of one system.
//!
//! What bodies call of pins is logical: an active pin is one that does what it is for, such as an LED that is lit,
//! whichever level its wiring needs. What `embedded-hal` calls is electrical: high and low.
#![no_std]
#![forbid(unsafe_code)]

mod adc;
mod error;
mod i2c;
mod interrupt;
mod pin;
mod pwm;
mod sensor;
mod spi;
mod uart;

pub use adc::{Adc, AnalogInput};
pub use embedded_hal;
pub use embedded_io;
pub use error::{Device, DeviceError, Problem};
pub use i2c::{I2c, I2cBus};
pub use interrupt::{Edge, EventPoster, EventValue};
pub use pin::{Input, Output, Pin};
pub use pwm::{Pwm, PwmChannel};
pub use sensor::{Channel, Sensor, SensorDevice, SensorValue};
pub use spi::{Spi, SpiTarget};
pub use uart::{SerialLine, Uart};
