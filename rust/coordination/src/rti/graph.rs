// SPDX-License-Identifier: Apache-2.0
//! The graph of the federation: who is connected to whom, and the least delay of every path.

use lf_wire::june_2026::Upstream as WireUpstream;

use super::delay::PathDelay;

/// One connection into a federate: where from and with what delay. Parallel connections are one, with the least delay.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Upstream {
    federate: u16,
    delay: PathDelay,
}

impl Upstream {
    /// What fresh storage holds.
    pub const EMPTY: Self = Self { federate: 0, delay: PathDelay::EMPTY };

    pub(super) fn federate(self) -> usize {
        self.federate.into()
    }

    pub(super) fn delay(self) -> PathDelay {
        self.delay
    }
}

/// What one federate contributes to the graph, and scratch space for the search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Node {
    /// Upstream entries in use.
    upstreams: usize,
    in_zero_delay_cycle: bool,
    /// Search: an entry of the queue of federates to look at, which has as many entries as there are federates.
    queue: u16,
    /// Search: this federate is in the queue.
    queued: bool,
}

impl Node {
    /// What fresh storage holds.
    pub const EMPTY: Self = Self { upstreams: 0, in_zero_delay_cycle: false, queue: 0, queued: false };
}

/// Why a neighbor structure was not accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NeighborError {
    /// There is no federate with this id.
    NoSuchFederate(u16),
    /// The delay is negative, or for ever.
    Delay {
        /// The upstream federate.
        upstream: u16,
        /// The delay in nanoseconds.
        delay_ns: i64,
    },
    /// More upstream federates than there is storage for.
    TooMany {
        /// Most that there can be.
        max: usize,
    },
}

/// The graph, in storage that its owner gives.
pub(super) struct Graph<'s> {
    nodes: &'s mut [Node],
    /// As many entries for each federate as `per_node` says.
    upstream: &'s mut [Upstream],
    per_node: usize,
    /// Row by row the delays *to* one federate, so that what can reach it lies together.
    delays: &'s mut [PathDelay],
}

impl<'s> Graph<'s> {
    /// `delays` has the square of as many entries as `nodes`, which is not empty.
    pub(super) fn new(nodes: &'s mut [Node], upstream: &'s mut [Upstream], delays: &'s mut [PathDelay]) -> Self {
        let per_node = upstream.len() / nodes.len().max(1);
        nodes.fill(Node::default());
        delays.fill(PathDelay::NO_PATH);
        Self { nodes, upstream, per_node, delays }
    }

    /// The graph that another one has left in this storage.
    pub(super) fn resume(nodes: &'s mut [Node], upstream: &'s mut [Upstream], delays: &'s mut [PathDelay]) -> Self {
        let per_node = upstream.len() / nodes.len().max(1);
        Self { nodes, upstream, per_node, delays }
    }

    /// Takes the upstream connections of `federate` in place of those it had.
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
            if let Some(known) = own[..used].iter_mut().find(|known| known.federate == upstream) {
                known.delay = known.delay.min(delay);
                continue;
            }
            let free = own.get_mut(used).ok_or(NeighborError::TooMany { max: self.per_node })?;
            *free = Upstream { federate: upstream, delay };
            used += 1;
        }
        self.nodes[federate].upstreams = used;
        Ok(())
    }

    /// The connections into `federate`.
    pub(super) fn upstream(&self, federate: usize) -> &[Upstream] {
        &self.upstream[federate * self.per_node..][..self.nodes[federate].upstreams]
    }

    /// The least delay of all paths from one federate to another, or to itself if it is in a cycle.
    pub(super) fn delay(&self, from: usize, to: usize) -> PathDelay {
        self.delays[to * self.nodes.len() + from]
    }

    /// The least delays of all paths to one federate, by the federate where they begin.
    pub(super) fn delays_to(&self, to: usize) -> &[PathDelay] {
        let count = self.nodes.len();
        &self.delays[to * count..][..count]
    }

    /// Whether the federate is in a cycle without any delay.
    pub(super) fn in_zero_delay_cycle(&self, federate: usize) -> bool {
        self.nodes[federate].in_zero_delay_cycle
    }

    /// Whether two federates are in the same cycle without any delay: each reaches the other without delay.
    pub(super) fn share_zero_delay_cycle(&self, one: usize, other: usize) -> bool {
        self.delay(one, other) == PathDelay::ZERO && self.delay(other, one) == PathDelay::ZERO
    }

    /// Works out the delays of all paths, once all neighbor structures are there.
    pub(super) fn find_paths(&mut self) {
        for to in 0..self.nodes.len() {
            self.find_paths_to(to);
            self.nodes[to].in_zero_delay_cycle = self.delay(to, to) == PathDelay::ZERO;
        }
    }

    /// Goes upstream from one federate and corrects delays until none becomes less. Every federate is in the queue at
    /// most once, so the queue never holds more than there are; it ends because no path with a cycle is less than the
    /// path without.
    fn find_paths_to(&mut self, to: usize) {
        let count = self.nodes.len();
        let row = to * count;
        self.delays[row..][..count].fill(PathDelay::NO_PATH);
        let (mut head, mut waiting) = (0, 0);
        let mut at = to;
        let mut rest = PathDelay::ZERO;
        loop {
            for index in 0..self.nodes[at].upstreams {
                let connection = self.upstream[at * self.per_node + index];
                let from = connection.federate();
                let delay = connection.delay.then(rest);
                if delay >= self.delays[row + from] {
                    continue;
                }
                self.delays[row + from] = delay;
                // A path that comes back to where it ends is a cycle, and goes no farther.
                if from != to && !self.nodes[from].queued {
                    self.nodes[from].queued = true;
                    self.nodes[(head + waiting) % count].queue = connection.federate;
                    waiting += 1;
                }
            }
            if waiting == 0 {
                return;
            }
            at = self.nodes[head].queue.into();
            self.nodes[at].queued = false;
            rest = self.delays[row + at];
            head = (head + 1) % count;
            waiting -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lf_wire::june_2026::{DELAY_NONE, NeighborStructure};
    use proptest::prelude::*;
    use std::vec;
    use std::vec::Vec;

    const FEDERATES: u16 = 6;

    fn edges() -> impl Strategy<Value = Vec<(u16, u16, i64)>> {
        let delay = prop_oneof![Just(DELAY_NONE), Just(0), 1..20i64];
        proptest::collection::vec((0..FEDERATES, 0..FEDERATES, delay), 0..20)
    }

    fn with_graph<R>(edges: &[(u16, u16, i64)], look: impl FnOnce(&Graph<'_>) -> R) -> R {
        let n = usize::from(FEDERATES);
        let (mut nodes, mut upstream) = (vec![Node::default(); n], vec![Upstream::default(); n * n]);
        let mut delays = vec![PathDelay::default(); n * n];
        let mut graph = Graph::new(&mut nodes, &mut upstream, &mut delays);
        for to in 0..FEDERATES {
            let list: Vec<_> = edges.iter().filter(|edge| edge.1 == to).map(|edge| (edge.0, edge.2)).collect();
            let neighbors = NeighborStructure::new(&list, &[]);
            graph.set_upstream(to.into(), neighbors.upstream()).unwrap();
        }
        graph.find_paths();
        look(&graph)
    }

    /// All paths by joining shorter ones, until nothing changes: another way to the same matrix.
    fn reference(edges: &[(u16, u16, i64)]) -> Vec<PathDelay> {
        let n = usize::from(FEDERATES);
        let mut matrix = vec![PathDelay::NO_PATH; n * n];
        for _ in 0..=2 * n {
            for &(from, to, delay) in edges {
                let connection = PathDelay::of_connection(delay).unwrap();
                for end in 0..n {
                    let rest = if end == usize::from(to) { PathDelay::ZERO } else { matrix[end * n + usize::from(to)] };
                    let entry = &mut matrix[end * n + usize::from(from)];
                    *entry = (*entry).min(connection.then(rest));
                }
            }
        }
        matrix
    }

    proptest! {
        #[test]
        fn the_matrix_is_that_of_a_plain_relaxation(edges in edges()) {
            let expected = reference(&edges);
            with_graph(&edges, |graph| {
                prop_assert_eq!(&graph.delays[..], &expected[..]);
                Ok(())
            })?;
        }
    }

    #[test]
    fn only_a_cycle_without_any_delay_counts_as_one() {
        let zero = with_graph(&[(0, 1, DELAY_NONE), (1, 0, DELAY_NONE), (1, 2, DELAY_NONE)], |graph| {
            [0, 1, 2].map(|federate| graph.in_zero_delay_cycle(federate))
        });
        assert_eq!(zero, [true, true, false]);
        let microstep = with_graph(&[(0, 1, DELAY_NONE), (1, 0, 0)], |graph| graph.in_zero_delay_cycle(0));
        assert!(!microstep);
    }

    #[test]
    fn cycles_without_delay_that_are_linked_one_way_are_two() {
        let edges = [(0, 1), (1, 0), (2, 3), (3, 2), (1, 2)].map(|(from, to)| (from, to, DELAY_NONE));
        with_graph(&edges, |graph| {
            assert!((0..4).all(|federate| graph.in_zero_delay_cycle(federate)));
            assert!(graph.share_zero_delay_cycle(0, 1) && graph.share_zero_delay_cycle(3, 2));
            assert!(!graph.share_zero_delay_cycle(1, 2) && !graph.share_zero_delay_cycle(2, 1));
        });
    }

    #[test]
    fn neighbors_that_cannot_be_are_named() {
        let (mut nodes, mut upstream) = ([Node::default(); 2], [Upstream::default(); 2]);
        let mut delays = [PathDelay::default(); 4];
        let mut graph = Graph::new(&mut nodes, &mut upstream, &mut delays);
        let mut set = |list: &[(u16, i64)]| graph.set_upstream(0, NeighborStructure::new(list, &[]).upstream());
        assert_eq!(set(&[(2, 0)]), Err(NeighborError::NoSuchFederate(2)));
        assert_eq!(set(&[(1, -5)]), Err(NeighborError::Delay { upstream: 1, delay_ns: -5 }));
        assert_eq!(set(&[(1, 0), (0, 0)]), Err(NeighborError::TooMany { max: 1 }));
        assert_eq!(set(&[(1, 7), (1, 0)]), Ok(()));
        assert_eq!(graph.upstream(0)[0].delay(), PathDelay::of_connection(0).unwrap());
    }
}
