// SPDX-License-Identifier: Apache-2.0
//! Devices of a computer that has none: programs find what a script says, and what pins do is written down.
//!
//! The same program runs on a board, where [`device!`](crate::device) finds the real ones.

use lf_devices::embedded_hal::delay::DelayNs;
pub use lf_devices::{Channel, DeviceError, Edge, Problem, SensorValue, embedded_hal, embedded_io};

mod handle;
#[doc(hidden)]
pub mod moves;
#[doc(hidden)]
pub mod recording;
mod registers;
mod script;
mod simulation;

pub use handle::{Adc, Handle, I2c, Input, Output, Pwm, Sensor, Spi, Uart, Watch};
pub(crate) use script::Script;
pub(crate) use simulation::{Simulation, starts};

/// A device, by the alias or the label that a board's devicetree has for it: `device!(led0)`.
///
/// Here every name is one of a device of any kind; on a board it has to be in the devicetree.
#[macro_export]
macro_rules! device {
    ($($name:tt)+) => { $crate::devices::Handle::named(::core::stringify!($($name)+)) };
}

/// Waits, as driver crates ask for it: `embedded_hal::delay::DelayNs`.
///
/// The event loop waits meanwhile, too, so that all reactions are late by it. What is to happen later is better
/// scheduled by an action.
#[derive(Clone, Copy, Debug, Default)]
pub struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        std::thread::sleep(std::time::Duration::from_nanos(ns.into()));
    }
}
