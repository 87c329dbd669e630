// SPDX-License-Identifier: Apache-2.0
//! Random graphs for tests of the graph's results.

use std::vec;
use std::vec::Vec;

use lf_wire::{DELAY_NONE, NeighborStructure};
use proptest::prelude::*;

use super::graph::{Graph, Node};

pub(super) const FEDERATES: u16 = 6;

pub(super) fn edges() -> impl Strategy<Value = Vec<(u16, u16, i64)>> {
    let delay = prop_oneof![Just(DELAY_NONE), Just(0), 1..20i64];
    proptest::collection::vec((0..FEDERATES, 0..FEDERATES, delay), 0..20)
}

pub(super) fn with_graph<R>(edges: &[(u16, u16, i64)], look: impl FnOnce(&mut Graph<'_>) -> R) -> R {
    let n = usize::from(FEDERATES);
    let mut nodes = vec![Node::default(); n];
    // The content of the storage does not matter.
    let (mut upstream, mut paths) = (vec![[u64::MAX; 2]; n * n], vec![[u64::MAX; 2]; 2 * n * n]);
    let mut graph = Graph::new(&mut nodes, &mut upstream, &mut paths, true);
    for to in 0..FEDERATES {
        let list: Vec<_> = edges.iter().filter(|edge| edge.1 == to).map(|edge| (edge.0, edge.2)).collect();
        let neighbors = NeighborStructure::new(&list, &[]);
        graph.set_upstream(to.into(), neighbors.upstream()).unwrap();
    }
    graph.find_paths();
    look(&mut graph)
}
