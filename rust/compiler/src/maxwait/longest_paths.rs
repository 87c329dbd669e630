// SPDX-License-Identifier: Apache-2.0
//! The least solution of `S_j = max(0, max over edges of S_i + weight)`: longest paths, found edge by edge.

use std::collections::BTreeSet;

use serde::Serialize;

/// The smallest safe offset of a federate.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FederateOffset {
    /// The federate.
    pub name: String,
    /// The offset in nanoseconds; `None` if a cycle makes every offset too short.
    pub offset_ns: Option<i64>,
    /// The connections that demand it, the last one into this federate; positions in
    /// [`Offsets::connections`](super::Offsets::connections). It is empty if none does.
    pub path: Vec<usize>,
}

/// An edge of a graph whose nodes have numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Edge {
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) weight: i64,
}

/// The least solution.
#[derive(Debug)]
pub(super) struct LongestPaths {
    /// Per node; `None` behind a cycle whose weights add up to more than 0.
    pub(super) offsets: Vec<Option<i64>>,
    /// Such cycles, as the positions of their edges in order; at least one before each node without an offset.
    pub(super) cycles: Vec<Vec<usize>>,
    /// Per node, the edge that demands its offset; `None` where 0 is enough.
    demanded_by: Vec<Option<usize>>,
}

impl LongestPaths {
    pub(super) fn of(nodes: usize, edges: &[Edge]) -> Self {
        // Sums of nanoseconds over paths without repetition fit.
        let mut lengths = vec![0_i128; nodes];
        let mut demanded_by: Vec<Option<usize>> = vec![None; nodes];
        let mut relax = |lengths: &mut Vec<i128>| -> Vec<usize> {
            let mut grown = Vec::new();
            for (position, edge) in edges.iter().enumerate() {
                let length = lengths[edge.from] + i128::from(edge.weight);
                if length > lengths[edge.to] {
                    lengths[edge.to] = length;
                    demanded_by[edge.to] = Some(position);
                    grown.push(edge.to);
                }
            }
            grown
        };
        // A path without repetition has fewer edges than there are nodes, so an offset that grows after that is in a
        // cycle or behind one. The further rounds make every such cycle visible on the way back.
        let mut growing = Vec::new();
        for _ in 0..=nodes {
            growing = relax(&mut lengths);
            if growing.is_empty() {
                break;
            }
        }
        let without = reachable(nodes, edges, &growing);
        let cycles = find_cycles(edges, &growing, &demanded_by);
        let offsets = lengths.iter().zip(&without).map(|(length, without)| {
            let length = i64::try_from(*length).unwrap_or(i64::MAX);
            (!without).then_some(length)
        });
        Self { offsets: offsets.collect(), cycles, demanded_by }
    }

    /// Returns the edges that demand a node's offset, the last one into the node; none without an offset.
    pub(super) fn path(&self, node: usize, edges: &[Edge]) -> Vec<usize> {
        let mut path = Vec::new();
        let mut at = node;
        while let Some(edge) = self.demanded_by[at].filter(|_| self.offsets[at].is_some()) {
            path.push(edge);
            at = edges[edge].from;
        }
        path.reverse();
        path
    }
}

fn reachable(nodes: usize, edges: &[Edge], from: &[usize]) -> Vec<bool> {
    let mut reached = vec![false; nodes];
    let mut open = from.to_vec();
    while let Some(node) = open.pop() {
        if !std::mem::replace(&mut reached[node], true) {
            open.extend(edges.iter().filter(|edge| edge.from == node).map(|edge| edge.to));
        }
    }
    reached
}

/// Follows edges back from nodes that still grow, until a node repeats.
fn find_cycles(edges: &[Edge], growing: &[usize], demanded_by: &[Option<usize>]) -> Vec<Vec<usize>> {
    let mut found: Vec<Vec<usize>> = Vec::new();
    let mut seen = BTreeSet::new();
    for start in growing {
        let (mut at, mut passed) = (*start, Vec::new());
        while let Some(edge) = demanded_by[at] {
            if let Some(begin) = passed.iter().position(|(node, _)| *node == at) {
                let mut cycle: Vec<usize> = passed[begin..].iter().map(|(_, edge)| *edge).collect();
                cycle.reverse();
                // The same cycle can be found at any of its nodes.
                let least = cycle.iter().enumerate().min_by_key(|(_, edge)| **edge).map_or(0, |(place, _)| place);
                cycle.rotate_left(least);
                if seen.insert(cycle.clone()) {
                    found.push(cycle);
                }
                break;
            }
            passed.push((at, edge));
            at = edges[edge].from;
        }
    }
    found.sort();
    found
}
