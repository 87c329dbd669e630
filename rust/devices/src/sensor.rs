// SPDX-License-Identifier: Apache-2.0
//! Sensors that the platform has a driver for.

use core::fmt;

use lf_model::{PhysicalActionRef, PhysicalLink, ReactionContext};

use crate::error::{Device, DeviceError, Problem};
use crate::interrupt::{self, EventPoster, EventValue};

/// Passes all channels to a macro: of each the name in Rust, the one in C, the one in scripts, and its description.
#[doc(hidden)]
#[macro_export]
macro_rules! sensor_channels {
    ($then:ident) => {
        $then! {
            AccelX SENSOR_CHAN_ACCEL_X "accel_x" "Acceleration along x, in m/s².",
            AccelY SENSOR_CHAN_ACCEL_Y "accel_y" "Acceleration along y, in m/s².",
            AccelZ SENSOR_CHAN_ACCEL_Z "accel_z" "Acceleration along z, in m/s².",
            GyroX SENSOR_CHAN_GYRO_X "gyro_x" "Rotation about x, in radians/s.",
            GyroY SENSOR_CHAN_GYRO_Y "gyro_y" "Rotation about y, in radians/s.",
            GyroZ SENSOR_CHAN_GYRO_Z "gyro_z" "Rotation about z, in radians/s.",
            MagnX SENSOR_CHAN_MAGN_X "magn_x" "Magnetic field along x, in gauss.",
            MagnY SENSOR_CHAN_MAGN_Y "magn_y" "Magnetic field along y, in gauss.",
            MagnZ SENSOR_CHAN_MAGN_Z "magn_z" "Magnetic field along z, in gauss.",
            DieTemp SENSOR_CHAN_DIE_TEMP "die_temp" "The chip's own temperature, in °C.",
            AmbientTemp SENSOR_CHAN_AMBIENT_TEMP "ambient_temp" "Temperature, in °C.",
            Press SENSOR_CHAN_PRESS "press" "Pressure, in kPa.",
            Prox SENSOR_CHAN_PROX "prox" "Whether something is near: 1 or 0.",
            Humidity SENSOR_CHAN_HUMIDITY "humidity" "Relative humidity, in percent.",
            Light SENSOR_CHAN_LIGHT "light" "Visible light, in lux.",
            Ir SENSOR_CHAN_IR "ir" "Infrared light, in lux.",
            Red SENSOR_CHAN_RED "red" "Red light, in lux.",
            Green SENSOR_CHAN_GREEN "green" "Green light, in lux.",
            Blue SENSOR_CHAN_BLUE "blue" "Blue light, in lux.",
            Altitude SENSOR_CHAN_ALTITUDE "altitude" "Altitude, in m.",
            Pm1 SENSOR_CHAN_PM_1_0 "pm_1_0" "Particles up to 1 µm, in µg/m³.",
            Pm2 SENSOR_CHAN_PM_2_5 "pm_2_5" "Particles up to 2.5 µm, in µg/m³.",
            Pm10 SENSOR_CHAN_PM_10 "pm_10" "Particles up to 10 µm, in µg/m³.",
            Distance SENSOR_CHAN_DISTANCE "distance" "Distance, in m.",
            Co2 SENSOR_CHAN_CO2 "co2" "Carbon dioxide, in parts per million.",
            O2 SENSOR_CHAN_O2 "o2" "Oxygen, in parts per million.",
            Voc SENSOR_CHAN_VOC "voc" "Volatile organic compounds, in parts per billion.",
            GasRes SENSOR_CHAN_GAS_RES "gas_res" "Resistance of a gas sensor, in ohm.",
            FlowRate SENSOR_CHAN_FLOW_RATE "flow_rate" "Flow, in litres per minute.",
            Voltage SENSOR_CHAN_VOLTAGE "voltage" "Voltage, in V.",
            Current SENSOR_CHAN_CURRENT "current" "Current, in A.",
            Power SENSOR_CHAN_POWER "power" "Power, in W.",
            Resistance SENSOR_CHAN_RESISTANCE "resistance" "Resistance, in ohm.",
            Rotation SENSOR_CHAN_ROTATION "rotation" "Angle, in degrees.",
            Rpm SENSOR_CHAN_RPM "rpm" "Speed, in revolutions per minute.",
            Frequency SENSOR_CHAN_FREQUENCY "frequency" "Frequency, in Hz.",
            GaugeVoltage SENSOR_CHAN_GAUGE_VOLTAGE "gauge_voltage" "Voltage of a battery, in V.",
            GaugeTemp SENSOR_CHAN_GAUGE_TEMP "gauge_temp" "Temperature of a battery, in °C.",
            GaugeStateOfCharge SENSOR_CHAN_GAUGE_STATE_OF_CHARGE "gauge_state_of_charge"
                "State of charge of a battery, in percent.",
        }
    };
}

macro_rules! define_channels {
    ($($name:ident $c:ident $script:literal $what:literal,)*) => {
        /// A quantity that a sensor measures, in the units of Zephyr's sensor API.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum Channel {
            $(#[doc = $what] $name,)*
        }

        impl Channel {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$name,)*];

            /// Returns its name in scripts, and in C after `SENSOR_CHAN_`, there in capitals.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$name => $script,)*
                }
            }
        }
    };
}

sensor_channels!(define_channels);

/// A measurement, in millionths of its channel's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct SensorValue {
    micro: i64,
}

impl SensorValue {
    /// Returns a value of this many millionths.
    pub const fn from_micro(micro: i64) -> Self {
        Self { micro }
    }

    /// Returns it in millionths of the unit.
    pub const fn as_micro(self) -> i64 {
        self.micro
    }

    /// Returns it in thousandths of the unit, rounded toward zero.
    pub const fn as_milli(self) -> i64 {
        self.micro / 1000
    }

    /// Returns it in the unit.
    #[expect(clippy::cast_precision_loss, reason = "a sensor measures less than 53 bits of millionths")]
    pub const fn as_f64(self) -> f64 {
        self.micro as f64 / 1e6
    }
}

impl fmt::Display for SensorValue {
    /// Writes six decimals, or the requested number, rounded toward zero.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.micro < 0 { "-" } else { "" };
        let (whole, mut part) = (self.micro.unsigned_abs() / 1_000_000, self.micro.unsigned_abs() % 1_000_000);
        let decimals = f.precision().unwrap_or(6).min(6);
        for _ in decimals..6 {
            part /= 10;
        }
        match decimals {
            0 => write!(f, "{sign}{whole}"),
            _ => write!(f, "{sign}{whole}.{part:0decimals$}"),
        }
    }
}

/// The platform's interface of a sensor.
pub trait SensorDevice: Device {
    /// A value that ends the interrupts of a sensor when it is dropped.
    type Watch: fmt::Debug;

    /// Checks that it can be used.
    ///
    /// # Errors
    /// When its driver is missing, could not start, or is not one of a sensor.
    fn is_ready(&self) -> Result<(), Problem>;
    /// Measures now.
    ///
    /// # Errors
    /// When its driver reports one.
    fn fetch(&self) -> Result<(), Problem>;
    /// Returns the last measurement of a channel.
    ///
    /// # Errors
    /// When it does not measure this.
    fn value(&self, channel: Channel) -> Result<SensorValue, Problem>;
    /// Posts each time a sample is ready, until the result is dropped, which also keeps the link. Posts without room
    /// are counted and logged.
    ///
    /// # Errors
    /// When its driver cannot do it, or there is no room for another watch.
    fn watch(&self, link: PhysicalLink, poster: EventPoster) -> Result<Self::Watch, Problem>;
}

/// A sensor that the platform has a driver for.
#[derive(Debug)]
pub struct Sensor<D: SensorDevice> {
    device: D,
    watch: Option<D::Watch>,
}

impl<D: SensorDevice> Sensor<D> {
    /// Opens the sensor.
    ///
    /// # Errors
    /// When its driver is missing, could not start, or is not one of a sensor.
    pub fn new(device: D) -> Result<Self, DeviceError> {
        device.named(device.is_ready())?;
        Ok(Self { device, watch: None })
    }

    /// Measures now, on all its channels, and waits for the result.
    ///
    /// # Errors
    /// When its driver reports one.
    pub fn fetch(&mut self) -> Result<(), DeviceError> {
        self.device.named(self.device.fetch())
    }

    /// Returns the result of the last [`fetch`](Self::fetch).
    ///
    /// # Errors
    /// When it does not measure this.
    pub fn value(&self, channel: Channel) -> Result<SensorValue, DeviceError> {
        self.device.named(self.device.value(channel))
    }

    /// Measures now, and returns one channel's value.
    ///
    /// # Errors
    /// When its driver reports one, or it does not measure this.
    pub fn read(&mut self, channel: Channel) -> Result<SensorValue, DeviceError> {
        self.fetch()?;
        self.value(channel)
    }

    /// Schedules the action for each ready sample from now on; its reaction fetches the sample.
    ///
    /// # Errors
    /// When the driver cannot do it, or there is no room for another device with interrupts.
    pub fn on_sample<T: EventValue<()>>(
        &mut self,
        ctx: &ReactionContext<'_>,
        action: &PhysicalActionRef<T>,
    ) -> Result<(), DeviceError> {
        interrupt::begin(&mut self.watch, ctx, action, |link, poster| {
            self.device.named(self.device.watch(link, poster))
        })
    }

    /// Stops scheduling at samples.
    pub fn ignore_samples(&mut self) {
        self.watch = None;
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::format;

    use super::*;

    #[test]
    fn a_value_is_shown_in_its_unit() {
        let value = SensorValue::from_micro(-21_062_500);
        assert_eq!(format!("{value} {value:.1} {value:.0}"), "-21.062500 -21.0 -21");
        assert_eq!((value.as_milli(), value.as_f64()), (-21_062, -21.0625));
        assert_eq!(format!("{:.2}", SensorValue::from_micro(-50_000)), "-0.05");
    }

    #[test]
    fn names_of_channels_are_unique() {
        for (index, channel) in Channel::ALL.iter().enumerate() {
            assert!(Channel::ALL[..index].iter().all(|before| before.name() != channel.name()));
        }
    }
}
