// SPDX-License-Identifier: Apache-2.0
//! Devices on SPI buses by Zephyr's drivers.

use core::ptr::{null, null_mut};

use lf_devices::embedded_hal::delay::DelayNs;
use lf_devices::embedded_hal::spi::Operation;
use lf_devices::{Device, DeviceError, Problem, SpiTarget};

use super::delay::Delay;
use super::sensor::{Sensor, SensorNode};
use super::spec::{Spec, outcome};
use crate::raw;

/// A device on an SPI bus: see [`lf_devices::Spi`].
pub type Spi = lf_devices::Spi<SpiNode>;

/// A device on an SPI bus of the devicetree.
#[derive(Clone, Copy, Debug)]
pub struct SpiNode {
    name: &'static str,
    /// Keeps it selected during a transfer.
    spec: &'static Spec<raw::spi_dt_spec>,
    /// Keeps it selected after one, too.
    held: &'static Spec<raw::spi_dt_spec>,
    device: &'static Spec<*const raw::device>,
}

impl SpiNode {
    pub(crate) const fn new(
        name: &'static str,
        spec: &'static Spec<raw::spi_dt_spec>,
        held: &'static Spec<raw::spi_dt_spec>,
        device: &'static Spec<*const raw::device>,
    ) -> Self {
        Self { name, spec, held, device }
    }

    /// Opens the device.
    ///
    /// # Errors
    /// When the driver of its bus is missing or is not ready.
    pub fn spi(self) -> Result<Spi, DeviceError> {
        Spi::new(self)
    }

    /// Returns the device as a sensor, if Zephyr has such a driver for it.
    ///
    /// # Errors
    /// When its driver is missing, is not ready or not one of a sensor.
    pub fn sensor(self) -> Result<Sensor, DeviceError> {
        SensorNode::new(self.name, self.device).sensor()
    }
}

impl Device for SpiNode {
    fn name(&self) -> &'static str {
        self.name
    }
}

impl SpiTarget for SpiNode {
    fn is_ready(&self) -> Result<(), Problem> {
        // SAFETY: its specification is a constant of C; so it is in all calls here.
        outcome(unsafe { raw::lf_spi_ready(self.spec.raw()) }).map(drop)
    }

    fn transaction(&self, operations: &mut [Operation<'_, u8>]) -> Result<(), Problem> {
        let mut transfer = Transfer { spec: self.spec, parts: [NOTHING; PARTS], count: 0 };
        // A pause, or more parts than one transfer has, leaves the device selected between transfers.
        let most_parts = operations.len() * 2;
        let is_held = most_parts > PARTS || operations.iter().any(|it| matches!(it, Operation::DelayNs(_)));
        if is_held {
            transfer.spec = self.held;
        }
        let mut result = operations.iter_mut().try_for_each(|operation| transfer.take(operation));
        result = result.and_then(|()| transfer.flush());
        if is_held {
            // SAFETY: see above. It is not selected any longer in any case.
            let released = outcome(unsafe { raw::lf_spi_release(transfer.spec.raw()) }).map(drop);
            result = result.and(released);
        }
        result
    }
}

/// The maximum number of parts of a transfer.
const PARTS: usize = raw::LF_SPI_PARTS as usize;

const NOTHING: raw::lf_spi_part = raw::lf_spi_part { sent: null(), received: null_mut(), length: 0 };

/// Parts of a transaction that go to the driver together. The transaction borrows their buffers.
struct Transfer {
    spec: &'static Spec<raw::spi_dt_spec>,
    parts: [raw::lf_spi_part; PARTS],
    count: usize,
}

impl Transfer {
    fn take(&mut self, operation: &mut Operation<'_, u8>) -> Result<(), Problem> {
        match operation {
            Operation::Read(bytes) => self.part(null(), bytes.as_mut_ptr(), bytes.len()),
            Operation::Write(bytes) => self.part(bytes.as_ptr(), null_mut(), bytes.len()),
            Operation::Transfer(read, write) => {
                let both = read.len().min(write.len());
                let ((read, more_read), (write, more_written)) = (read.split_at_mut(both), write.split_at(both));
                self.part(write.as_ptr(), read.as_mut_ptr(), both)?;
                self.part(null(), more_read.as_mut_ptr(), more_read.len())?;
                self.part(more_written.as_ptr(), null_mut(), more_written.len())
            }
            Operation::TransferInPlace(bytes) => {
                let start = bytes.as_mut_ptr();
                self.part(start, start, bytes.len())
            }
            Operation::DelayNs(ns) => {
                self.flush()?;
                Delay.delay_ns(*ns);
                Ok(())
            }
        }
    }

    fn part(&mut self, sent: *const u8, received: *mut u8, length: usize) -> Result<(), Problem> {
        if length == 0 {
            return Ok(());
        }
        if self.count == PARTS {
            self.flush()?;
        }
        self.parts[self.count] = raw::lf_spi_part { sent, received, length };
        self.count += 1;
        Ok(())
    }

    fn flush(&mut self) -> Result<(), Problem> {
        let count = core::mem::take(&mut self.count);
        if count == 0 {
            return Ok(());
        }
        // SAFETY: the driver is ready, and the parts' buffers have these lengths until the transaction ends.
        outcome(unsafe { raw::lf_spi_transfer(self.spec.raw(), self.parts.as_ptr(), count) }).map(drop)
    }
}
