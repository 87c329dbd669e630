// SPDX-License-Identifier: Apache-2.0
//! Bindings of the program's devices to devices of this computer: lines of the script such as
//!
//! ```text
//! led0         gpio /dev/gpiochip0 17 active-low
//! sw0          gpio /dev/gpiochip0 27 pull-up
//! thermometer  i2c /dev/i2c-1 0x48
//! imu          spi /dev/spidev0.0 1 MHz mode 3
//! line         serial /dev/ttyUSB0 115200
//! fan          pwm /sys/class/pwm/pwmchip0 0 25 us
//! knob         iio /sys/bus/iio/devices/iio:device0 voltage1
//! room         iio /sys/bus/iio/devices/iio:device1
//! board        hwmon /sys/class/hwmon/hwmon0
//! ```

use super::words::{Words, hexadecimal, time};

/// The kinds, for the error about another one.
const KINDS: &str = "gpio, i2c, spi, serial, pwm, iio or hwmon";
/// The highest address of 7 bits.
const ADDRESS_MAX: u8 = 0x7f;

/// A device of this computer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bound {
    /// The line of the script.
    pub(crate) line: u32,
    pub(crate) binding: Binding,
}

/// The binding of a device.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Binding {
    /// Its file, or its folder in sysfs.
    pub(crate) path: String,
    pub(crate) kind: Kind,
}

/// The way to access a device, and its settings.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Kind {
    /// A line of a GPIO chip.
    Gpio { line: u32, is_active_low: bool, pull: Option<Pull> },
    /// An I²C bus; the address of the device on it, if the script determines it.
    I2c { address: Option<u8> },
    /// A device on an SPI bus; missing settings are the system's.
    Spi { hertz: Option<u32>, mode: Option<u8> },
    /// A serial line.
    Serial { baud: u32 },
    /// A channel of a PWM chip; its period in nanoseconds.
    Pwm { channel: u32, period: u32 },
    /// A device of Industrial I/O: one of its channels, or all of them.
    Iio { channel: Option<String> },
    /// A hardware monitor.
    Hwmon,
}

/// The resistor of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pull {
    Up,
    Down,
    None,
}

/// A function that parses the settings of a kind, behind the path.
type ReadKind = fn(&mut Words<'_>) -> Result<Kind, String>;

impl Binding {
    /// Parses the text behind the name of a device.
    pub(super) fn read(device: &str, words: &mut Words<'_>) -> Result<Self, String> {
        let kind = words.next().ok_or_else(|| {
            format!("after {device} comes what it is ({KINDS}); a line for one that is simulated begins with a time")
        })?;
        let (read, example): (ReadKind, _) = match kind {
            "gpio" => (gpio, "/dev/gpiochip0 17"),
            "i2c" => (i2c, "/dev/i2c-1 0x48"),
            "spi" => (spi, "/dev/spidev0.0 1 MHz"),
            "serial" => (serial, "/dev/ttyUSB0 115200"),
            "pwm" => (pwm, "/sys/class/pwm/pwmchip0 0 20 ms"),
            "iio" => (iio, "/sys/bus/iio/devices/iio:device0 voltage1"),
            "hwmon" => (|_| Ok(Kind::Hwmon), "/sys/class/hwmon/hwmon0"),
            other => {
                return Err(format!(
                    "\"{other}\" is no kind of device: {KINDS}; a line for one that is simulated begins with a time"
                ));
            }
        };
        let path = words.next().filter(|path| path.starts_with('/'));
        let path = path.ok_or_else(|| format!("after {kind} comes a path from the root, such as {example}"))?;
        let kind = read(words).map_err(|what| format!("{what}, as in: {device} {kind} {example}"))?;
        Ok(Self { path: path.to_owned(), kind })
    }
}

fn gpio(words: &mut Words<'_>) -> Result<Kind, String> {
    let line = number(words, "the number of a line")?;
    let (mut is_active_low, mut pull) = (false, None);
    for word in words {
        match word {
            "active-low" => is_active_low = true,
            "pull-up" => pull = Some(Pull::Up),
            "pull-down" => pull = Some(Pull::Down),
            "no-pull" => pull = Some(Pull::None),
            other => {
                return Err(format!(
                    "\"{other}\" is not known of a pin: active-low, pull-up, pull-down and no-pull are"
                ));
            }
        }
    }
    Ok(Kind::Gpio { line, is_active_low, pull })
}

fn i2c(words: &mut Words<'_>) -> Result<Kind, String> {
    let Some(word) = words.next() else { return Ok(Kind::I2c { address: None }) };
    let address = u8::from_str_radix(hexadecimal(word), 16).ok().filter(|address| *address <= ADDRESS_MAX);
    let address = address.ok_or_else(|| format!("\"{word}\" is no address: it is hexadecimal, up to 0x7f"))?;
    Ok(Kind::I2c { address: Some(address) })
}

fn spi(words: &mut Words<'_>) -> Result<Kind, String> {
    let hertz = match words.peek() {
        None | Some("mode") => None,
        Some(_) => Some(frequency(words)?),
    };
    let mode = match words.next() {
        None => None,
        Some("mode") => {
            let mode = words.next().and_then(|word| word.parse().ok()).filter(|mode| (0..=3).contains(mode));
            Some(mode.ok_or("after `mode` comes 0, 1, 2 or 3")?)
        }
        Some(other) => return Err(format!("\"{other}\" is not known: only `mode` and its number can come here")),
    };
    Ok(Kind::Spi { hertz, mode })
}

fn serial(words: &mut Words<'_>) -> Result<Kind, String> {
    let baud = number(words, "the speed in baud")?;
    if baud == 0 {
        return Err("a line with 0 baud is closed".to_owned());
    }
    Ok(Kind::Serial { baud })
}

fn pwm(words: &mut Words<'_>) -> Result<Kind, String> {
    let channel = number(words, "the number of a channel")?;
    let period = time(words).map_err(|what| format!("after the channel comes its period: {what}"))?;
    let period = u32::try_from(period.as_nanos()).ok().filter(|period| *period > 0);
    Ok(Kind::Pwm { channel, period: period.ok_or("a period is more than nothing, and at most 4.2 s")? })
}

fn iio(words: &mut Words<'_>) -> Result<Kind, String> {
    let channel = words.next().map(|word| {
        let is_channel = word.chars().all(|character| character.is_ascii_alphanumeric() || "_-".contains(character));
        is_channel.then(|| word.to_owned()).ok_or_else(|| format!("\"{word}\" is no channel: voltage1 is one"))
    });
    Ok(Kind::Iio { channel: channel.transpose()? })
}

fn number(words: &mut Words<'_>, what: &str) -> Result<u32, String> {
    words.next().and_then(|word| word.parse().ok()).ok_or_else(|| format!("after the path comes {what}"))
}

/// Parses a number and a unit, in one word or in two.
fn frequency(words: &mut Words<'_>) -> Result<u32, String> {
    let first = words.next().unwrap_or_default();
    let (number, mut unit) = first.split_at(first.find(char::is_alphabetic).unwrap_or(first.len()));
    if unit.is_empty() {
        unit = words.next().unwrap_or_default();
    }
    let factor = match unit {
        "Hz" => 1.0,
        "kHz" => 1e3,
        "MHz" => 1e6,
        _ => return Err(format!("\"{first}\" is no frequency: its unit is Hz, kHz or MHz")),
    };
    let hertz = number.parse::<f64>().ok().map(|number| number * factor);
    let hertz = hertz.filter(|hertz| (1.0..=f64::from(u32::MAX)).contains(hertz));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is within the range")]
    hertz.map(|hertz| hertz.round() as u32).ok_or_else(|| format!("\"{number}\" is no number of {unit}"))
}

#[cfg(test)]
mod tests {
    use super::super::script::Script;
    use super::*;

    fn binding(line: &str) -> Binding {
        Script::read(line).expect(line).bound("a", "x").expect(line).binding.clone()
    }

    #[test]
    fn a_line_without_a_time_says_what_a_device_is() {
        let gpio = |is_active_low, pull| Kind::Gpio { line: 17, is_active_low, pull };
        for (text, path, kind) in [
            ("x gpio /dev/gpiochip0 17 # a lamp", "/dev/gpiochip0", gpio(false, None)),
            ("a.x gpio /dev/g 17 active-low pull-up", "/dev/g", gpio(true, Some(Pull::Up))),
            ("x gpio /dev/g 17 pull-down", "/dev/g", gpio(false, Some(Pull::Down))),
            ("x gpio /dev/g 17 no-pull", "/dev/g", gpio(false, Some(Pull::None))),
            ("x i2c /dev/i2c-1 0x48", "/dev/i2c-1", Kind::I2c { address: Some(0x48) }),
            ("x i2c /dev/i2c-1", "/dev/i2c-1", Kind::I2c { address: None }),
            ("x spi /dev/s", "/dev/s", Kind::Spi { hertz: None, mode: None }),
            ("x spi /dev/s mode 3", "/dev/s", Kind::Spi { hertz: None, mode: Some(3) }),
            ("x spi /dev/s 1.5 MHz mode 1", "/dev/s", Kind::Spi { hertz: Some(1_500_000), mode: Some(1) }),
            ("x spi /dev/s 400kHz", "/dev/s", Kind::Spi { hertz: Some(400_000), mode: None }),
            ("x serial /dev/ttyUSB0 115200", "/dev/ttyUSB0", Kind::Serial { baud: 115_200 }),
            ("x pwm /sys/p 2 20 ms", "/sys/p", Kind::Pwm { channel: 2, period: 20_000_000 }),
            ("x iio /sys/i voltage1", "/sys/i", Kind::Iio { channel: Some("voltage1".to_owned()) }),
            ("x iio /sys/i", "/sys/i", Kind::Iio { channel: None }),
            ("x hwmon /sys/h", "/sys/h", Kind::Hwmon),
        ] {
            assert_eq!(binding(text), Binding { path: path.to_owned(), kind }, "{text}");
        }
    }

    #[test]
    fn lines_for_a_federate_are_for_it_alone() {
        let script = Script::read("x hwmon /sys/a\na.x hwmon /sys/b\n1 s b.x 1\n").expect("it makes sense");
        let path = |federate| script.bound(federate, "x").map(|bound| bound.binding.path.as_str());
        assert_eq!((path("a"), path("b"), path("c")), (Some("/sys/b"), None, Some("/sys/a")));
        assert!(matches!(script.unknown("a", false, |_| false)[..], [(_, "a.x")]));
    }

    #[test]
    fn a_line_without_sense_is_named() {
        for (text, told) in [
            ("led0", "line 1: after led0 comes what it is (gpio, i2c"),
            ("x sw0 1", "line 1: \"sw0\" is no kind of device: gpio, i2c"),
            ("\nx gpio", "line 2: after gpio comes a path from the root, such as /dev/gpiochip0 17"),
            ("x gpio gpiochip0 17", "line 1: after gpio comes a path from the root"),
            ("x gpio /dev/g", "line 1: after the path comes the number of a line, as in: x gpio /dev/gpiochip0 17"),
            ("x gpio /dev/g 17 inverted", "line 1: \"inverted\" is not known of a pin"),
            ("x i2c /dev/i2c-1 0x80", "line 1: \"0x80\" is no address"),
            ("x spi /dev/s 1", "line 1: \"1\" is no frequency"),
            ("x spi /dev/s 9000 MHz", "line 1: \"9000\" is no number of MHz"),
            ("x spi /dev/s mode 4", "line 1: after `mode` comes 0, 1, 2 or 3"),
            ("x serial /dev/t fast", "line 1: after the path comes the speed in baud"),
            ("x serial /dev/t 0", "line 1: a line with 0 baud"),
            ("x pwm /sys/p 0", "line 1: after the channel comes its period: a time is missing"),
            ("x pwm /sys/p 0 5 s", "line 1: a period is more than nothing"),
            ("x iio /sys/i ../secret", "line 1: \"../secret\" is no channel"),
            ("x hwmon /sys/h 1", "line 1: \"1\" is one word too many"),
            ("x hwmon /sys/h\nx hwmon /sys/h", "line 2: line 1 says already which device x is"),
            ("1 s x 1\nx hwmon /sys/h", "line 1: x is a device of this computer, says line 2"),
            ("x i2c /dev/i2c-1\n1 s x@48[0x00] 0x1980", "line 2: x is a device of this computer, says line 1"),
        ] {
            let error = Script::read(text).expect_err(text).to_string();
            assert!(error.starts_with(told), "{text}: {error}");
        }
        Script::read("keys gpio /dev/g 1\n1 s keys[1] 1").expect("these are two pins");
    }
}
