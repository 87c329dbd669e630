// SPDX-License-Identifier: Apache-2.0
//! I²C buses by Zephyr's drivers.

use lf_devices::embedded_hal::i2c::Operation;
use lf_devices::{Device, DeviceError, I2cBus, Problem};

use super::sensor::{Sensor, SensorNode};
use super::spec::{Spec, outcome};
use crate::raw;

/// The maximum number of operations of a transaction; driver crates have two or three.
const OPERATIONS: usize = raw::LF_I2C_MESSAGES as usize;

/// An I²C bus: see [`lf_devices::I2c`].
pub type I2c = lf_devices::I2c<I2cNode>;

/// An I²C bus of the devicetree, or a device on one.
#[derive(Clone, Copy, Debug)]
pub struct I2cNode {
    name: &'static str,
    spec: &'static Spec<raw::i2c_dt_spec>,
    device: &'static Spec<*const raw::device>,
}

impl I2cNode {
    pub(crate) const fn new(
        name: &'static str,
        spec: &'static Spec<raw::i2c_dt_spec>,
        device: &'static Spec<*const raw::device>,
    ) -> Self {
        Self { name, spec, device }
    }

    /// Opens the bus.
    ///
    /// # Errors
    /// When its driver is missing or is not ready.
    pub fn i2c(self) -> Result<I2c, DeviceError> {
        I2c::new(self)
    }

    /// Returns the device as a sensor, if Zephyr has such a driver for it.
    ///
    /// # Errors
    /// When its driver is missing, is not ready or not one of a sensor.
    pub fn sensor(self) -> Result<Sensor, DeviceError> {
        SensorNode::new(self.name, self.device).sensor()
    }

    fn raw(&self) -> *const raw::i2c_dt_spec {
        self.spec.raw()
    }
}

impl Device for I2cNode {
    fn name(&self) -> &'static str {
        self.name
    }
}

impl I2cBus for I2cNode {
    fn is_ready(&self) -> Result<(), Problem> {
        // SAFETY: its specification is a constant of C; so it is in all calls here.
        outcome(unsafe { raw::lf_i2c_ready(self.raw()) }).map(drop)
    }

    fn address(&self) -> Option<u8> {
        // SAFETY: see above.
        u8::try_from(unsafe { raw::lf_i2c_address(self.raw()) }).ok()
    }

    fn transaction(&self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Problem> {
        let mut messages = [raw::lf_i2c_message::default(); OPERATIONS];
        let count = operations.len();
        // C refuses a longer transaction, and does not read the messages then.
        for (message, operation) in messages.iter_mut().zip(operations) {
            let (bytes, length, read) = match operation {
                Operation::Read(bytes) => (bytes.as_mut_ptr(), bytes.len(), true),
                // Drivers only read the bytes of a write.
                Operation::Write(bytes) => (bytes.as_ptr().cast_mut(), bytes.len(), false),
            };
            *message = raw::lf_i2c_message { bytes, length, read };
        }
        // SAFETY: its driver is ready, and the first messages have these lengths until the call returns.
        outcome(unsafe { raw::lf_i2c_transfer(self.raw(), address, messages.as_ptr(), count) }).map(drop)
    }
}
