// SPDX-License-Identifier: Apache-2.0
//! A device that is simulated, or a real one.

use lf_devices::embedded_hal::{i2c, spi};
use lf_devices::{
    AnalogInput, Channel, Device, Edge, EventPoster, I2cBus, Pin, Problem, PwmChannel, SensorDevice, SensorValue,
    SerialLine, SpiTarget,
};
use lf_model::PhysicalLink;

use super::simulated::Simulated;
use super::watch::Watch;

/// The implementation of a device of a program.
#[derive(Debug)]
pub enum Backend<R> {
    /// The script determines its values.
    Simulated(Simulated),
    /// The script names a device of this computer.
    Real(R),
}

/// Delegates the methods of a trait to the implementation.
macro_rules! delegate {
    ($trait:ident $(<Watch = $watch:ty>)? {
        $(fn $name:ident(&self $(, $argument:ident: $type:ty)*) $(-> $returned:ty)?;)+
    }) => {
        impl<R: $trait $(<Watch = $watch>)?> $trait for Backend<R> {
            $(type Watch = $watch;)?
            $(fn $name(&self $(, $argument: $type)*) $(-> $returned)? {
                match self {
                    Self::Simulated(device) => $trait::$name(device $(, $argument)*),
                    Self::Real(device) => $trait::$name(device $(, $argument)*),
                }
            })+
        }
    };
}

delegate!(Device {
    fn name(&self) -> &'static str;
});
delegate!(
    Pin < Watch = Watch > {
        fn is_active_low(&self) -> bool;
        fn configure_output(&self, active: bool) -> Result<(), Problem>;
        fn configure_input(&self) -> Result<(), Problem>;
        fn set(&self, active: bool) -> Result<(), Problem>;
        fn is_active(&self) -> Result<bool, Problem>;
        fn watch(&self, edge: Edge, link: PhysicalLink, poster: EventPoster) -> Result<Watch, Problem>;
    }
);
delegate!(PwmChannel {
    fn is_ready(&self) -> Result<(), Problem>;
    fn period(&self) -> u32;
    fn set_pulse(&self, nanoseconds: u32) -> Result<(), Problem>;
});
delegate!(AnalogInput {
    fn configure(&self) -> Result<(), Problem>;
    fn sample(&self) -> Result<i32, Problem>;
    fn millivolts(&self, sample: i32) -> Result<i32, Problem>;
});
delegate!(I2cBus {
    fn is_ready(&self) -> Result<(), Problem>;
    fn address(&self) -> Option<u8>;
    fn transaction(&self, address: u8, operations: &mut [i2c::Operation<'_>]) -> Result<(), Problem>;
});
delegate!(SpiTarget {
    fn is_ready(&self) -> Result<(), Problem>;
    fn transaction(&self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), Problem>;
});
delegate!(
    SerialLine < Watch = Watch > {
        fn is_ready(&self) -> Result<(), Problem>;
        fn send(&self, bytes: &[u8]) -> Result<(), Problem>;
        fn receive(&self) -> Result<Option<u8>, Problem>;
        fn pause(&self);
        fn watch(&self, link: PhysicalLink, poster: EventPoster) -> Result<Watch, Problem>;
    }
);
delegate!(
    SensorDevice < Watch = Watch > {
        fn is_ready(&self) -> Result<(), Problem>;
        fn fetch(&self) -> Result<(), Problem>;
        fn value(&self, channel: Channel) -> Result<SensorValue, Problem>;
        fn watch(&self, link: PhysicalLink, poster: EventPoster) -> Result<Watch, Problem>;
    }
);
