// SPDX-License-Identifier: Apache-2.0
//! Devices of a computer that has none: inputs do what a script says, and what all pins do is written down.
//!
//! The same program runs on a board, where [`device!`](crate::device) finds the real ones.

use lf_devices::embedded_hal::delay::DelayNs;
pub use lf_devices::{DeviceError, Edge, Problem, embedded_hal};

mod pin;
#[doc(hidden)]
pub mod recording;
mod script;
mod simulation;

pub use pin::{Gpio, Input, Output, Watch};
pub(crate) use script::Script;
pub(crate) use simulation::{Simulation, starts};

/// A device, by the alias or the label that a board's devicetree has for it: `device!(led0)`.
///
/// Here every name is one of a pin; on a board it has to be in the devicetree.
#[macro_export]
macro_rules! device {
    ($($name:tt)+) => { $crate::devices::Gpio::named(::core::stringify!($($name)+)) };
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
