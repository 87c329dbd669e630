// SPDX-License-Identifier: Apache-2.0
//! The order of reactions within a tag.

use super::graph::Node;

/// A node in the order of levels: reactions by their position in the graph, then connections to other federates by
/// theirs.
pub(super) type Vertex = usize;

/// The reason why one vertex follows another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reason {
    /// It is declared later in the same reactor.
    Declared,
    /// It reads or sends a port that the other one writes.
    Port(Node),
}

/// The followers of each vertex.
pub(super) type Followers = Vec<Vec<(Vertex, Reason)>>;
