// SPDX-License-Identifier: Apache-2.0
//! Federates that wait for each other: a cycle of connections without `after`.

use std::collections::VecDeque;

use super::graph::{Graph, Link};
use crate::diagnostics::{Code, Diagnostic, Diagnostics};
use crate::federates::Parts;

/// Reports one cycle per group of federates that wait for each other.
pub(super) fn between_federates(graph: &Graph, parts: &Parts, diagnostics: &mut Diagnostics) {
    let part = |node: usize| parts.of[graph.instance[node]].unwrap_or_default();
    let edges: Vec<(usize, usize, &Link)> = graph
        .links
        .iter()
        .filter(|link| link.network && link.delay.is_none())
        .map(|link| (part(link.from), part(link.to), link))
        .collect();
    let mut reported = vec![false; parts.list.len()];
    for start in 0..parts.list.len() {
        if reported[start] {
            continue;
        }
        let Some(cycle) = cycle_through(start, &edges, parts.list.len()) else { continue };
        let mut names: Vec<&str> = Vec::new();
        for (from, _, _) in &cycle {
            reported[*from] = true;
            names.push(&parts.list[*from].name);
        }
        names.push(&parts.list[start].name);
        let message = format!("these federates wait for each other without a delay: {}", names.join(" -> "));
        let mut diagnostic = Diagnostic::new(Code::FederateCycle, cycle[0].2.span, message).hint(
            "cycles without a delay are not supported yet: write `after` on one of the connections, \
                   for example `after 1 ms`, or `after 0` for one microstep",
        );
        for (_, _, link) in &cycle[1..] {
            diagnostic = diagnostic.also(link.span, "and this connection");
        }
        diagnostics.push(diagnostic);
    }
}

/// A shortest cycle through a federate.
fn cycle_through<'g>(
    start: usize,
    edges: &[(usize, usize, &'g Link)],
    count: usize,
) -> Option<Vec<(usize, usize, &'g Link)>> {
    let mut by: Vec<Option<usize>> = vec![None; count];
    let mut queue = VecDeque::from([start]);
    while let Some(at) = queue.pop_front() {
        for (index, (_, to, _)) in edges.iter().enumerate().filter(|(_, (from, _, _))| *from == at) {
            if by[*to].is_some() {
                continue;
            }
            by[*to] = Some(index);
            if *to == start {
                let mut path = Vec::new();
                let mut at = start;
                while let Some(edge) = by[at] {
                    path.push(edges[edge]);
                    at = edges[edge].0;
                    if at == start {
                        break;
                    }
                }
                path.reverse();
                return Some(path);
            }
            queue.push_back(*to);
        }
    }
    None
}
