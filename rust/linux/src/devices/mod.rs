// SPDX-License-Identifier: Apache-2.0
//! Devices of a computer: a script binds some to real devices; for the others, the script determines the inputs, and a
//! recording stores the outputs.
//!
//! The same program runs on a board, where [`device!`](crate::device) finds the devices of the devicetree.
#![cfg_attr(
    not(feature = "devices"),
    expect(dead_code, reason = "the script and the recording are there without them")
)]

use lf_devices::embedded_hal::delay::DelayNs;
pub use lf_devices::{Channel, DeviceError, Edge, Problem, SensorValue, embedded_hal, embedded_io};

#[cfg(feature = "devices")]
mod backend;
mod binding;
#[cfg(feature = "devices")]
mod handle;
#[cfg(feature = "devices")]
mod hardware;
mod line;
#[doc(hidden)]
pub mod moves;
#[doc(hidden)]
pub mod recording;
mod registers;
mod script;
#[cfg(feature = "devices")]
mod simulated;
mod simulation;
#[cfg(feature = "devices")]
mod watch;
mod words;

#[cfg(feature = "devices")]
pub use handle::{Adc, Handle, I2c, Input, Output, Pwm, Sensor, Spi, Uart};
pub(crate) use script::Script;
pub(crate) use simulation::Simulation;

/// Returns a device by its alias or its label in a board's devicetree: `device!(led0)`.
///
/// Here every name is one of a device of any kind; on a board it has to be in the devicetree.
#[cfg(feature = "devices")]
#[macro_export]
macro_rules! device {
    ($($name:tt)+) => { $crate::devices::Handle::named(::core::stringify!($($name)+)) };
}

/// Waits, as driver crates require: `embedded_hal::delay::DelayNs`.
///
/// The event loop waits meanwhile, too, so that all reactions are late by it. Use an action to schedule something for
/// later.
#[derive(Clone, Copy, Debug, Default)]
pub struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        std::thread::sleep(std::time::Duration::from_nanos(ns.into()));
    }
}
