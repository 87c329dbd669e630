// SPDX-License-Identifier: Apache-2.0
//! The macros of generated crates and of bodies.

/// Makes a program of generated code that of the image: `main!(federate::Main)`, by its type in a module that also has
/// its description and the engine's storage.
///
/// The program runs in static memory when the application calls `lf_main()`. Tests that are not LF programs pass a
/// function of the platform, and the log level.
#[macro_export]
macro_rules! main {
    ($module:ident::$program:ident) => {
        $crate::main!(
            @run
            |platform: &mut $crate::ImagePlatform| {
                let mut participant = $crate::recording::RecordedParticipant::Federate;
                let recording = participant.recording();
                $crate::run!($module::$program, platform, recording, $crate::settings::join, $crate::settings::BUFFERS)
            },
            $module::DESCRIPTION.logging
        );
    };
    (@$method:ident $run:expr, $logging:expr) => {
        #[unsafe(no_mangle)]
        fn lf_federate_of_image(federate: $crate::Federate<'_>) {
            federate.$method($logging, $run)
        }
    };
    ($run:expr, $logging:expr) => {
        $crate::main!(@run_other $run, $logging);
    };
}

/// Makes an RTI that of the image, by its description in a module: with `CONFIG_LF_RTI`.
#[macro_export]
macro_rules! rti {
    ($module:ident::$description:ident) => {
        #[unsafe(no_mangle)]
        fn lf_rti_of_image() -> $crate::rti::Image {
            static MEMORY: $crate::rti::Memory<{ $crate::rti::buffer_bytes(&$module::$description) }> =
                $crate::rti::Memory::new();
            (&MEMORY, &$module::$description)
        }
    };
}

/// Returns a device of the board, by its alias or its label in the devicetree, with `_` for `-`: `device!(led0)`.
///
/// | call | device |
/// |---|---|
/// | `device!(led0)` | the pin in `gpios` of a node, such as those of LEDs and keys: a [`devices::Gpio`] |
/// | `device!(keys[1])` | one of them, if there are several |
/// | `device!(screen.reset_gpios)` | the pin in another property |
///
/// A device that the devicetree lacks, or has disabled, is an error when the image is compiled.
#[macro_export]
macro_rules! device {
    ($($name:tt)+) => { $crate::__device!($($name)+) };
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
