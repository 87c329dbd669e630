// SPDX-License-Identifier: Apache-2.0
//! Channels of analog-to-digital converters by Zephyr's drivers.

use lf_devices::{AnalogInput, Device, DeviceError, Problem};

use super::sensor::{Sensor, SensorNode};
use super::spec::{Spec, outcome};
use crate::raw;

/// A voltage input: see [`lf_devices::Adc`].
pub type Adc = lf_devices::Adc<AdcNode>;

/// A channel of a converter of the devicetree, which has not been set up yet.
#[derive(Clone, Copy, Debug)]
pub struct AdcNode {
    name: &'static str,
    spec: &'static Spec<raw::adc_dt_spec>,
    device: &'static Spec<*const raw::device>,
}

impl AdcNode {
    pub(crate) const fn new(
        name: &'static str,
        spec: &'static Spec<raw::adc_dt_spec>,
        device: &'static Spec<*const raw::device>,
    ) -> Self {
        Self { name, spec, device }
    }

    /// Sets it up.
    ///
    /// # Errors
    /// When its driver is missing, is not ready or refuses.
    pub fn adc(self) -> Result<Adc, DeviceError> {
        Adc::new(self)
    }

    /// Returns the sensor that measures by it, such as a voltage divider.
    ///
    /// # Errors
    /// When it is not one, or its driver is missing or not ready.
    pub fn sensor(self) -> Result<Sensor, DeviceError> {
        SensorNode::new(self.name, self.device).sensor()
    }

    fn raw(&self) -> *const raw::adc_dt_spec {
        self.spec.raw()
    }
}

impl Device for AdcNode {
    fn name(&self) -> &'static str {
        self.name
    }
}

impl AnalogInput for AdcNode {
    fn configure(&self) -> Result<(), Problem> {
        // SAFETY: the channel is a constant of C; so it is in all calls here.
        outcome(unsafe { raw::lf_adc_configure(self.raw()) }).map(drop)
    }

    fn sample(&self) -> Result<i32, Problem> {
        let mut sample = 0;
        // SAFETY: see above; the channel was set up, and the target of the write exists.
        outcome(unsafe { raw::lf_adc_sample(self.raw(), &raw mut sample) }).map(|_| sample)
    }

    fn millivolts(&self, mut sample: i32) -> Result<i32, Problem> {
        // SAFETY: see above.
        outcome(unsafe { raw::lf_adc_to_millivolts(self.raw(), &raw mut sample) }).map(|_| sample)
    }
}
