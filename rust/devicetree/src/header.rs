// SPDX-License-Identifier: Apache-2.0
//! Reads the header.

use std::collections::{BTreeMap, BTreeSet};

/// What of a devicetree concerns devices that programs name.
///
/// A node is known by its identifier in C, such as `DT_N_S_leds_S_led_0`. Names of nodes and properties are in lower
/// case there, so capital letters separate the parts.
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
    /// Per node, its properties of pins: `gpios` and what ends so, each with its pins' controllers.
    pins: BTreeMap<String, BTreeMap<String, BTreeMap<usize, String>>>,
}

impl Devicetree {
    /// Reads `devicetree_generated.h`. What it does not know in it, it passes over.
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

    /// Takes a definition; the name begins after `DT_N_`.
    fn define(&mut self, name: &str, value: &str) {
        if let Some(alias) = name.strip_prefix("ALIAS_") {
            self.aliases.insert(alias.to_owned(), value.to_owned());
        } else if let Some(label) = name.strip_prefix("NODELABEL_") {
            self.labels.insert(label.to_owned(), value.to_owned());
        } else if !name.starts_with("S_") {
            // Of no node with a path: a compatible, or the root.
        } else if let Some((node, property)) = name.split_once("_P_") {
            let Some((property, index)) = property.strip_suffix("_PH").and_then(|rest| rest.split_once("_IDX_")) else {
                return;
            };
            let Ok(index) = index.parse() else { return };
            if property == "gpios" || property.ends_with("_gpios") {
                let pins = self.pins.entry(format!("DT_N_{node}")).or_default();
                pins.entry(property.to_owned()).or_default().insert(index, value.to_owned());
            }
        } else if let Some(node) = name.strip_suffix("_PATH") {
            self.paths.insert(format!("DT_N_{node}"), value.trim_matches('"').to_owned());
        } else if let Some(node) = name.strip_suffix("_STATUS_okay") {
            self.enabled.insert(format!("DT_N_{node}"));
        }
    }

    /// The path of a node, as people write it.
    pub(crate) fn path<'a>(&'a self, node: &'a str) -> &'a str {
        self.paths.get(node).map_or(node, String::as_str)
    }

    pub(crate) fn is_enabled(&self, node: &str) -> bool {
        self.enabled.contains(node)
    }

    /// Properties of pins of a node, each with the controllers of its pins in order.
    pub(crate) fn pins_of(&self, node: &str) -> impl Iterator<Item = (&str, &BTreeMap<usize, String>)> {
        self.pins.get(node).into_iter().flatten().map(|(property, pins)| (property.as_str(), pins))
    }
}
