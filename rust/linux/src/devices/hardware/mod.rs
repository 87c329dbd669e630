// SPDX-License-Identifier: Apache-2.0
//! Devices of this computer.

mod gpio;
mod i2c;
mod listener;
mod measured;
mod pwm;
mod serial;
mod spi;
mod sysfs;

use std::io;

use lf_devices::Problem;

use super::binding::Bound;

pub(super) use gpio::Gpio;
pub(super) use i2c::KernelI2c;
pub(super) use measured::{KernelAdc, KernelSensor};
pub(super) use pwm::KernelPwm;
pub(super) use serial::Serial;
pub(super) use spi::KernelSpi;

/// A device, by its name in the program and by the line of the script that binds it.
#[derive(Clone, Copy, Debug)]
struct DeviceRef {
    name: &'static str,
    line: u32,
    path: &'static str,
    advice: &'static Advice,
}

/// The problems of a kind of device by the system's errors, and advice.
#[derive(Debug)]
struct Advice {
    missing: &'static str,
    denied: &'static str,
    busy: &'static str,
    /// The advice if the script has another kind for it.
    other: &'static str,
}

impl DeviceRef {
    fn of(name: &'static str, bound: &'static Bound, advice: &'static Advice) -> Self {
        Self { name, line: bound.line, path: &bound.binding.path, advice }
    }

    /// Returns the problem that the program uses it as another kind.
    fn is_other(&self) -> Problem {
        self.problem(self.advice.other, 0)
    }

    /// Returns the problem that it cannot be opened.
    fn refuses(&self, error: &io::Error) -> Problem {
        let what = match error.kind() {
            io::ErrorKind::NotFound => self.advice.missing,
            io::ErrorKind::PermissionDenied => self.advice.denied,
            io::ErrorKind::ResourceBusy => self.advice.busy,
            _ => "whose driver refuses it",
        };
        self.problem(what, number(error))
    }

    fn problem(&self, what: &'static str, error: i32) -> Problem {
        Problem::Hardware { line: self.line, path: self.path, what, error }
    }
}

/// Returns the problem that an open device fails.
fn failed(error: &io::Error) -> Problem {
    Problem::Failed(number(error))
}

/// Returns the error number; 0 if the system has not reported it.
fn number(error: &io::Error) -> i32 {
    error.raw_os_error().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use lf_devices::{Device, DeviceError};

    use super::super::script::Script;
    use super::*;

    /// Returns the error of opening the device of this line of a script.
    pub(super) fn refused<D: Device>(
        open: impl Fn(&'static str, &'static Bound) -> Result<D, Problem>,
        take: impl Fn(&D) -> Result<(), Problem>,
        line: &str,
    ) -> String {
        let problem = open("x", bound(line)).and_then(|device| take(&device)).expect_err(line);
        DeviceError { device: "x", problem }.to_string()
    }

    /// Returns the binding of `x` in a line of a script.
    pub(super) fn bound(line: &str) -> &'static Bound {
        let script: &'static Script = Box::leak(Box::new(Script::read(line).expect(line)));
        script.bound("", "x").expect(line)
    }

    #[test]
    fn a_device_that_cannot_be_used_is_named_with_what_to_do() {
        use lf_devices::{I2cBus, Pin, SerialLine, SpiTarget};
        let input = |line: &str| refused(Gpio::open, Pin::configure_input, line);
        let i2c = |line: &str| refused(KernelI2c::open, I2cBus::is_ready, line);
        let spi = |line: &str| refused(KernelSpi::open, SpiTarget::is_ready, line);
        let serial = |line: &str| refused(Serial::open, SerialLine::is_ready, line);
        for (told, has) in [
            (
                input("\nx gpio /dev/gpiochip999 1"),
                "x: it is /dev/gpiochip999, says line 2 of the script for devices, ",
            ),
            (input("x gpio /dev/gpiochip999 1"), "which is not there: `gpiodetect` lists the chips"),
            (input("x gpio /dev/null 1"), "which is no GPIO chip: `gpiodetect` lists those that are"),
            (input("x gpio / 1"), "which is no GPIO chip"),
            (input("x i2c /dev/i2c-1"), "but the program uses it as a pin: write gpio"),
            (i2c("x i2c /dev/i2c-999"), "which is not there: is the driver i2c-dev loaded"),
            (i2c("x i2c /dev/null"), "whose driver refuses it (error 25)"),
            (i2c("x gpio /dev/gpiochip0 1"), "but the program uses it as an I²C bus: write i2c"),
            (spi("x spi /dev/spidev9.9"), "which is not there: is the driver spidev loaded"),
            (spi("x spi /dev/null 1 MHz"), "whose driver refuses it (error 25)"),
            (serial("x serial /dev/ttyUSB999 9600"), "which is not there: is it plugged in?"),
            (serial("x serial /dev/null 9600"), "which is no serial line, or has no such speed (error 25)"),
            (serial("x gpio /dev/gpiochip0 1"), "but the program uses it as a serial line: write serial"),
            (spi("x gpio /dev/gpiochip0 1"), "but the program uses it as a device on an SPI bus: write spi"),
        ] {
            assert!(told.contains(has), "{told}");
        }
    }
}
