// SPDX-License-Identifier: Apache-2.0
//! Measurements of kernel drivers: channels of Industrial I/O (IIO) and of hardware monitors, by sysfs.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use lf_devices::{AnalogInput, Channel, Device, EventPoster, Problem, SensorDevice, SensorValue};
use lf_model::PhysicalLink;

use super::super::binding::{Bound, Kind};
use super::super::recording::Signal;
use super::super::simulation::Simulation;
use super::super::watch::Watch;
use super::sysfs::{number, optional_number};
use super::{Advice, DeviceRef, failed};

const OF_ADC: Advice = Advice {
    missing: "which is not there, or has no such channel: `ls /sys/bus/iio/devices/*/in_*_raw` lists them",
    denied: "which this user may not read",
    busy: "whose channels another program reads continuously",
    other: "but the program uses it as an analog input: write iio, the folder of its device and a channel, such as \
            voltage1",
};
const OF_SENSOR: Advice = Advice {
    missing: "which is not there, or has no channel that is known here: `ls` of this folder lists what it has",
    denied: "which this user may not read",
    busy: "whose channels another program reads continuously",
    other: "but the program uses it as a sensor: write iio or hwmon, and the folder of its device",
};

/// IIO's name of a channel, and the factor from IIO's unit to millionths of the channel's unit.
const IIO: &[(Channel, &str, f64)] = &[
    (Channel::AccelX, "accel_x", 1e6),
    (Channel::AccelY, "accel_y", 1e6),
    (Channel::AccelZ, "accel_z", 1e6),
    (Channel::GyroX, "anglvel_x", 1e6),
    (Channel::GyroY, "anglvel_y", 1e6),
    (Channel::GyroZ, "anglvel_z", 1e6),
    (Channel::MagnX, "magn_x", 1e6),
    (Channel::MagnY, "magn_y", 1e6),
    (Channel::MagnZ, "magn_z", 1e6),
    // IIO does not distinguish the temperature of a chip from that around it.
    (Channel::AmbientTemp, "temp", 1e3),
    (Channel::DieTemp, "temp", 1e3),
    (Channel::Press, "pressure", 1e6),
    (Channel::Humidity, "humidityrelative", 1e3),
    (Channel::Light, "illuminance", 1e6),
    (Channel::Distance, "distance", 1e6),
    (Channel::Distance, "proximity", 1e6),
    // Percent of the air.
    (Channel::Co2, "concentration_co2", 1e10),
    (Channel::O2, "concentration_o2", 1e10),
    (Channel::Resistance, "resistance", 1e6),
    (Channel::Voltage, "voltage0", 1e3),
    (Channel::Current, "current0", 1e3),
    (Channel::Power, "power0", 1e3),
];
/// The same for hardware monitors.
const HWMON: &[(Channel, &str, f64)] = &[
    (Channel::AmbientTemp, "temp1", 1e3),
    (Channel::DieTemp, "temp1", 1e3),
    (Channel::Humidity, "humidity1", 1e3),
    (Channel::Voltage, "in0", 1e3),
    (Channel::Voltage, "in1", 1e3),
    (Channel::Current, "curr1", 1e3),
    (Channel::Power, "power1", 1.0),
    (Channel::Rpm, "fan1", 1e6),
];

/// The files of a channel, and the conversion of their numbers to its unit.
#[derive(Clone, Debug, PartialEq)]
struct Source {
    file: PathBuf,
    offset: f64,
    scale: f64,
}

impl Source {
    /// Finds a channel of IIO: the value that its driver has converted, or the raw value and its conversion. A file
    /// without number or axis may apply to several channels.
    fn of_iio(folder: &Path, channel: &str) -> io::Result<Option<Self>> {
        let file = |name: &str, what: &str| folder.join(format!("in_{name}_{what}"));
        if file(channel, "input").exists() {
            return Ok(Some(Self { file: file(channel, "input"), offset: 0.0, scale: 1.0 }));
        }
        if !file(channel, "raw").exists() {
            return Ok(None);
        }
        let common = channel.split('_').next().unwrap_or(channel).trim_end_matches(|last: char| last.is_ascii_digit());
        let factor = |what| {
            let own = optional_number(&file(channel, what)).transpose();
            own.or_else(|| optional_number(&file(common, what)).transpose()).transpose()
        };
        let (offset, scale) = (factor("offset")?.unwrap_or(0.0), factor("scale")?.unwrap_or(1.0));
        Ok(Some(Self { file: file(channel, "raw"), offset, scale }))
    }

    fn convert(&self, raw: f64) -> f64 {
        (raw + self.offset) * self.scale
    }

    /// Measures now, in the unit times this factor, rounded.
    fn read(&self, factor: f64) -> io::Result<i64> {
        #[expect(clippy::cast_possible_truncation, reason = "what is measured is much smaller, and the cast saturates")]
        number(&self.file).map(|raw| (self.convert(raw) * factor).round() as i64)
    }
}

/// A channel of an analog-to-digital converter.
#[derive(Debug)]
pub struct KernelAdc {
    place: DeviceRef,
    source: Source,
}

impl KernelAdc {
    /// Opens the channel of a line of the script.
    pub(in super::super) fn open(name: &'static str, bound: &'static Bound) -> Result<Self, Problem> {
        let place = DeviceRef::of(name, bound, &OF_ADC);
        let Kind::Iio { channel: Some(channel) } = &bound.binding.kind else { return Err(place.is_other()) };
        let source = Source::of_iio(Path::new(place.path), channel);
        let source = source.and_then(|source| source.ok_or_else(|| io::ErrorKind::NotFound.into()));
        Ok(Self { place, source: source.map_err(|error| place.refuses(&error))? })
    }
}

impl Device for KernelAdc {
    fn name(&self) -> &'static str {
        self.place.name
    }
}

impl AnalogInput for KernelAdc {
    fn configure(&self) -> Result<(), Problem> {
        self.sample().map(drop)
    }

    fn sample(&self) -> Result<i32, Problem> {
        let raw = number(&self.source.file).map_err(|error| failed(&error))?;
        // The unit of IIO's voltages is mV.
        Simulation::of_program().drives(self.place.name, Signal::Real(self.source.convert(raw)));
        #[expect(clippy::cast_possible_truncation, reason = "converters have fewer bits, and the cast saturates")]
        Ok(raw.round() as i32)
    }

    fn millivolts(&self, sample: i32) -> Result<i32, Problem> {
        #[expect(clippy::cast_possible_truncation, reason = "no voltage is as high, and the cast saturates")]
        Ok(self.source.convert(sample.into()).round() as i32)
    }
}

/// A sensor that the kernel has a driver for.
#[derive(Debug)]
pub struct KernelSensor {
    place: DeviceRef,
    channels: BTreeMap<Channel, (Source, f64)>,
    measured: Mutex<BTreeMap<Channel, SensorValue>>,
}

impl KernelSensor {
    /// Opens the sensor of a line of the script.
    pub(in super::super) fn open(name: &'static str, bound: &'static Bound) -> Result<Self, Problem> {
        let place = DeviceRef::of(name, bound, &OF_SENSOR);
        let folder = Path::new(place.path);
        let channels = match bound.binding.kind {
            Kind::Iio { channel: None } => channels(IIO, |channel| Source::of_iio(folder, channel)),
            Kind::Hwmon => channels(HWMON, |channel| {
                let file = folder.join(format!("{channel}_input"));
                Ok(file.exists().then_some(Source { file, offset: 0.0, scale: 1.0 }))
            }),
            _ => return Err(place.is_other()),
        };
        let channels = channels.map_err(|error| place.refuses(&error))?;
        if channels.is_empty() {
            return Err(place.problem(OF_SENSOR.missing, 0));
        }
        Ok(Self { place, channels, measured: Mutex::default() })
    }
}

/// Returns the channels that exist.
fn channels(
    known: &[(Channel, &str, f64)],
    find: impl Fn(&str) -> io::Result<Option<Source>>,
) -> io::Result<BTreeMap<Channel, (Source, f64)>> {
    let mut found = BTreeMap::new();
    for (channel, name, factor) in known {
        if let Some(source) = find(name)? {
            found.entry(*channel).or_insert((source, *factor));
        }
    }
    Ok(found)
}

impl Device for KernelSensor {
    fn name(&self) -> &'static str {
        self.place.name
    }
}

impl SensorDevice for KernelSensor {
    type Watch = Watch;

    fn is_ready(&self) -> Result<(), Problem> {
        Ok(())
    }

    fn fetch(&self) -> Result<(), Problem> {
        let read = |(channel, (source, factor)): (&Channel, &(Source, f64))| {
            source.read(*factor).map(|micro| (*channel, SensorValue::from_micro(micro)))
        };
        let values = self.channels.iter().map(read).collect::<io::Result<_>>().map_err(|error| failed(&error))?;
        *self.measured.lock().unwrap_or_else(PoisonError::into_inner) = values;
        Ok(())
    }

    fn value(&self, channel: Channel) -> Result<SensorValue, Problem> {
        if !self.channels.contains_key(&channel) {
            return Err(Problem::NotSupported);
        }
        let measured = self.measured.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(measured.get(&channel).copied().unwrap_or_default())
    }

    fn watch(&self, _: PhysicalLink, _: EventPoster) -> Result<Watch, Problem> {
        // Sysfs has no event for a new sample.
        Err(Problem::NotSupported)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::tests::{bound, refused};
    use super::*;

    /// Makes a folder that looks like that of a device in sysfs, and a line of a script that names it.
    fn device(files: &[(&str, &str)], kind: &str, channel: &str) -> (tempfile::TempDir, String) {
        let folder = tempfile::tempdir().expect("there is room");
        for (file, content) in files {
            fs::write(folder.path().join(file), format!("{content}\n")).expect("there is room");
        }
        let line = format!("x {kind} {} {channel}", folder.path().display());
        (folder, line)
    }

    #[test]
    fn a_voltage_has_the_scale_of_its_channel_or_of_all() {
        let files = [("in_voltage1_raw", "1000"), ("in_voltage_scale", "0.805664062"), ("in_voltage2_raw", "-20")];
        let (folder, line) = device(&files, "iio", "voltage1");
        let adc = KernelAdc::open("x", bound(&line)).expect("it is there");
        let sample = adc.sample().expect("it can be read");
        assert_eq!((sample, adc.millivolts(sample)), (1000, Ok(806)));
        for (file, content) in [("in_voltage2_scale", "0.5"), ("in_voltage2_offset", "100")] {
            fs::write(folder.path().join(file), content).expect("there is room");
        }
        let adc = KernelAdc::open("x", bound(&line.replace("voltage1", "voltage2"))).expect("it is there");
        assert_eq!((adc.sample(), adc.millivolts(-20)), (Ok(-20), Ok(40)));
        let told = refused(KernelAdc::open, |_| Ok(()), &line.replace("voltage1", "voltage3"));
        assert!(told.contains("has no such channel"), "{told}");
        let told = refused(KernelAdc::open, |_| Ok(()), &line.replace("voltage1", ""));
        assert!(told.contains("write iio, the folder of its device and a channel"), "{told}");
    }

    #[test]
    fn a_sensor_measures_in_the_units_of_its_channels() {
        let iio = [
            ("in_temp_input", "21500"),
            ("in_humidityrelative_input", "40250"),
            ("in_pressure_input", "101.325"),
            ("in_accel_x_raw", "-100"),
            ("in_accel_scale", "0.01"),
        ];
        let hwmon = [("temp1_input", "-5000"), ("fan1_input", "1200"), ("power1_input", "2500000")];
        for (files, kind, expected) in [
            (
                &iio[..],
                "iio",
                &[
                    (Channel::AmbientTemp, 21_500_000),
                    (Channel::Humidity, 40_250_000),
                    (Channel::Press, 101_325_000),
                    (Channel::AccelX, -1_000_000),
                ][..],
            ),
            (
                &hwmon,
                "hwmon",
                &[(Channel::DieTemp, -5_000_000), (Channel::Rpm, 1_200_000_000), (Channel::Power, 2_500_000)],
            ),
        ] {
            let (folder, line) = device(files, kind, "");
            let sensor = KernelSensor::open("x", bound(&line)).expect("it is there");
            assert_eq!(sensor.value(expected[0].0), Ok(SensorValue::default()));
            sensor.fetch().expect("it can be read");
            for (channel, micro) in expected {
                assert_eq!(sensor.value(*channel), Ok(SensorValue::from_micro(*micro)), "{channel:?}");
            }
            assert_eq!(sensor.value(Channel::Co2), Err(Problem::NotSupported));
            fs::remove_file(folder.path().join(files[0].0)).expect("it is there");
            assert_eq!(sensor.fetch(), Err(Problem::Failed(2)));
        }
        let (_folder, line) = device(&[("name", "nothing")], "hwmon", "");
        let told = refused(KernelSensor::open, |_| Ok(()), &line);
        assert!(told.contains("has no channel that is known here"), "{told}");
    }
}
