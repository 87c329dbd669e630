// SPDX-License-Identifier: Apache-2.0
//! The order of reactions within a tag.

use super::graph::{Node, StepId};
use crate::arena::{Arena, ArenaId as _, arena_ids};

arena_ids! {
    /// A vertex in the order of levels: steps by their position in the graph, then connections by theirs.
    pub(super) Vertex;
}

impl From<StepId> for Vertex {
    fn from(step: StepId) -> Self {
        Self::at(step.position())
    }
}

/// The reason why one vertex follows another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reason {
    /// It is declared later in the same reactor.
    Declared,
    /// It reads or sends a port that the other one writes.
    Port(Node),
}

/// The followers of each vertex.
pub(super) type Followers = Arena<Vertex, Vec<(Vertex, Reason)>>;
