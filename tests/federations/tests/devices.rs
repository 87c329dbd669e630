// SPDX-License-Identifier: Apache-2.0
//! Devices on Linux: a script sets their inputs or names real ones, and one file records all pins.

use std::fs::{self, File};
use std::io::{Read as _, Write as _};
use std::path::Path;

use lf_federations::{Lfz, programs};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

const PROGRAM: &str = "applications/button_and_lamp/src/ButtonAndLamp.lf";
const SCRIPT: &str = "applications/button_and_lamp/src/presses.txt";

/// Returns the changes of a pin in a file of VCD: nanoseconds, and the new level.
fn changes(vcd: &str, pin: &str) -> Vec<(u64, bool)> {
    let named = |line: &&str| line.starts_with("$var") && line.split(' ').nth(4) == Some(pin);
    let code = vcd.lines().find(named).and_then(|line| line.split(' ').nth(3)).expect("the pin is there");
    let (mut now, mut changes) = (0, Vec::new());
    for line in vcd.lines() {
        if let Some(time) = line.strip_prefix('#') {
            now = time.parse().expect("times are numbers");
        } else if let Some(value) = line.strip_suffix(code).filter(|value| ["0", "1"].contains(value)) {
            changes.push((now, value == "1"));
        }
    }
    changes
}

#[test]
fn a_scripted_button_changes_a_lamp_of_another_federate() {
    let folder = tempfile::tempdir().expect("there is room");
    let file = folder.path().join("pins.vcd");
    let vcd = file.to_str().expect("the folder's name is text");
    let finished = Lfz::run("button", Path::new(PROGRAM), &["--devices", SCRIPT, "--vcd", vcd]).succeed();
    let presses: Vec<&str> = finished.of("button").filter(|line| line.starts_with("press ")).collect();
    assert_eq!(presses.len(), 6, "{finished}");
    let lamp: Vec<&str> = finished.of("lamp").filter(|line| line.starts_with("the lamp is")).collect();
    let (on, off) = ("the lamp is on", "the lamp is off");
    assert_eq!(lamp, [on, off, on, off, on, off], "{finished}");

    let recorded = fs::read_to_string(&file).expect("it was recorded");
    let (button, lamp) = (changes(&recorded, "sw0"), changes(&recorded, "led0"));
    assert_eq!(
        lamp.iter().map(|(_, active)| *active).collect::<Vec<_>>(),
        [false, true, false, true, false, true, false]
    );
    // The lamp changes at the time of a press plus 5 ms, on the same clock, and never before.
    for (time, _) in &lamp[1..] {
        assert!(button.iter().any(|(press, active)| *active && press + 5_000_000 <= *time), "{recorded}");
    }
    assert_eq!(button.iter().filter(|(time, _)| *time < 350_000_000).count(), 5, "{recorded}");
}

#[test]
fn a_thermostat_finds_what_the_script_says_and_the_fan_is_recorded() {
    let folder = tempfile::tempdir().expect("there is room");
    let file = folder.path().join("room.vcd");
    let vcd = file.to_str().expect("the folder's name is text");
    let program = Path::new("applications/thermostat/src/Thermostat.lf");
    let options = ["--devices", "applications/thermostat/src/room.txt", "--vcd", vcd];
    let finished = Lfz::run("thermostat", program, &options).succeed();
    let shown: Vec<&str> = finished.of("display").filter(|line| line.contains("wanted")).collect();
    assert_eq!(shown.first(), Some(&"25.0 °C, 20.0 °C wanted, fan at 100 %"), "{finished}");
    assert_eq!(shown.last(), Some(&"22.5 °C, 22.0 °C wanted, fan at 12 %"), "{finished}");
    let recorded = fs::read_to_string(&file).expect("it was recorded");
    assert!(recorded.lines().any(|line| line.starts_with("$var real 64 ") && line.contains(" fan ")), "{recorded}");
    assert!(recorded.lines().any(|line| line.starts_with("r2310 ")), "the knob was turned: {recorded}");
}

#[test]
fn a_value_that_a_device_cannot_have_is_told_with_its_line() {
    let folder = tempfile::tempdir().expect("there is room");
    let script = folder.path().join("script.txt");
    fs::write(&script, "0 s thermometer@48[0x00] 0x1900\n0 s knob \"half\"\n").expect("there is room");
    let script = script.to_str().expect("the folder's name is text");
    let program = Path::new("applications/thermostat/src/Thermostat.lf");
    let finished = Lfz::run("knob", program, &["--devices", script]).finish();
    assert_ne!(finished.code(), 0, "{finished}");
    let told =
        "knob: line 2 of the script for devices has a value that it cannot have: a voltage is a number of millivolts";
    assert!(finished.lines.iter().any(|line| line.contains(told)), "{finished}");
}

#[test]
fn a_script_without_sense_is_refused_before_the_start() {
    let folder = tempfile::tempdir().expect("there is room");
    let script = folder.path().join("script.txt");
    fs::write(&script, "100 ms led0 1\n200 ms led0 bright\n").expect("there is room");
    let script = script.to_str().expect("the folder's name is text");
    let blinky = Path::new("applications/blinky/src/Blinky.lf");
    let finished = Lfz::run("blinky", blinky, &["--devices", script]).finish();
    assert_eq!(finished.code(), 1, "{finished}");
    let told = format!("error: {script}: line 2: \"bright\" is no value: a pin is 0 or 1");
    assert!(finished.lines.iter().any(|line| line.starts_with(&told)), "{finished}");
}

/// The UART is a pseudo-terminal of the kernel. The others are folders that look like those of sysfs.
#[test]
fn a_program_uses_the_devices_that_the_script_names() {
    let folder = tempfile::tempdir().expect("there is room");
    let file = |name: &str| folder.path().join(name);
    for (name, content) in [
        ("pwm0/period", "0"),
        ("pwm0/duty_cycle", "0"),
        ("pwm0/enable", "0"),
        ("in_voltage1_raw", "500"),
        ("in_voltage_scale", "2.5"),
        ("in_temp_input", "21500"),
    ] {
        fs::create_dir_all(file(name).parent().expect("it is in a folder")).expect("there is room");
        fs::write(file(name), content).expect("there is room");
    }
    let terminal = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("there are pseudo-terminals");
    grantpt(&terminal).and_then(|()| unlockpt(&terminal)).expect("it is this process's own");
    let line = ptsname(&terminal, Vec::new()).expect("it has a name");
    let (line, sysfs) = (line.to_str().expect("it is text"), folder.path().display());
    let script = format!(
        "line serial {line} 115200\nfan pwm {sysfs} 0 20 ms\nknob iio {sysfs} voltage1\nroom iio {sysfs}\n\
         100 ms sw0 1\n"
    );
    fs::write(file("script.txt"), script).expect("there is room");
    let (script, vcd) = (file("script.txt"), file("pins.vcd"));
    let options = ["--devices", script.to_str().expect("it is text"), "--vcd", vcd.to_str().expect("it is text")];
    let run = Lfz::run("real_devices", &programs().join("RealDevices.lf"), &options);

    let mut terminal = File::from(terminal);
    let mut greeting = [0; 6];
    terminal.read_exact(&mut greeting).expect("the program says that it listens");
    assert_eq!(&greeting, b"ready\n");
    terminal.write_all(b"hello\n").expect("the line is open");
    let mut answer = [0; 6];
    terminal.read_exact(&mut answer).expect("the program answers");
    assert_eq!(&answer, b"HELLO\n");
    let finished = run.succeed();
    for told in ["1250 mV", "21.500000 degrees", "sw0 is simulated"] {
        assert!(finished.lines.iter().any(|line| line == told), "{told}: {finished}");
    }
    let content = |name| fs::read_to_string(file(name)).expect("it is there");
    assert_eq!(
        [content("pwm0/period"), content("pwm0/duty_cycle"), content("pwm0/enable")],
        ["20000000", "4000000", "1"]
    );
    let recorded = fs::read_to_string(&vcd).expect("it was recorded");
    for change in ["r0.2 ", "r1250 "] {
        assert!(recorded.lines().any(|line| line.starts_with(change)), "{recorded}");
    }
}

#[test]
fn a_device_that_is_not_there_is_named_with_its_line() {
    let folder = tempfile::tempdir().expect("there is room");
    let script = folder.path().join("script.txt");
    fs::write(&script, "# the lamp\nled0 gpio /dev/gpiochip999 17 active-low\n").expect("there is room");
    let script = script.to_str().expect("the folder's name is text");
    let blinky = Path::new("applications/blinky/src/Blinky.lf");
    let finished = Lfz::run("blinky", blinky, &["--devices", script]).finish();
    assert_ne!(finished.code(), 0, "{finished}");
    let told = "led0: it is /dev/gpiochip999, says line 2 of the script for devices, which is not there: `gpiodetect`";
    assert!(finished.lines.iter().any(|line| line.contains(told)), "{finished}");
}
