// SPDX-License-Identifier: Apache-2.0
//! Reads the header.

use std::collections::{BTreeMap, BTreeSet};

/// The part of a devicetree that programs can name.
///
/// A node is identified by its identifier in C, such as `DT_N_S_leds_S_led_0`. Names of nodes and properties are in
/// lower case there, so capital letters separate the parts.
#[derive(Clone, Debug, Default)]
pub struct Devicetree {
    /// The nodes of aliases.
    pub(crate) aliases: BTreeMap<String, String>,
    /// The nodes of labels.
    pub(crate) labels: BTreeMap<String, String>,
    /// The path of each node.
    paths: BTreeMap<String, String>,
    /// The nodes whose status is "okay".
    enabled: BTreeSet<String>,
    /// Per node, its properties of pins (`gpios` and names with this ending), `pwms` and `io_channels`, each with the
    /// controllers of its entries.
    channels: BTreeMap<String, BTreeMap<String, BTreeMap<usize, String>>>,
    /// The nodes on a bus, with the kind of bus: `i2c` or `spi`.
    buses: BTreeMap<String, String>,
    /// The nodes that are serial lines.
    serial_lines: BTreeSet<String>,
}

impl Devicetree {
    /// Reads `devicetree_generated.h`, and skips unknown definitions.
    pub fn read(header: &str) -> Self {
        let mut tree = Self::default();
        for line in header.lines() {
            let Some((name, value)) = line.strip_prefix("#define DT_N_").and_then(|rest| rest.split_once(' ')) else {
                continue;
            };
            tree.define(name, value.trim());
        }
        tree
    }

    /// Reads a definition; the name begins after `DT_N_`.
    fn define(&mut self, name: &str, value: &str) {
        if let Some(alias) = name.strip_prefix("ALIAS_") {
            self.aliases.insert(alias.to_owned(), value.to_owned());
        } else if let Some(label) = name.strip_prefix("NODELABEL_") {
            self.labels.insert(label.to_owned(), value.to_owned());
        } else if !name.starts_with("S_") {
            // Not of a node with a path: a compatible, or the root.
        } else if let Some((node, property)) = name.split_once("_P_") {
            self.define_property(&format!("DT_N_{node}"), property, value);
        } else if let Some((node, bus)) = name.split_once("_BUS_") {
            self.buses.insert(format!("DT_N_{node}"), bus.to_owned());
        } else if let Some(node) = name.strip_suffix("_PATH") {
            self.paths.insert(format!("DT_N_{node}"), value.trim_matches('"').to_owned());
        } else if let Some(node) = name.strip_suffix("_STATUS_okay") {
            self.enabled.insert(format!("DT_N_{node}"));
        }
    }

    fn define_property(&mut self, node: &str, property: &str, value: &str) {
        if property == "hw_flow_control_EXISTS" {
            // All bindings of serial lines have it, and no others.
            self.serial_lines.insert(node.to_owned());
        }
        let Some((property, index)) = property.strip_suffix("_PH").and_then(|rest| rest.split_once("_IDX_")) else {
            return;
        };
        let Ok(index) = index.parse() else { return };
        if matches!(property, "gpios" | "pwms" | "io_channels") || property.ends_with("_gpios") {
            let properties = self.channels.entry(node.to_owned()).or_default();
            properties.entry(property.to_owned()).or_default().insert(index, value.to_owned());
        }
    }

    pub(crate) fn is_known(&self, node: &str) -> bool {
        self.paths.contains_key(node)
    }

    /// Returns the path of a node, as people write it.
    pub(crate) fn path<'a>(&'a self, node: &'a str) -> &'a str {
        self.paths.get(node).map_or(node, String::as_str)
    }

    pub(crate) fn is_enabled(&self, node: &str) -> bool {
        self.enabled.contains(node)
    }

    /// Returns the properties of a node that are lists of pins or of channels, each with their controllers in order.
    pub(crate) fn channels_of(&self, node: &str) -> impl Iterator<Item = (&str, &BTreeMap<usize, String>)> {
        self.channels.get(node).into_iter().flatten().map(|(property, channels)| (property.as_str(), channels))
    }

    /// Returns the kind of bus that a node is on.
    pub(crate) fn bus_of(&self, node: &str) -> Option<&str> {
        self.buses.get(node).map(String::as_str)
    }

    /// Returns whether it is an I²C bus: its name has to be that of the devicetree's specification.
    pub(crate) fn is_i2c(&self, node: &str) -> bool {
        let name = self.path(node).rsplit('/').next().unwrap_or_default();
        name.split('@').next() == Some("i2c")
    }

    pub(crate) fn is_serial_line(&self, node: &str) -> bool {
        self.serial_lines.contains(node)
    }
}
