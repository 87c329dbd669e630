// SPDX-License-Identifier: Apache-2.0
//! Devices of the board, by their names in its devicetree: see [`device!`](crate::device).
//!
//! zephyr-lang-rust's own support for the devicetree is not used: it generates code for its crate `zephyr`, which
//! requires `alloc` and has a panic handler of its own (`docs/decisions/019-devices-by-macro.md`).
#![allow(dead_code, reason = "an image has only some kinds of devices")]
#![cfg_attr(not(CONFIG_LF_INTERRUPTS), allow(unreachable_pub, unused_imports, reason = "it may have no device"))]

pub use lf_devices::{Channel, DeviceError, Edge, Problem, SensorValue, embedded_hal, embedded_io};

#[cfg(CONFIG_ADC)]
mod adc;
mod delay;
#[cfg(CONFIG_I2C)]
mod i2c;
mod interrupts;
#[cfg(CONFIG_GPIO)]
mod pin;
#[cfg(CONFIG_PWM)]
mod pwm;
mod sensor;
mod spec;
#[cfg(CONFIG_SPI)]
mod spi;
#[cfg(CONFIG_SERIAL)]
mod uart;

#[cfg(CONFIG_ADC)]
pub use adc::{Adc, AdcNode};
pub use delay::Delay;
#[cfg(CONFIG_I2C)]
pub use i2c::{I2c, I2cNode};
#[cfg(CONFIG_LF_INTERRUPTS)]
pub(crate) use interrupts::report_lost;
#[cfg(CONFIG_GPIO)]
pub use pin::{Gpio, Input, Output};
#[cfg(CONFIG_PWM)]
pub use pwm::{Pwm, PwmNode};
pub use sensor::{Sensor, SensorNode};
#[doc(hidden)]
pub use spec::Spec;
#[cfg(CONFIG_SPI)]
pub use spi::{Spi, SpiNode};
#[cfg(CONFIG_SERIAL)]
pub use uart::{Uart, UartNode};

// The module `found`, and the macro `__device!`.
include!(concat!(env!("OUT_DIR"), "/devices.rs"));
