// SPDX-License-Identifier: Apache-2.0
//! Devices of the board, by the names that its devicetree has for them: see [`device!`](crate::device).
//!
//! zephyr-lang-rust's own support for the devicetree is not used: what it generates is of its crate `zephyr`, which
//! asks for `alloc` and has a panic handler of its own (`docs/decisions/019-devices-by-macro.md`).

pub use lf_devices::{DeviceError, Edge, Problem, embedded_hal};

mod delay;
#[cfg(CONFIG_GPIO)]
mod interrupts;
#[cfg(CONFIG_GPIO)]
mod pin;
#[cfg(CONFIG_GPIO)]
mod spec;

pub use delay::Delay;
#[cfg(CONFIG_GPIO)]
pub(crate) use interrupts::tell_of_lost;
#[cfg(CONFIG_GPIO)]
pub use pin::{Gpio, Input, Output};
#[cfg(CONFIG_GPIO)]
#[doc(hidden)]
pub use spec::Spec;

// The module `pins`, and the macro `__device!`.
#[cfg(CONFIG_GPIO)]
include!(concat!(env!("OUT_DIR"), "/devices.rs"));

/// What `device!` finds without drivers.
#[cfg(not(CONFIG_GPIO))]
#[doc(hidden)]
#[macro_export]
macro_rules! __device {
    ($($name:tt)*) => {
        compile_error!(concat!(
            "the image has no driver for the pin `",
            stringify!($($name)*),
            "`: set CONFIG_GPIO=y in the application's prj.conf"
        ))
    };
}
