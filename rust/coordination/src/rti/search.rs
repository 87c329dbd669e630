// SPDX-License-Identifier: Apache-2.0
//! The search for all paths of the federation. It runs when all neighbor structures are there, and again when a
//! federate leaves a cycle without delay.

use super::delay::PathDelay;
use super::graph::{Graph, Node, Row, number};
use super::path::Path;

impl Graph<'_> {
    /// Finds all paths, once all neighbor structures are there.
    pub(super) fn find_paths(&mut self) {
        for node in self.nodes.iter_mut() {
            node.outgoing = Row::EMPTY;
        }
        let mut end = 0;
        for to in 0..self.nodes.len() {
            self.find_delays_to(to);
            let start = end;
            for from in 0..self.nodes.len() {
                let Node { delay, ref mut outgoing, .. } = self.nodes[from];
                if delay.is_path() {
                    Path { federate: number(from), delay, reverse: 0 }.write(&mut self.paths[end]);
                    outgoing.len += 1;
                    end += 1;
                }
            }
            self.nodes[to].incoming = Row { start, len: end - start };
        }
        self.transpose_rows(end);
        self.find_cycles();
        self.find_all_earliest();
    }

    /// Removes a federate: no path leads through it. Only if it was in a cycle without delay does that matter enough to
    /// look for all paths again: the others would wait for each other's answer through it.
    ///
    /// No path leads through a transient federate that is absent, whatever it is in.
    pub(super) fn cut_off(&mut self, federate: usize) {
        if self.in_zero_delay_cycle(federate) {
            let cycle = self.nodes[federate].cycle;
            for node in self.nodes.iter_mut().filter(|node| node.cycle == cycle) {
                node.deserted = true;
            }
            if !self.is_absent(federate) {
                self.nodes[federate].upstreams = 0;
            }
            self.find_paths();
        } else if self.is_absent(federate) {
            self.find_paths();
        }
    }

    /// Makes the rows of the paths that lead from each federate, whose lengths are known, from those that lead to each.
    fn transpose_rows(&mut self, start: usize) {
        let mut end = start;
        for node in self.nodes.iter_mut() {
            let start = end;
            end += node.outgoing.len;
            node.outgoing = Row { start, len: 0 };
        }
        for to in 0..self.nodes.len() {
            let incoming = self.nodes[to].incoming;
            for index in 0..incoming.len {
                let path = Path::read(&self.paths[incoming.start + index]);
                let outgoing = &mut self.nodes[usize::from(path.federate)].outgoing;
                let reverse = outgoing.len;
                outgoing.len += 1;
                let reversed = outgoing.start + reverse;
                Path { federate: number(to), reverse: number(index), ..path }.write(&mut self.paths[reversed]);
                Path { reverse: number(reverse), ..path }.write(&mut self.paths[incoming.start + index]);
            }
        }
    }

    /// Finds the cycles without delay: two federates are in the same one if there is no delay either way.
    fn find_cycles(&mut self) {
        for federate in 0..self.nodes.len() {
            let Node { incoming, outgoing, .. } = self.nodes[federate];
            let paths = |row: Row| self.paths[row.start..][..row.len].iter().map(Path::read);
            let mut back = paths(outgoing).filter(|path| path.delay == PathDelay::ZERO).peekable();
            // Both rows rise, so one pass over both suffices.
            let first = paths(incoming).filter(|path| path.delay == PathDelay::ZERO).find(|path| {
                while back.next_if(|other| other.federate < path.federate).is_some() {}
                back.peek().is_some_and(|other| other.federate == path.federate)
            });
            self.nodes[federate].cycle = first.map(|path| path.federate);
        }
        for federate in 0..self.nodes.len() {
            let row = self.nodes[federate].outgoing;
            let others = (0..row.len).map(|index| self.other_end(row, index)).filter(|other| *other != federate);
            let leads = others.into_iter().any(|other| self.nodes[other].cycle.is_some());
            self.nodes[federate].leads_to_cycle = leads;
        }
    }

    /// Goes upstream from one federate and corrects delays until none becomes smaller. Every federate is in the queue
    /// at most once, so the queue never holds more than there are; the search ends because no path with a cycle is
    /// shorter than the path without.
    fn find_delays_to(&mut self, to: usize) {
        let count = self.nodes.len();
        for node in self.nodes.iter_mut() {
            node.delay = PathDelay::NO_PATH;
        }
        let (mut head, mut waiting) = (0, 0);
        let mut at = to;
        let mut rest = PathDelay::ZERO;
        loop {
            let upstreams = if self.is_absent(at) { 0 } else { self.nodes[at].upstreams };
            for index in 0..upstreams {
                let (from, delay) = self.upstream(at, index);
                let delay = delay.then(rest);
                if delay >= self.nodes[from].delay {
                    continue;
                }
                self.nodes[from].delay = delay;
                // A path that comes back to its end is a cycle, and goes no farther.
                if from != to && !self.nodes[from].queued {
                    self.nodes[from].queued = true;
                    self.nodes[(head + waiting) % count].queue = number(from);
                    waiting += 1;
                }
            }
            if waiting == 0 {
                return;
            }
            at = self.nodes[head].queue.into();
            self.nodes[at].queued = false;
            rest = self.nodes[at].delay;
            head = (head + 1) % count;
            waiting -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{FEDERATES, edges, with_graph};
    use super::*;
    use lf_wire::DELAY_NONE;
    use proptest::prelude::*;
    use std::vec;
    use std::vec::Vec;

    /// Finds all paths by joining shorter ones until nothing changes: another way to the same matrix.
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

    /// Returns the paths of one row, by the number of the federate at the other end.
    fn row(graph: &Graph<'_>, row: Row) -> Vec<Path> {
        graph.paths[row.start..][..row.len].iter().map(Path::read).collect()
    }

    proptest! {
        #[test]
        fn the_rows_are_those_of_a_plain_relaxation(edges in edges()) {
            let expected = reference(&edges);
            let n = usize::from(FEDERATES);
            with_graph(&edges, |graph| {
                let mut found = vec![PathDelay::NO_PATH; n * n];
                for to in 0..n {
                    let incoming = row(graph, graph.nodes[to].incoming);
                    prop_assert!(incoming.is_sorted_by_key(|path| path.federate));
                    for (index, path) in incoming.iter().enumerate() {
                        found[to * n + usize::from(path.federate)] = path.delay;
                        let from = row(graph, graph.nodes[usize::from(path.federate)].outgoing);
                        prop_assert!(from.is_sorted_by_key(|path| path.federate));
                        let reversed = Path { federate: number(to), delay: path.delay, reverse: number(index) };
                        prop_assert_eq!(from[usize::from(path.reverse)], reversed);
                    }
                }
                prop_assert_eq!(&found, &expected);
                for one in 0..n {
                    for other in 0..n {
                        let back_and_forth = [expected[one * n + other], expected[other * n + one]];
                        let share = back_and_forth == [PathDelay::ZERO; 2];
                        prop_assert_eq!(graph.share_zero_delay_cycle(one, other), share);
                    }
                }
                Ok(())
            })?;
        }
    }

    /// Each federate is in the queue once, though 1 improves the paths of three that wait there already. If they were
    /// there twice, 2 would lose its place, and the path from 5 over it would not be found.
    #[test]
    fn nobody_loses_its_place_in_the_queue() {
        let direct = [(1, 0, 1), (2, 0, 5), (3, 0, 100), (4, 0, 100), (5, 0, 100)];
        let indirect = [(3, 1, 1), (4, 1, 1), (5, 1, 50), (5, 2, 1)];
        let edges: Vec<_> = direct.into_iter().chain(indirect).collect();
        with_graph(&edges, |graph| {
            let times = row(graph, graph.nodes[0].incoming).into_iter().map(|path| path.delay.parts().0);
            assert_eq!(times.collect::<Vec<_>>(), [1, 5, 2, 2, 6]);
        });
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
}
