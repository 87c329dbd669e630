// SPDX-License-Identifier: Apache-2.0
//! The order of reactions within a tag.

use super::graph::Node;

/// What runs at a level: reactions by their position in the graph, then connections to other federates by theirs.
pub(super) type Vertex = usize;

/// Why one comes after another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reason {
    /// It is declared later in the same reactor.
    Declared,
    /// It reads or sends a port that the other one writes or fills.
    Port(Node),
}

/// By vertex: those that follow it.
pub(super) type Followers = Vec<Vec<(Vertex, Reason)>>;
