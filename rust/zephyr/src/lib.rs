// SPDX-License-Identifier: Apache-2.0
//! The platform for Zephyr, and what a generated image links.
//!
//! Of all crates only this one contains `unsafe`, because it calls C. The calls are bindings that bindgen makes of the
//! very headers that the image is compiled with. Nothing here allocates: sockets and threads have static places whose
//! numbers Kconfig sets.
//!
//! A generated crate is linked as a static library. It says which function runs its federate with [`main!`]; the
//! application's `main()` calls that through the C API of `c_api`.
#![no_std]

mod c_api;
pub mod clock;
mod console;
mod logger;
mod net;
mod panic;
mod platform;
mod raw;
pub mod settings;
pub mod thread;
mod turn;
mod wake;

pub use c_api::Federate;
pub use console::{print, print_line};
pub use lf_runtime as runtime;
pub use log;
pub use platform::ZephyrPlatform;
pub use wake::wake;

/// Numbers that the image's Kconfig sets.
pub mod kconfig {
    include!(concat!(env!("OUT_DIR"), "/kconfig.rs"));
}

/// Names the function that runs the federate of this image: `fn(&mut ZephyrPlatform) -> Result<(), E>`, where `E` can
/// be displayed.
///
/// Its error is logged and makes the program's exit status 1.
#[macro_export]
macro_rules! main {
    ($run:path) => {
        #[unsafe(no_mangle)]
        fn lf_federate_of_image(federate: $crate::Federate<'_>) {
            federate.run($run)
        }
    };
}

/// Prints to Zephyr's console like std's macro, without allocating.
#[macro_export]
macro_rules! print {
    ($($argument:tt)*) => { $crate::print(::core::format_args!($($argument)*)) };
}

/// Prints a line to Zephyr's console like std's macro, without allocating. Lines of several threads do not mix.
#[macro_export]
macro_rules! println {
    ($($argument:tt)*) => { $crate::print_line(::core::format_args!($($argument)*)) };
}

/// The same as [`print!`]: Zephyr has one console.
#[macro_export]
macro_rules! eprint {
    ($($argument:tt)*) => { $crate::print(::core::format_args!($($argument)*)) };
}

/// The same as [`println!`]: Zephyr has one console.
#[macro_export]
macro_rules! eprintln {
    ($($argument:tt)*) => { $crate::print_line(::core::format_args!($($argument)*)) };
}
