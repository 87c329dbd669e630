// SPDX-License-Identifier: Apache-2.0
//! Devices on SPI buses.

use embedded_hal::spi::{self, ErrorType, Operation};

use crate::error::{Device, DeviceError, Problem};

/// The platform's interface of a device on an SPI bus.
pub trait SpiTarget: Device {
    /// Checks that it can be used.
    ///
    /// # Errors
    /// When its driver is missing, or could not start.
    fn is_ready(&self) -> Result<(), Problem>;
    /// Performs these operations while the device is selected.
    ///
    /// # Errors
    /// When the driver reports one.
    fn transaction(&self, operations: &mut [Operation<'_, u8>]) -> Result<(), Problem>;
}

/// A device on an SPI bus, which is selected during transactions.
///
/// It implements `embedded_hal::spi::SpiDevice` for driver crates. Its frequency, mode and select pin are those of the
/// devicetree.
#[derive(Debug)]
pub struct Spi<T> {
    target: T,
}

impl<T: SpiTarget> Spi<T> {
    /// Opens the device.
    ///
    /// # Errors
    /// When the driver of its bus is missing, or could not start.
    pub fn new(target: T) -> Result<Self, DeviceError> {
        target.named(target.is_ready())?;
        Ok(Self { target })
    }
}

impl<T: SpiTarget> ErrorType for Spi<T> {
    type Error = DeviceError;
}

impl<T: SpiTarget> spi::SpiDevice for Spi<T> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), DeviceError> {
        self.target.named(self.target.transaction(operations))
    }
}
