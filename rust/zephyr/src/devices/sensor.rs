// SPDX-License-Identifier: Apache-2.0
//! Sensors by Zephyr's drivers.

use lf_devices::{Channel, Device, DeviceError, EventPoster, Problem, SensorDevice, SensorValue};
use lf_model::PhysicalLink;

use super::spec::Spec;
use crate::raw;

/// A sensor: see [`lf_devices::Sensor`].
pub type Sensor = lf_devices::Sensor<SensorNode>;

/// A device of the devicetree that may be a sensor.
#[derive(Clone, Copy, Debug)]
pub struct SensorNode {
    name: &'static str,
    device: &'static Spec<*const raw::device>,
}

impl SensorNode {
    pub(crate) const fn new(name: &'static str, device: &'static Spec<*const raw::device>) -> Self {
        Self { name, device }
    }

    /// Opens the sensor.
    ///
    /// # Errors
    /// When it is not one, or its driver is missing or not ready.
    pub fn sensor(self) -> Result<Sensor, DeviceError> {
        Sensor::new(self)
    }
}

impl Device for SensorNode {
    fn name(&self) -> &'static str {
        self.name
    }
}

#[cfg(CONFIG_SENSOR)]
mod driver {
    use core::ffi::c_int;

    use super::super::interrupts::{Source, Watch};
    use super::super::spec::outcome;
    #[allow(clippy::wildcard_imports)]
    use super::*;

    macro_rules! define_number {
        ($($name:ident $c:ident $script:literal $what:literal,)*) => {
            /// Returns C's number of a channel.
            fn number(channel: Channel) -> Result<c_int, Problem> {
                let number = match channel {
                    $(Channel::$name => raw::sensor_channel::$c,)*
                    _ => return Err(Problem::NotSupported),
                };
                c_int::try_from(number).map_err(|_| Problem::NotSupported)
            }
        };
    }

    lf_devices::sensor_channels!(define_number);

    impl SensorDevice for SensorNode {
        type Watch = Watch<Samples>;

        fn is_ready(&self) -> Result<(), Problem> {
            // SAFETY: it has no precondition.
            outcome(unsafe { raw::lf_sensor_ready(self.device.device()) }).map(drop)
        }

        fn fetch(&self) -> Result<(), Problem> {
            // SAFETY: it is a sensor whose driver is ready; so it is in all calls here.
            outcome(unsafe { raw::lf_sensor_fetch(self.device.device()) }).map(drop)
        }

        fn value(&self, channel: Channel) -> Result<SensorValue, Problem> {
            let mut micro = 0;
            // SAFETY: see above; the target of the write exists.
            outcome(unsafe { raw::lf_sensor_value(self.device.device(), number(channel)?, &raw mut micro) })?;
            Ok(SensorValue::from_micro(micro))
        }

        fn watch(&self, link: PhysicalLink, poster: EventPoster) -> Result<Self::Watch, Problem> {
            Watch::new(self.name, Samples(self.device), link, poster)
        }
    }

    /// The samples of a sensor.
    #[derive(Debug)]
    pub struct Samples(&'static Spec<*const raw::device>);

    impl Source for Samples {
        fn begin(&self, slot: usize, handler: raw::lf_device_handler) -> c_int {
            // SAFETY: the slot is below CONFIG_LF_INTERRUPTS and was free, and the handler can be called at any time.
            unsafe { raw::lf_sensor_watch(slot, self.0.device(), handler) }
        }

        fn end(&self, slot: usize) {
            // SAFETY: this slot is watched.
            unsafe { raw::lf_sensor_unwatch(slot, self.0.device()) };
        }
    }
}

#[cfg(not(CONFIG_SENSOR))]
impl SensorDevice for SensorNode {
    type Watch = core::convert::Infallible;

    fn is_ready(&self) -> Result<(), Problem> {
        Err(Problem::NoDriver)
    }

    fn fetch(&self) -> Result<(), Problem> {
        Err(Problem::NoDriver)
    }

    fn value(&self, _: Channel) -> Result<SensorValue, Problem> {
        Err(Problem::NoDriver)
    }

    fn watch(&self, _: PhysicalLink, _: EventPoster) -> Result<Self::Watch, Problem> {
        Err(Problem::NoDriver)
    }
}
