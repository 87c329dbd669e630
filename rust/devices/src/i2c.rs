// SPDX-License-Identifier: Apache-2.0
//! Devices on I²C buses.

use embedded_hal::i2c::{self, ErrorType, Operation};

use crate::error::{Device, DeviceError, Problem};

/// The platform's interface of an I²C bus, or of a device on it.
pub trait I2cBus: Device {
    /// Checks that it can be used.
    ///
    /// # Errors
    /// When its driver is missing, or could not start.
    fn is_ready(&self) -> Result<(), Problem>;
    /// Returns the address of the device; `None` for a bus.
    fn address(&self) -> Option<u8>;
    /// Performs these operations with the device of this address, in one transaction.
    ///
    /// # Errors
    /// When the driver reports one: usually, no device has that address.
    fn transaction(&self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Problem>;
}

/// An I²C bus, usually with the address of one of the devices on it. Several drivers can share a bus: each gets one of
/// these.
///
/// It implements `embedded_hal::i2c::I2c` for driver crates.
#[derive(Debug)]
pub struct I2c<B> {
    bus: B,
}

impl<B: I2cBus> I2c<B> {
    /// Opens the bus.
    ///
    /// # Errors
    /// When its driver is missing, or could not start.
    pub fn new(bus: B) -> Result<Self, DeviceError> {
        bus.named(bus.is_ready())?;
        Ok(Self { bus })
    }

    /// Returns the address of the device in the devicetree, in 7 bits.
    ///
    /// # Errors
    /// When it is a bus, which has none.
    pub fn address(&self) -> Result<u8, DeviceError> {
        self.bus.named(self.bus.address().ok_or(Problem::NoAddress))
    }
}

impl<B: I2cBus> ErrorType for I2c<B> {
    type Error = DeviceError;
}

impl<B: I2cBus> i2c::I2c for I2c<B> {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), DeviceError> {
        self.bus.named(self.bus.transaction(address, operations))
    }
}
