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

/// Delegates a call to the implementation.
macro_rules! either {
    ($backend:expr, $method:path $(, $argument:expr)*) => {
        match $backend {
            Self::Simulated(device) => $method(device $(, $argument)*),
            Self::Real(device) => $method(device $(, $argument)*),
        }
    };
}

impl<R: Device> Device for Backend<R> {
    fn name(&self) -> &'static str {
        either!(self, Device::name)
    }
}

impl<R: Pin<Watch = Watch>> Pin for Backend<R> {
    type Watch = Watch;

    fn is_active_low(&self) -> bool {
        either!(self, Pin::is_active_low)
    }

    fn configure_output(&self, active: bool) -> Result<(), Problem> {
        either!(self, Pin::configure_output, active)
    }

    fn configure_input(&self) -> Result<(), Problem> {
        either!(self, Pin::configure_input)
    }

    fn set(&self, active: bool) -> Result<(), Problem> {
        either!(self, Pin::set, active)
    }

    fn is_active(&self) -> Result<bool, Problem> {
        either!(self, Pin::is_active)
    }

    fn watch(&self, edge: Edge, link: PhysicalLink, poster: EventPoster) -> Result<Watch, Problem> {
        either!(self, Pin::watch, edge, link, poster)
    }
}

impl<R: PwmChannel> PwmChannel for Backend<R> {
    fn is_ready(&self) -> Result<(), Problem> {
        either!(self, PwmChannel::is_ready)
    }

    fn period(&self) -> u32 {
        either!(self, PwmChannel::period)
    }

    fn set_pulse(&self, nanoseconds: u32) -> Result<(), Problem> {
        either!(self, PwmChannel::set_pulse, nanoseconds)
    }
}

impl<R: AnalogInput> AnalogInput for Backend<R> {
    fn configure(&self) -> Result<(), Problem> {
        either!(self, AnalogInput::configure)
    }

    fn sample(&self) -> Result<i32, Problem> {
        either!(self, AnalogInput::sample)
    }

    fn millivolts(&self, sample: i32) -> Result<i32, Problem> {
        either!(self, AnalogInput::millivolts, sample)
    }
}

impl<R: I2cBus> I2cBus for Backend<R> {
    fn is_ready(&self) -> Result<(), Problem> {
        either!(self, I2cBus::is_ready)
    }

    fn address(&self) -> Option<u8> {
        either!(self, I2cBus::address)
    }

    fn transaction(&self, address: u8, operations: &mut [i2c::Operation<'_>]) -> Result<(), Problem> {
        either!(self, I2cBus::transaction, address, operations)
    }
}

impl<R: SpiTarget> SpiTarget for Backend<R> {
    fn is_ready(&self) -> Result<(), Problem> {
        either!(self, SpiTarget::is_ready)
    }

    fn transaction(&self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), Problem> {
        either!(self, SpiTarget::transaction, operations)
    }
}

impl<R: SerialLine<Watch = Watch>> SerialLine for Backend<R> {
    type Watch = Watch;

    fn is_ready(&self) -> Result<(), Problem> {
        either!(self, SerialLine::is_ready)
    }

    fn send(&self, bytes: &[u8]) -> Result<(), Problem> {
        either!(self, SerialLine::send, bytes)
    }

    fn receive(&self) -> Result<Option<u8>, Problem> {
        either!(self, SerialLine::receive)
    }

    fn pause(&self) {
        either!(self, SerialLine::pause);
    }

    fn watch(&self, link: PhysicalLink, poster: EventPoster) -> Result<Watch, Problem> {
        either!(self, SerialLine::watch, link, poster)
    }
}

impl<R: SensorDevice<Watch = Watch>> SensorDevice for Backend<R> {
    type Watch = Watch;

    fn is_ready(&self) -> Result<(), Problem> {
        either!(self, SensorDevice::is_ready)
    }

    fn fetch(&self) -> Result<(), Problem> {
        either!(self, SensorDevice::fetch)
    }

    fn value(&self, channel: Channel) -> Result<SensorValue, Problem> {
        either!(self, SensorDevice::value, channel)
    }

    fn watch(&self, link: PhysicalLink, poster: EventPoster) -> Result<Watch, Problem> {
        either!(self, SensorDevice::watch, link, poster)
    }
}
