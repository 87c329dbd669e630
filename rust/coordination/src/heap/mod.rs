// SPDX-License-Identifier: Apache-2.0
//! The memory of an RTI, owned, for programs that have a heap: the RTI itself only borrows it, as [`RtiStorage`].

mod growing;

use std::vec;
use std::vec::Vec;

use lf_model::time::Tag;

use crate::rti::{Connection, Node, PathWords, RtiStorage, Slot};

pub use growing::Growing;

/// The capacities of an RTI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Federates of the federation, at least 1.
    pub federates: usize,
    /// Connections that can be open at once: one for each federate, and a few more, so that a rejected peer can learn
    /// the reason.
    pub connections: usize,
    /// The maximum number of upstream federates of one federate; the number of federates always suffices.
    pub upstream: usize,
    /// The number of different tags of messages in transit to one federate that are stored exactly, at least 1.
    pub in_transit: usize,
}

/// The memory of an RTI. A copy, together with the state of a suspended RTI, is a copy of the RTI.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Memory {
    slots: Vec<Slot>,
    nodes: Vec<Node>,
    connections: Vec<Connection>,
    paths: Vec<PathWords>,
    upstream: Vec<PathWords>,
    in_transit: Vec<Tag>,
    #[cfg(feature = "transients")]
    registrations: Vec<bool>,
}

impl Memory {
    /// Returns fresh memory.
    pub fn new(sizes: Sizes) -> Self {
        let Sizes { federates, connections, upstream, in_transit } = sizes;
        Self {
            slots: vec![Slot::EMPTY; federates],
            nodes: vec![Node::EMPTY; federates],
            connections: vec![Connection::EMPTY; connections],
            paths: vec![PathWords::default(); 2 * federates * federates],
            upstream: vec![PathWords::default(); federates * upstream],
            in_transit: vec![Tag::NEVER; federates * in_transit],
            // All zero, so its pages cost nothing until one is used.
            #[cfg(feature = "transients")]
            registrations: vec![false; federates * federates],
        }
    }

    /// Returns the number of federates.
    pub fn federates(&self) -> usize {
        self.slots.len()
    }

    /// Returns the storage that the RTI borrows.
    pub fn storage(&mut self) -> RtiStorage<'_> {
        RtiStorage {
            slots: &mut self.slots,
            nodes: &mut self.nodes,
            connections: &mut self.connections,
            paths: &mut self.paths,
            upstream: &mut self.upstream,
            in_transit: &mut self.in_transit,
            #[cfg(feature = "transients")]
            registrations: &mut self.registrations,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString as _;

    use crate::rti::{Config, Rti, SetupError};

    use super::{Memory, Sizes};

    const LEAST: Sizes = Sizes { federates: 3, connections: 3, upstream: 0, in_transit: 1 };

    fn setup(sizes: Sizes) -> Result<(), SetupError> {
        Rti::new(Config::new(b"memory", 0), Memory::new(sizes).storage()).map(drop)
    }

    #[test]
    fn the_least_sizes_suffice_and_less_is_refused_by_name() {
        assert_eq!(setup(LEAST), Ok(()));
        let refused = |sizes| setup(sizes).expect_err("this is too little").to_string();
        assert!(refused(Sizes { federates: 0, ..LEAST }).contains("not 0"));
        assert!(refused(Sizes { connections: 2, ..LEAST }).contains("storage for connections needs 3"));
        assert!(refused(Sizes { in_transit: 0, ..LEAST }).contains("messages in transit needs 3"));
    }
}
