// SPDX-License-Identifier: Apache-2.0
//! Channels of PWM chips, by sysfs.

use std::io;
use std::path::{Path, PathBuf};

use lf_devices::{Device, Problem, PwmChannel};

use super::super::binding::{Bound, Kind};
use super::super::recording::Signal;
use super::super::simulation::Simulation;
use super::sysfs::{number, set};
use super::{Advice, DeviceRef, failed};

const ADVICE: Advice = Advice {
    missing: "where the chip or the channel is not: `ls /sys/class/pwm` lists the chips",
    denied: "to which this user may not write: a rule of udev can give the files of pwm to a group",
    busy: "whose channel a driver of the kernel uses, or another program is taking",
    other: "but the program uses it as PWM: write pwm, the folder of its chip, its channel and its period",
};

/// A channel of a PWM chip.
#[derive(Debug)]
pub struct KernelPwm {
    place: DeviceRef,
    channel: PathBuf,
    period: u32,
}

impl KernelPwm {
    /// Opens the channel of a line of the script. It keeps its state, except for its period.
    pub(in super::super) fn open(name: &'static str, bound: &'static Bound) -> Result<Self, Problem> {
        let place = DeviceRef::of(name, bound, &ADVICE);
        let Kind::Pwm { channel, period } = bound.binding.kind else { return Err(place.is_other()) };
        let folder = prepared(Path::new(place.path), channel, period).map_err(|error| place.refuses(&error))?;
        Ok(Self { place, channel: folder, period })
    }
}

fn prepared(chip: &Path, channel: u32, period: u32) -> io::Result<PathBuf> {
    let folder = chip.join(format!("pwm{channel}"));
    if !folder.exists() {
        set(&chip.join("export"), channel)?;
    }
    // A pulse is never longer than the period, not even in between.
    if number(&folder.join("duty_cycle"))? > f64::from(period) {
        set(&folder.join("duty_cycle"), 0)?;
    }
    set(&folder.join("period"), period)?;
    Ok(folder)
}

impl Device for KernelPwm {
    fn name(&self) -> &'static str {
        self.place.name
    }
}

impl PwmChannel for KernelPwm {
    fn is_ready(&self) -> Result<(), Problem> {
        Ok(())
    }

    fn period(&self) -> u32 {
        self.period
    }

    fn set_pulse(&self, nanoseconds: u32) -> Result<(), Problem> {
        let pulse = set(&self.channel.join("duty_cycle"), nanoseconds);
        pulse.and_then(|()| set(&self.channel.join("enable"), 1)).map_err(|error| failed(&error))?;
        let part = f64::from(nanoseconds) / f64::from(self.period);
        Simulation::of_program().drives(self.place.name, Signal::Real(part));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::tests::{bound, refused};
    use super::*;

    #[test]
    fn a_channel_gets_its_period_and_its_pulses() {
        let chip = tempfile::tempdir().expect("there is room");
        let folder = chip.path().join("pwm1");
        fs::create_dir(&folder).expect("there is room");
        for (file, content) in [("period", "0"), ("duty_cycle", "90000000"), ("enable", "0")] {
            fs::write(folder.join(file), content).expect("there is room");
        }
        let content = |file| fs::read_to_string(folder.join(file)).expect("it is there");
        let line = format!("x pwm {} 1 20 ms", chip.path().display());
        let pwm = KernelPwm::open("x", bound(&line)).expect("it is there");
        assert_eq!((content("period"), content("duty_cycle")), ("20000000".to_owned(), "0".to_owned()));
        assert_eq!((content("enable"), pwm.period()), ("0".to_owned(), 20_000_000));
        pwm.set_pulse(1_500_000).expect("it can be set");
        assert_eq!((content("duty_cycle"), content("enable")), ("1500000".to_owned(), "1".to_owned()));
        // A channel that was not exported, of a chip that does not exist.
        let told = refused(KernelPwm::open, |_| Ok(()), &format!("x pwm {} 2 20 ms", chip.path().display()));
        assert!(told.contains("where the chip or the channel is not"), "{told}");
        assert!(!chip.path().join("export").exists());
    }
}
