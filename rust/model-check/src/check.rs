// SPDX-License-Identifier: Apache-2.0
//! Visits all states of a model, and reports violations as a readable sequence of steps.

use std::fmt::Write as _;

use stateright::{Checker, Model as _};

use crate::bounds::Bounds;
use crate::graph::{Graph, permutations};
use crate::model::{LIVENESS, Model};
use crate::step::Action;

/// The extent and the findings of a check.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// The number of models: graphs, each with every order of reactions that was checked.
    pub models: u64,
    /// The number of different states.
    pub states: u64,
    /// The number of states of the largest model.
    pub states_max: u64,
    /// The violations.
    pub findings: Vec<Finding>,
}

impl Report {
    /// Adds another report to this one.
    pub fn add(&mut self, other: Self) {
        self.models += other.models;
        self.states += other.states;
        self.states_max = self.states_max.max(other.states_max);
        self.findings.extend(other.findings);
    }
}

/// A violation in one graph.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The graph.
    pub graph: Graph,
    /// The rank of each federate's reactions.
    pub ranks: Vec<usize>,
    /// The violation, and the steps that lead to it.
    pub counterexample: String,
}

/// Checks all behaviors of a graph. If it has a cycle without delay, checks at most `orders_max` orders of its
/// federates' reactions.
pub fn check(graph: Graph, bounds: Bounds, orders_max: usize) -> Report {
    let mut orders = permutations(graph.federates());
    if !graph.has_zero_delay_cycle() {
        orders.truncate(1);
    }
    // The first and the last of the permutations are opposites.
    while orders.len() > orders_max.max(1) {
        orders.remove(1.min(orders.len() - 1));
    }
    let mut report = Report::default();
    for ranks in orders {
        report.add(check_model(graph, &ranks, bounds));
    }
    report
}

fn check_model(graph: Graph, ranks: &[usize], bounds: Bounds) -> Report {
    let model = Model::new(graph, bounds, ranks);
    let checker = model.clone().checker().spawn_bfs().join();
    let states = u64::try_from(checker.unique_state_count()).unwrap_or(u64::MAX);
    let findings = checker.discoveries().into_iter().map(|(property, path)| {
        let mut counterexample = format!("violated: {property}\n");
        let end = path.last_state().clone();
        for (index, (state, action)) in path.into_vec().into_iter().enumerate() {
            let Some(action) = action else { continue };
            let heard = match action {
                Action::Rti(from) => state.up[usize::from(from)].first().map(|heard| format!(": {heard:?}")),
                Action::Hear(by) => state.down[usize::from(by)].first().map(|heard| format!(": {heard:?}")),
                _ => None,
            };
            let _ = writeln!(counterexample, "{index:3}. {action}{}", heard.unwrap_or_default());
        }
        let waits = if property == LIVENESS { "nothing leads on from here:\n" } else { "" };
        let _ = write!(counterexample, "{waits}{end:?}");
        Finding { graph, ranks: ranks.to_vec(), counterexample }
    });
    Report { models: 1, states, states_max: states, findings: findings.collect() }
}
