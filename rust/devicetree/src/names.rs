// SPDX-License-Identifier: Apache-2.0
//! What programs can write for a device.

use std::collections::BTreeMap;

use crate::Devicetree;

/// A pin of the devicetree.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Pin {
    pub(crate) node: String,
    pub(crate) property: String,
    pub(crate) index: usize,
}

impl Pin {
    /// The name of what C has of it.
    pub(crate) fn symbol(&self) -> String {
        format!("lf_pin_{}_{}_{}", self.node.trim_start_matches("DT_N_"), self.property, self.index)
    }
}

/// What a name stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Meaning {
    /// A pin that can be used.
    Usable(Pin),
    /// One that cannot, because this node is disabled.
    Disabled(String),
}

/// Everything that `device!` takes, spelled as there: `led0`, `display.reset_gpios`, `keys[1]`.
pub(crate) fn of(tree: &Devicetree) -> BTreeMap<String, Meaning> {
    let mut names = BTreeMap::new();
    // Where a label is an alias of something else, the alias counts, for it is meant for applications.
    let is_identifier = |name: &str| !name.starts_with(|first: char| first.is_ascii_digit());
    let labels = tree.labels.iter().filter(|(name, _)| !tree.aliases.contains_key(*name));
    for (name, node) in labels.chain(&tree.aliases).filter(|(name, _)| is_identifier(name)) {
        for (property, controllers) in tree.pins_of(node) {
            for (&index, controller) in controllers {
                let disabled = [node, controller].into_iter().find(|node| !tree.is_enabled(node));
                let meaning = disabled.map_or_else(
                    || Meaning::Usable(Pin { node: node.clone(), property: property.to_owned(), index }),
                    |node| Meaning::Disabled(tree.path(node).to_owned()),
                );
                let property = if property == "gpios" { String::new() } else { format!(".{property}") };
                let index = if controllers.len() == 1 { String::new() } else { format!("[{index}]") };
                names.insert(format!("{name}{property}{index}"), meaning);
            }
        }
    }
    names
}
