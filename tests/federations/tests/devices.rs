// SPDX-License-Identifier: Apache-2.0
//! Pins on Linux: a script moves the inputs, and what all pins did is in one file.

use std::fs;
use std::path::Path;

use lf_federations::Lfz;

const PROGRAM: &str = "applications/button_and_lamp/src/ButtonAndLamp.lf";
const SCRIPT: &str = "applications/button_and_lamp/src/presses.txt";

/// The changes of a pin in a file of VCD: nanoseconds, and what it was then.
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
    let finished = Lfz::run("button", Path::new(PROGRAM), &["--devices", SCRIPT, "--vcd", vcd]).finish();
    assert_eq!(finished.code(), 0, "{finished}");
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
fn a_script_without_sense_is_refused_before_the_start() {
    let folder = tempfile::tempdir().expect("there is room");
    let script = folder.path().join("script.txt");
    fs::write(&script, "100 ms led0 1\n200 ms led0 bright\n").expect("there is room");
    let script = script.to_str().expect("the folder's name is text");
    let blinky = Path::new("applications/blinky/src/Blinky.lf");
    let finished = Lfz::run("blinky", blinky, &["--devices", script]).finish();
    assert_eq!(finished.code(), 2, "{finished}");
    let told = format!("error: {script}: line 2: \"bright\" is no value of a pin: it is 0 or 1");
    assert!(finished.lines.iter().any(|line| line.starts_with(&told)), "{finished}");
}
