// SPDX-License-Identifier: Apache-2.0
//! Devices on SPI buses, by spidev.

use std::fmt;
use std::io;
use std::sync::{Mutex, PoisonError};

use lf_devices::embedded_hal::spi::{Operation, SpiDevice as _};
use lf_devices::{Device, Problem, SpiTarget};
use linux_embedded_hal::SpidevDevice;
use linux_embedded_hal::spidev::{SpiModeFlags, Spidev, SpidevOptions};

use super::super::binding::{Bound, Kind};
use super::{Advice, DeviceRef, failed};

const ADVICE: Advice = Advice {
    missing: "which is not there: is the driver spidev loaded, and the bus enabled?",
    denied: "which this user may not open: as a rule members of the group spi may",
    busy: "which another program uses",
    other: "but the program uses it as a device on an SPI bus: write spi, its file, perhaps a frequency and a mode",
};

/// A device on an SPI bus.
pub struct KernelSpi {
    place: DeviceRef,
    device: Mutex<SpidevDevice>,
}

impl KernelSpi {
    /// Opens the device of a line of the script.
    pub(in super::super) fn open(name: &'static str, bound: &'static Bound) -> Result<Self, Problem> {
        let place = DeviceRef::of(name, bound, &ADVICE);
        let Kind::Spi { hertz, mode } = bound.binding.kind else { return Err(place.is_other()) };
        let device = configured(place.path, hertz, mode).map_err(|error| place.refuses(&error))?;
        Ok(Self { place, device: Mutex::new(SpidevDevice(device)) })
    }
}

fn configured(path: &str, hertz: Option<u32>, mode: Option<u8>) -> io::Result<Spidev> {
    let mut device = Spidev::open(path)?;
    let mut options = SpidevOptions { bits_per_word: Some(8), max_speed_hz: hertz, ..SpidevOptions::new() };
    if let Some(mode) = mode {
        // The devicetree determines the rest of the mode, such as the level that selects the device.
        let clock = SpiModeFlags::SPI_CPOL | SpiModeFlags::SPI_CPHA;
        let others = device.query_configuration()?.spi_mode.unwrap_or(SpiModeFlags::empty()) - clock;
        options.spi_mode = Some(others | SpiModeFlags::from_bits_truncate(mode.into()));
    }
    device.configure(&options)?;
    Ok(device)
}

impl fmt::Debug for KernelSpi {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Spi").field("place", &self.place).finish_non_exhaustive()
    }
}

impl Device for KernelSpi {
    fn name(&self) -> &'static str {
        self.place.name
    }
}

impl SpiTarget for KernelSpi {
    fn is_ready(&self) -> Result<(), Problem> {
        Ok(())
    }

    fn transaction(&self, operations: &mut [Operation<'_, u8>]) -> Result<(), Problem> {
        let mut device = self.device.lock().unwrap_or_else(PoisonError::into_inner);
        device.transaction(operations).map_err(|error| failed(error.inner()))
    }
}
