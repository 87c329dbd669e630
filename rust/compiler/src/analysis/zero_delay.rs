// SPDX-License-Identifier: Apache-2.0
//! Zero-delay cycles: groups of federates each of which reaches the others over connections without `after`.
//!
//! Such federates may be at one tag at the same time, and wait within it for each other's values or absences. This is
//! sound as long as no reactions wait for each other, which the order of reactions has shown.

use super::graph::{Graph, Link, LinkId};

/// The cycles of federates.
#[derive(Debug)]
pub(super) struct Cycles {
    /// Per federate, those that it reaches over at least one connection.
    reaches: Vec<Vec<bool>>,
}

impl Cycles {
    /// Returns the zero-delay cycles.
    pub(super) fn without_delay(graph: &Graph<'_>) -> Self {
        Self::over(graph, |_, link| is_immediate(link))
    }

    /// Returns all cycles, whatever the delays.
    pub(super) fn of_any_delay(graph: &Graph<'_>) -> Self {
        Self::over(graph, |_, link| link.network)
    }

    /// Returns the cycles over those connections that count, by their positions in the graph.
    pub(super) fn over(graph: &Graph<'_>, counts: impl Fn(LinkId, &Link) -> bool) -> Self {
        let count = graph.program.parts.list.len();
        let mut next: Vec<Vec<usize>> = vec![Vec::new(); count];
        for (_, link) in graph.links.iter().filter(|(position, link)| counts(*position, link)) {
            if let (Some(from), Some(to)) = (graph.part(link.from), graph.part(link.to)) {
                next[from].push(to);
            }
        }
        let reaches = (0..count).map(|start| {
            let mut reached = vec![false; count];
            let mut open = next[start].clone();
            while let Some(at) = open.pop() {
                if !std::mem::replace(&mut reached[at], true) {
                    open.extend(&next[at]);
                }
            }
            reached
        });
        Self { reaches: reaches.collect() }
    }

    /// Returns whether a federate is in a cycle.
    pub(super) fn is_in_one(&self, federate: usize) -> bool {
        self.reaches[federate][federate]
    }

    /// Returns whether two federates are in the same cycle.
    pub(super) fn is_common(&self, one: usize, other: usize) -> bool {
        self.reaches[one][other] && self.reaches[other][one]
    }
}

/// Returns whether a value arrives in another federate at the tag at which it is sent.
pub(super) fn is_immediate(link: &Link) -> bool {
    link.network && link.delay.is_none() && !link.physical
}
