// SPDX-License-Identifier: Apache-2.0
//! The graph of the federation: the connections of the federates, and the minimum delay of every path.
//!
//! Each federate has two rows: the paths that lead to it and those that lead from it, by rising number of the federate
//! at the other end. So a change at one federate reaches exactly the federates that it can matter to.

use lf_derive::outlined;
use lf_model::time::Tag;
use lf_wire::Upstream as WireUpstream;

use super::delay::PathDelay;
use super::path::{self, Path, PathWords};
use super::tag_state::TagState;

/// Consecutive entries of the storage for paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Row {
    pub(super) start: usize,
    pub(super) len: usize,
}

impl Row {
    pub(super) const EMPTY: Self = Self { start: 0, len: 0 };
}

/// The state of one federate in the graph, and scratch space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(clippy::struct_excessive_bools, reason = "independent facts of a federate")]
pub struct Node {
    /// Immediate upstream entries in use.
    pub(super) upstreams: usize,
    /// The paths that lead to it.
    pub(super) incoming: Row,
    /// The paths that lead from it.
    pub(super) outgoing: Row,
    /// The first federate of the cycle without delay that it is in.
    pub(super) cycle: Option<u16>,
    /// Whether another federate has left the cycle without delay that this one was in.
    pub(super) deserted: bool,
    /// Whether another federate downstream of it is in a cycle without delay.
    pub(super) leads_to_cycle: bool,
    /// Whether it may come and go while the federation runs.
    #[cfg(feature = "transients")]
    pub(super) is_transient: bool,
    /// The first tag of its current incarnation, if it has joined the running federation.
    #[cfg(feature = "transients")]
    pub(super) begin: Tag,
    /// Its grants and completed tags.
    pub(super) tags: TagState,
    /// Next event: NEVER while it is unknown. Lowered by messages in transit.
    pub(super) next_event: Tag,
    /// An immediate upstream entry: the last one that had not completed enough.
    pub(super) blocking: usize,
    /// One mark for each of 64 federates: those with the numbers from 64 times that of this one on.
    marks: u64,
    /// Search: the minimum delay so far of a path from this federate.
    pub(super) delay: PathDelay,
    /// Search: an entry of the queue of federates to look at, which has as many entries as there are federates.
    pub(super) queue: u16,
    /// Search: whether this federate is in the queue.
    pub(super) queued: bool,
}

impl Node {
    /// A fresh node.
    pub const EMPTY: Self = Self {
        upstreams: 0,
        incoming: Row::EMPTY,
        outgoing: Row::EMPTY,
        cycle: None,
        deserted: false,
        leads_to_cycle: false,
        #[cfg(feature = "transients")]
        is_transient: false,
        #[cfg(feature = "transients")]
        begin: Tag::NEVER,
        tags: TagState::EMPTY,
        next_event: Tag::NEVER,
        blocking: 0,
        marks: 0,
        delay: PathDelay::NO_PATH,
        queue: 0,
        queued: false,
    };
}

impl Default for Node {
    fn default() -> Self {
        Self::EMPTY
    }
}

/// The reason to reject a neighbor structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NeighborError {
    /// There is no federate with this id.
    NoSuchFederate(u16),
    /// The delay is negative or FOREVER.
    Delay {
        /// The upstream federate.
        upstream: u16,
        /// The delay in nanoseconds.
        delay_ns: i64,
    },
    /// More upstream federates than there is storage for.
    TooMany {
        /// The maximum number.
        max: usize,
    },
}

/// The graph, in the owner's storage.
pub(super) struct Graph<'s> {
    pub(super) nodes: &'s mut [Node],
    /// The connections of each federate, `per_node` entries each.
    upstream: &'s mut [PathWords],
    per_node: usize,
    /// All rows: first those of the paths that lead to a federate, then those of the paths that lead from one.
    pub(super) paths: &'s mut [PathWords],
    /// Whether to keep up to date what the federates downstream need.
    pub(super) dnet: bool,
    /// The number of marks.
    marked: usize,
}

impl<'s> Graph<'s> {
    /// Returns a graph. `paths` has twice the square of as many entries as `nodes`, which is not empty.
    pub(super) fn new(
        nodes: &'s mut [Node],
        upstream: &'s mut [PathWords],
        paths: &'s mut [PathWords],
        dnet: bool,
    ) -> Self {
        nodes.fill(Node::EMPTY);
        Self::resume(nodes, upstream, paths, dnet)
    }

    /// Returns the graph that another one has left in its storage, while nothing was marked.
    pub(super) fn resume(
        nodes: &'s mut [Node],
        upstream: &'s mut [PathWords],
        paths: &'s mut [PathWords],
        dnet: bool,
    ) -> Self {
        let per_node = upstream.len() / nodes.len().max(1);
        Self { nodes, upstream, per_node, paths, dnet, marked: 0 }
    }

    /// Replaces the upstream connections of `federate`. Parallel connections become one, with the minimum delay.
    pub(super) fn set_upstream(&mut self, federate: usize, list: WireUpstream<'_>) -> Result<(), NeighborError> {
        self.nodes[federate].upstreams = 0;
        let count = self.nodes.len();
        let own = &mut self.upstream[federate * self.per_node..][..self.per_node];
        let mut used = 0;
        for (upstream, delay_ns) in list {
            if usize::from(upstream) >= count {
                return Err(NeighborError::NoSuchFederate(upstream));
            }
            let delay = PathDelay::of_connection(delay_ns).ok_or(NeighborError::Delay { upstream, delay_ns })?;
            let connection = Path { federate: upstream, delay, reverse: 0 };
            let known = own[..used].iter_mut().find(|known| path::federate(known) == usize::from(upstream));
            if let Some(known) = known {
                if delay < Path::read(known).delay {
                    connection.write(known);
                }
                continue;
            }
            let free = own.get_mut(used).ok_or(NeighborError::TooMany { max: self.per_node })?;
            connection.write(free);
            used += 1;
        }
        self.nodes[federate].upstreams = used;
        Ok(())
    }

    /// Returns the number of federates that are connected into `federate`.
    pub(super) fn upstreams(&self, federate: usize) -> usize {
        self.nodes[federate].upstreams
    }

    /// Returns whether a federate has joined, and begins after this tag.
    pub(super) fn begins_after(&self, federate: usize, tag: Tag) -> bool {
        #[cfg(feature = "transients")]
        return self.nodes[federate].begin > tag;
        #[cfg(not(feature = "transients"))]
        let _ = (federate, tag);
        #[cfg(not(feature = "transients"))]
        false
    }

    /// Returns whether no path leads through a federate, because it does not take part.
    pub(super) fn is_absent(&self, federate: usize) -> bool {
        #[cfg(feature = "transients")]
        return self.nodes[federate].is_transient && self.nodes[federate].tags.departed;
        #[cfg(not(feature = "transients"))]
        let _ = federate;
        #[cfg(not(feature = "transients"))]
        return false;
    }

    /// Returns whether these are the upstream connections of `federate`.
    #[cfg(feature = "transients")]
    pub(super) fn has_upstream(&self, federate: usize, list: &WireUpstream<'_>) -> bool {
        let own = || (0..self.upstreams(federate)).map(|index| self.upstream(federate, index));
        let delay = |from: usize| {
            let parallel = list.clone().filter(|(upstream, _)| usize::from(*upstream) == from);
            parallel.filter_map(|(_, delay)| PathDelay::of_connection(delay)).min()
        };
        own().all(|(from, known)| delay(from) == Some(known))
            && list.clone().all(|(from, _)| own().any(|(known, _)| known == usize::from(from)))
    }

    /// Returns one of the connections into `federate`: its origin and its delay.
    pub(super) fn upstream(&self, federate: usize, index: usize) -> (usize, PathDelay) {
        let connection = Path::read(&self.upstream[federate * self.per_node + index]);
        (connection.federate.into(), connection.delay)
    }

    /// Returns whether the federate is in a cycle without any delay.
    pub(super) fn in_zero_delay_cycle(&self, federate: usize) -> bool {
        self.nodes[federate].cycle.is_some()
    }

    /// Returns whether another federate downstream of this one is in a cycle without any delay.
    pub(super) fn leads_to_zero_delay_cycle(&self, federate: usize) -> bool {
        self.nodes[federate].leads_to_cycle
    }

    /// Returns whether two federates are in the same cycle without any delay: each reaches the other without delay.
    pub(super) fn share_zero_delay_cycle(&self, one: usize, other: usize) -> bool {
        self.nodes[one].cycle.is_some() && self.nodes[one].cycle == self.nodes[other].cycle
    }

    /// Returns the federate at the other end of a path.
    pub(super) fn other_end(&self, row: Row, index: usize) -> usize {
        path::federate(&self.paths[row.start + index])
    }

    /// Marks a federate.
    pub(super) fn mark(&mut self, federate: usize) {
        let marks = &mut self.nodes[federate / 64].marks;
        let mark = 1 << (federate % 64);
        self.marked += usize::from(*marks & mark == 0);
        *marks |= mark;
    }

    /// Takes the mark from the first marked federate. Looks at 64 federates at a time.
    pub(super) fn take_mark(&mut self) -> Option<usize> {
        if self.marked == 0 {
            return None;
        }
        let (group, node) = self.nodes.iter_mut().enumerate().find(|(_, node)| node.marks != 0)?;
        let first = group * 64 + node.marks.trailing_zeros() as usize;
        node.marks &= node.marks - 1;
        self.marked -= 1;
        Some(first)
    }
}

/// Converts the index of a federate, or of an entry of a row, which has at most as many entries as there are federates.
#[outlined]
pub(super) fn number(index: usize) -> u16 {
    let Ok(id) = u16::try_from(index) else { panic!("`Rti::new` checks that an id can name each federate") };
    id
}

#[cfg(test)]
mod tests {
    use super::*;
    use lf_wire::NeighborStructure;
    use proptest::prelude::*;
    use std::vec;
    use std::vec::Vec;

    proptest! {
        #[test]
        fn marks_are_taken_in_order(marks in proptest::collection::vec(0..200usize, 0..50)) {
            let mut nodes = vec![Node::default(); 200];
            let mut graph = Graph::new(&mut nodes, &mut [], &mut [], true);
            for mark in &marks {
                graph.mark(*mark);
            }
            let taken: Vec<_> = core::iter::from_fn(|| graph.take_mark()).collect();
            let expected: std::collections::BTreeSet<_> = marks.into_iter().collect();
            prop_assert_eq!(taken, expected.into_iter().collect::<Vec<_>>());
        }
    }

    #[test]
    fn neighbors_that_cannot_be_are_named() {
        let (mut nodes, mut upstream) = ([Node::default(); 2], [PathWords::default(); 2]);
        let mut graph = Graph::new(&mut nodes, &mut upstream, &mut [], true);
        let mut set = |list: &[(u16, i64)]| graph.set_upstream(0, NeighborStructure::new(list, &[]).upstream());
        assert_eq!(set(&[(2, 0)]), Err(NeighborError::NoSuchFederate(2)));
        assert_eq!(set(&[(1, -5)]), Err(NeighborError::Delay { upstream: 1, delay_ns: -5 }));
        assert_eq!(set(&[(1, 0), (0, 0)]), Err(NeighborError::TooMany { max: 1 }));
        assert_eq!(set(&[(1, 7), (1, 0)]), Ok(()));
        assert_eq!((graph.upstreams(0), graph.upstream(0, 0)), (1, (1, PathDelay::of_connection(0).unwrap())));
    }
}
