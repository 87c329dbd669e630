// SPDX-License-Identifier: Apache-2.0
//! The platform for Zephyr, and what a generated image links.
//!
//! Of all crates only this one contains `unsafe`, because it calls C. The calls are bindings that bindgen makes of the
//! very headers that the image is compiled with. Nothing here allocates: sockets and threads have static places whose
//! numbers Kconfig sets.
//!
//! A generated crate names this one `lf`. It is linked as a static library, and says with [`main!`] which program it
//! has, and with [`rti!`] which RTI; the application's `main()` runs both through the C API of `c_api`.
#![no_std]

mod c_api;
pub mod clock;
#[doc(hidden)]
pub mod console;
mod critical;
#[doc(hidden)]
pub mod image;
mod logger;
mod net;
mod outside;
mod panic;
mod platform;
mod raw;
#[cfg(CONFIG_LF_RTI)]
#[doc(hidden)]
pub mod rti;
pub mod settings;
pub mod thread;
mod turn;
mod wake;

pub use c_api::Federate;
pub use lf_model as model;
pub use lf_runtime as runtime;
pub use log;
pub use platform::ZephyrPlatform;
pub use thread::SpawnPhysicalThread;
pub use wake::wake;

/// Numbers that the image's Kconfig sets.
#[allow(clippy::unreadable_literal, reason = "the build script wrote them")]
pub mod kconfig {
    include!(concat!(env!("OUT_DIR"), "/kconfig.rs"));
}

/// What reaction bodies and preambles see without asking for it.
pub mod prelude {
    pub use crate::SpawnPhysicalThread;
    pub use crate::{eprint, eprintln, print, println};
    pub use lf_model::prelude::*;
    // Both spellings work: `info!` and `log::info!`.
    pub use log::{self, debug, error, info, trace, warn};
}

/// Makes a program that of the image, in the form in which generated code names it: by the description, the program
/// and the engine's storage in one module.
///
/// The program runs in static memory when the application calls `lf_main()`.
#[macro_export]
macro_rules! main {
    (&$module:ident::DESCRIPTION, $_1:ident::$program:ident::new() $(, $_2:ident::Storage::new())? $(,)?) => {
        const _: () = assert!(
            $crate::image::has_needed(&$module::DESCRIPTION),
            "the program needs the feature `peers` of lf-zephyr"
        );
        $crate::main!(
            |platform: &mut $crate::ZephyrPlatform| {
                static MEMORY: $crate::image::Memory<
                    $module::$program,
                    $module::Storage,
                    { $crate::image::input_bytes(&$module::DESCRIPTION) },
                    { $crate::image::output_bytes(&$module::DESCRIPTION) },
                    { $crate::image::awaited_inputs(&$module::DESCRIPTION) },
                    { $crate::image::peers_in(&$module::DESCRIPTION).0 },
                    { $crate::image::peers_in(&$module::DESCRIPTION).1 },
                    { $crate::image::peers_out(&$module::DESCRIPTION).0 },
                    { $crate::image::peers_out(&$module::DESCRIPTION).1 },
                > = $crate::image::Memory::new();
                MEMORY.run(platform, &$module::DESCRIPTION, $module::$program::new)
            },
            $module::DESCRIPTION.logging
        );
    };
    // A function of the platform, for tests that are no LF programs.
    ($run:expr, $logging:expr) => {
        #[unsafe(no_mangle)]
        fn lf_federate_of_image(federate: $crate::Federate<'_>) {
            federate.run($logging, $run)
        }
    };
}

/// Makes an RTI that of the image, by its description in a module: with `CONFIG_LF_RTI`.
#[macro_export]
macro_rules! rti {
    (&$module:ident::RTI) => {
        #[unsafe(no_mangle)]
        fn lf_rti_of_image() -> (&'static dyn $crate::rti::ImageRti, &'static $crate::rti::Description) {
            static MEMORY: $crate::rti::Memory<{ $crate::rti::buffer_bytes(&$module::RTI) }> =
                $crate::rti::Memory::new();
            (&MEMORY, &$module::RTI)
        }
    };
}

/// Prints to Zephyr's console like std's macro, without allocating.
#[macro_export]
macro_rules! print {
    ($($argument:tt)*) => { $crate::console::print(::core::format_args!($($argument)*)) };
}

/// Prints a line to Zephyr's console like std's macro, without allocating. Lines of several threads do not mix.
#[macro_export]
macro_rules! println {
    ($($argument:tt)*) => { $crate::console::print_line(::core::format_args!($($argument)*)) };
}

/// The same as [`print!`]: Zephyr has one console.
#[macro_export]
macro_rules! eprint {
    ($($argument:tt)*) => { $crate::console::print(::core::format_args!($($argument)*)) };
}

/// The same as [`println!`]: Zephyr has one console.
#[macro_export]
macro_rules! eprintln {
    ($($argument:tt)*) => { $crate::console::print_line(::core::format_args!($($argument)*)) };
}
