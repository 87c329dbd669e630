// SPDX-License-Identifier: Apache-2.0
//! Voltage inputs.

use crate::error::{Device, DeviceError, Problem};

/// The platform's interface of a channel of an analog-to-digital converter.
pub trait AnalogInput: Device {
    /// Sets it up.
    ///
    /// # Errors
    /// When its driver is missing, could not start or refuses.
    fn configure(&self) -> Result<(), Problem>;
    /// Measures now, and waits for it.
    ///
    /// # Errors
    /// When its driver reports one.
    fn sample(&self) -> Result<i32, Problem>;
    /// Converts a sample to millivolts.
    ///
    /// # Errors
    /// When the driver does not know its reference voltage.
    fn millivolts(&self, sample: i32) -> Result<i32, Problem>;
}

/// A channel of an analog-to-digital converter, with the gain, reference and resolution of the devicetree.
#[derive(Debug)]
pub struct Adc<A> {
    input: A,
}

impl<A: AnalogInput> Adc<A> {
    /// Sets the channel up.
    ///
    /// # Errors
    /// When its driver is missing, could not start or refuses.
    pub fn new(input: A) -> Result<Self, DeviceError> {
        input.named(input.configure())?;
        Ok(Self { input })
    }

    /// Measures now, and waits for the result; in the converter's unit.
    ///
    /// # Errors
    /// When its driver reports one.
    pub fn read(&mut self) -> Result<i32, DeviceError> {
        self.input.named(self.input.sample())
    }

    /// Measures now, in millivolts.
    ///
    /// # Errors
    /// When its driver reports one, or does not know its reference voltage.
    pub fn read_millivolts(&mut self) -> Result<i32, DeviceError> {
        let sample = self.read()?;
        self.input.named(self.input.millivolts(sample))
    }
}
