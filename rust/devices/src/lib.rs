// SPDX-License-Identifier: Apache-2.0
//! Devices for bodies: pins, PWM, ADCs, buses, serial lines and sensors, and the physical actions that they schedule.
//!
//! A platform implements a trait such as [`Pin`] for a device, and bodies get [`Output`] and [`Input`] of it, with the
//! traits of `embedded-hal` and `embedded-io`, so that a driver crate runs on all platforms. This crate does not
//! allocate, and is independent of the system.
//!
//! The pin methods for bodies are logical: an active pin does its task, such as a lit LED, whichever level its wiring
//! needs. The methods of `embedded-hal` are electrical: high and low.
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
