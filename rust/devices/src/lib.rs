// SPDX-License-Identifier: Apache-2.0
//! Devices as bodies see them: pins that are driven or read, and edges that schedule physical actions.
//!
//! A platform says with [`Pin`] what it can do with a pin, and bodies get [`Output`] and [`Input`] of it, with the
//! traits of `embedded-hal`, so that a driver crate runs on all platforms. Nothing here allocates, and nothing is of
//! one system.
//!
//! What bodies call is logical: an active pin is one that does what it is for, such as an LED that is lit, whichever
//! level its wiring needs. What `embedded-hal` calls is electrical: high and low.
#![no_std]
#![forbid(unsafe_code)]

mod error;
mod interrupt;
mod pin;

pub use embedded_hal;
pub use error::{DeviceError, Problem};
pub use interrupt::{Edge, EdgePoster, EdgeValue};
pub use pin::{Input, Output, Pin};
