// SPDX-License-Identifier: Apache-2.0
//! The names of devices for programs.

use std::collections::BTreeMap;

use crate::Devicetree;

/// A device of the devicetree, or one function of it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Device {
    pub(crate) node: String,
    pub(crate) kind: Kind,
}

/// The kind of a device for programs.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// A pin of one of its properties.
    Gpio { property: String, index: usize },
    /// A channel of its `pwms`.
    Pwm { index: usize },
    /// A channel of its `io-channels`.
    Adc { index: usize },
    /// A device on an I²C bus.
    I2c,
    /// An I²C bus.
    I2cBus,
    /// A device on an SPI bus.
    Spi,
    /// A serial line.
    Uart,
    /// A device that may be a sensor; a mistake becomes known at run time.
    Sensor,
}

impl Kind {
    /// Returns the option that its drivers need.
    pub(crate) fn option(&self) -> &'static str {
        match self {
            Self::Gpio { .. } => "GPIO",
            Self::Pwm { .. } => "PWM",
            Self::Adc { .. } => "ADC",
            Self::I2c | Self::I2cBus => "I2C",
            Self::Spi => "SPI",
            Self::Uart => "SERIAL",
            Self::Sensor => "SENSOR",
        }
    }
}

/// The meaning of a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Meaning {
    /// A device that can be used.
    Usable(Device),
    /// One whose drivers are not in the image.
    WithoutDriver(Kind),
    /// One that cannot be used, because this node is disabled.
    Disabled(String),
}

/// Returns all names for `device!`: `led0`, `display.reset_gpios`, `keys[1]`. Options say which drivers the image has.
pub(crate) fn of(tree: &Devicetree, is_set: &dyn Fn(&str) -> bool) -> BTreeMap<String, Meaning> {
    let mut names = BTreeMap::new();
    // If a label is an alias of something else, the alias counts, because it is meant for applications.
    let is_identifier = |name: &str| !name.starts_with(|first: char| first.is_ascii_digit());
    let labels = tree.labels.iter().filter(|(name, _)| !tree.aliases.contains_key(*name));
    for (name, node) in labels.chain(&tree.aliases).filter(|(name, node)| is_identifier(name) && tree.is_known(node)) {
        for Side { suffix, kind, needs } in sides(tree, node) {
            let disabled = needs.iter().find(|node| !tree.is_enabled(node));
            let meaning = match disabled {
                // Most nodes are not sensors, and programs do not use them as such.
                Some(_) if kind == Kind::Sensor => continue,
                Some(node) => Meaning::Disabled(tree.path(node).to_owned()),
                None if is_set(kind.option()) => Meaning::Usable(Device { node: node.clone(), kind }),
                None if kind == Kind::Sensor => continue,
                None => Meaning::WithoutDriver(kind),
            };
            names.insert(format!("{name}{suffix}"), meaning);
        }
    }
    names
}

/// One function of a node.
struct Side {
    /// The suffix of the node's name.
    suffix: String,
    kind: Kind,
    /// The nodes that have to be enabled.
    needs: Vec<String>,
}

/// Returns the functions of a node. The first of its pins, PWM channels, ADC channels and bus is the meaning of its
/// name alone.
fn sides(tree: &Devicetree, node: &str) -> Vec<Side> {
    let mut sides = Vec::new();
    let mut has_main = false;
    // By name, `gpios`, `pwms` and `io_channels` come in another order.
    for main in ["gpios", "pwms", "io_channels"] {
        for (property, controllers) in tree.channels_of(node).filter(|(property, _)| *property == main) {
            sides.extend(channels(node, property, controllers, !has_main));
            has_main = true;
        }
    }
    for (property, controllers) in tree.channels_of(node).filter(|(property, _)| property.ends_with("_gpios")) {
        sides.extend(channels(node, property, controllers, false));
    }
    let parent = node.rsplit_once("_S_").map_or(node, |(parent, _)| parent);
    let (kind, needs) = match tree.bus_of(node) {
        Some("i2c") => (Kind::I2c, vec![node.to_owned(), parent.to_owned()]),
        Some("spi") => (Kind::Spi, vec![node.to_owned(), parent.to_owned()]),
        _ if tree.is_i2c(node) => (Kind::I2cBus, vec![node.to_owned()]),
        _ if tree.is_serial_line(node) => (Kind::Uart, vec![node.to_owned()]),
        _ if has_main => return sides,
        _ => (Kind::Sensor, vec![node.to_owned()]),
    };
    let bus = match kind {
        _ if !has_main => "",
        Kind::I2c | Kind::I2cBus => ".i2c",
        Kind::Spi => ".spi",
        _ => ".uart",
    };
    sides.push(Side { suffix: bus.to_owned(), kind, needs });
    sides
}

/// Returns the pins or channels of a property.
fn channels(
    node: &str,
    property: &str,
    controllers: &BTreeMap<usize, String>,
    is_main: bool,
) -> impl Iterator<Item = Side> {
    controllers.iter().map(move |(&index, controller)| {
        let property_suffix = if is_main { String::new() } else { format!(".{property}") };
        let index_suffix = if controllers.len() == 1 { String::new() } else { format!("[{index}]") };
        let kind = match property {
            "pwms" => Kind::Pwm { index },
            "io_channels" => Kind::Adc { index },
            _ => Kind::Gpio { property: property.to_owned(), index },
        };
        let suffix = format!("{property_suffix}{index_suffix}");
        Side { suffix, kind, needs: vec![node.to_owned(), controller.clone()] }
    })
}
