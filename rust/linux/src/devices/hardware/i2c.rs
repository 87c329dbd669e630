// SPDX-License-Identifier: Apache-2.0
//! Devices on I²C buses, by i2c-dev.

use std::fmt;
use std::io;
use std::sync::{Mutex, PoisonError};

use lf_devices::embedded_hal::i2c::{I2c as _, Operation};
use lf_devices::{Device, I2cBus, Problem};
use linux_embedded_hal::I2cdev;
use linux_embedded_hal::i2cdev::linux::LinuxI2CError;

use super::super::binding::{Bound, Kind};
use super::{Advice, DeviceRef, failed};

const ADVICE: Advice = Advice {
    missing: "which is not there: is the driver i2c-dev loaded, and the bus enabled? `i2cdetect -l` lists them",
    denied: "which this user may not open: as a rule members of the group i2c may",
    busy: "where a driver of the kernel has this address; if it is one of a sensor, write iio or hwmon",
    other: "but the program uses it as an I²C bus: write i2c, its file and perhaps an address",
};

/// An I²C bus, or a device on it.
pub struct KernelI2c {
    place: DeviceRef,
    address: Option<u8>,
    bus: Mutex<I2cdev>,
}

impl KernelI2c {
    /// Opens the bus of a line of the script.
    pub(in super::super) fn open(name: &'static str, bound: &'static Bound) -> Result<Self, Problem> {
        let place = DeviceRef::of(name, bound, &ADVICE);
        let Kind::I2c { address } = bound.binding.kind else { return Err(place.is_other()) };
        let bus = I2cdev::new(place.path).map_err(|error| place.refuses(&error.into()))?;
        Ok(Self { place, address, bus: Mutex::new(bus) })
    }
}

impl fmt::Debug for KernelI2c {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("I2c").field("place", &self.place).field("address", &self.address).finish_non_exhaustive()
    }
}

impl Device for KernelI2c {
    fn name(&self) -> &'static str {
        self.place.name
    }
}

impl I2cBus for KernelI2c {
    fn is_ready(&self) -> Result<(), Problem> {
        Ok(())
    }

    fn address(&self) -> Option<u8> {
        self.address
    }

    fn transaction(&self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Problem> {
        let mut bus = self.bus.lock().unwrap_or_else(PoisonError::into_inner);
        bus.transaction(address, operations).map_err(|error| match system_error(error.inner()) {
            error if error.kind() == io::ErrorKind::ResourceBusy => self.place.refuses(&error),
            error => failed(&error),
        })
    }
}

fn system_error(error: &LinuxI2CError) -> io::Error {
    let number = match error {
        LinuxI2CError::Errno(number) => *number,
        LinuxI2CError::Io(error) => super::number(error),
    };
    io::Error::from_raw_os_error(number)
}
