// SPDX-License-Identifier: Apache-2.0
//! The errors of devices.

use core::error::Error;
use core::fmt;

use embedded_hal::{digital, i2c, pwm, spi};

/// The platform's interface of any device.
pub trait Device: fmt::Debug {
    /// Returns the program's name of it.
    fn name(&self) -> &'static str;

    /// Adds the device's name to an outcome.
    ///
    /// # Errors
    /// The same.
    fn named<T>(&self, outcome: Result<T, Problem>) -> Result<T, DeviceError> {
        outcome.map_err(|problem| DeviceError { device: self.name(), problem })
    }
}

/// The error of a device. Its `Debug` is a sentence, too, because a panic of `unwrap()` prints that.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct DeviceError {
    /// The device, by its name in the program.
    pub device: &'static str,
    /// The problem.
    pub problem: Problem,
}

/// The problem of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Problem {
    /// The image has no driver for it.
    NoDriver,
    /// Its driver could not start.
    NotReady,
    /// Its driver cannot do this.
    NotSupported,
    /// A line whose bytes schedule an action cannot be read.
    BytesAreEvents,
    /// It has no address: it is a bus.
    NoAddress,
    /// It is not there: the script for devices has no line for it.
    NotSimulated {
        /// An example of the text behind the name in such a line.
        example: &'static str,
    },
    /// A line of the script for devices does not fit it.
    Script {
        /// The line, from 1.
        line: u32,
        /// The expected kind.
        expected: &'static str,
    },
    /// The device of this computer that a line of the script for devices names cannot be used.
    Hardware {
        /// The line, from 1.
        line: u32,
        /// Its file, or its folder in sysfs.
        path: &'static str,
        /// The problem, and advice.
        what: &'static str,
        /// The system's error, a number of `errno.h`; 0 for none.
        error: i32,
    },
    /// There is no room for another device that schedules actions.
    NoInterruptLeft {
        /// The number of such devices.
        interrupts: usize,
    },
    /// Its driver reports this error, a number of `errno.h`.
    Failed(i32),
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDriver => f.write_str(
                "the image has no driver for its controller: prj.conf, or a board's file, leaves it out; each driver \
                 has an option, such as CONFIG_GPIO_STELLARIS",
            ),
            Self::NotReady => f.write_str("its driver could not start; the boot messages may say why"),
            Self::NotSupported => f.write_str("its driver cannot do this"),
            Self::BytesAreEvents => f.write_str(
                "each byte schedules an action, so that none is left to be read: call ignore_bytes() before",
            ),
            Self::NoAddress => f.write_str(
                "it has no address: on a board a bus has none, but what the devicetree has on it; on Linux one comes \
                 after the name in the script for devices, such as thermometer@48",
            ),
            Self::NotSimulated { example } => write!(
                f,
                "nothing simulates it: --devices FILE names a script, in which its name is followed by {example}"
            ),
            Self::Script { line, expected } => {
                write!(f, "line {line} of the script for devices has a value that it cannot have: {expected}")
            }
            Self::Hardware { line, path, what, error } => {
                write!(f, "it is {path}, says line {line} of the script for devices, {what}")?;
                if *error == 0 { Ok(()) } else { write!(f, " (error {error})") }
            }
            Self::NoInterruptLeft { interrupts } => write!(
                f,
                "{interrupts} devices schedule actions already, which is all there is room for: raise \
                 CONFIG_LF_INTERRUPTS"
            ),
            Self::Failed(error) => write!(f, "its driver reports error {error}"),
        }
    }
}

impl fmt::Display for DeviceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.device, self.problem)
    }
}

impl fmt::Debug for DeviceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl Error for DeviceError {}

impl digital::Error for DeviceError {
    fn kind(&self) -> digital::ErrorKind {
        digital::ErrorKind::Other
    }
}

impl i2c::Error for DeviceError {
    fn kind(&self) -> i2c::ErrorKind {
        i2c::ErrorKind::Other
    }
}

impl spi::Error for DeviceError {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

impl pwm::Error for DeviceError {
    fn kind(&self) -> pwm::ErrorKind {
        pwm::ErrorKind::Other
    }
}

impl embedded_io::Error for DeviceError {
    fn kind(&self) -> embedded_io::ErrorKind {
        embedded_io::ErrorKind::Other
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::string::ToString;

    use super::*;

    #[test]
    fn an_error_names_the_device_and_what_to_do() {
        let error = DeviceError { device: "led0", problem: Problem::NoDriver };
        assert!(error.to_string().starts_with("led0: the image has no driver"), "{error}");
        assert!(error.to_string().contains("CONFIG_GPIO_"), "{error}");
        let error = DeviceError { device: "sw0", problem: Problem::NoInterruptLeft { interrupts: 4 } };
        assert!(error.to_string().ends_with("raise CONFIG_LF_INTERRUPTS"), "{error}");
    }
}
