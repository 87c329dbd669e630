// SPDX-License-Identifier: Apache-2.0
//! Shrinks a scenario that violates an invariant.

use crate::check::Violation;
use crate::scenario::{Scenario, reductions};
use crate::trial::{Trial, try_scenario};

/// The maximum number of smaller scenarios to try.
const TRIALS_MAX: usize = 3000;

/// Returns the scenario after these cuts: each is the number of one of the reductions of the scenario that the previous
/// cuts leave.
pub(crate) fn cut(scenario: &Scenario, cuts: &[usize]) -> Option<Scenario> {
    let mut smaller = scenario.clone();
    for number in cuts {
        smaller = reductions(&smaller).into_iter().nth(*number)?;
    }
    Some(smaller)
}

/// Returns the smallest scenario found that violates the same invariant, and the cuts that lead to it.
pub(crate) fn shrink(scenario: &Scenario, violation: &Violation) -> (Scenario, Vec<usize>) {
    let (mut smallest, mut cuts) = (scenario.clone(), Vec::new());
    let (mut trials, mut from) = (0, 0);
    loop {
        let candidates = reductions(&smallest);
        let count = candidates.len();
        // An element that could not be removed before hardly ever can be now. So the search continues at its position,
        // and returns to the beginning once.
        let order = (from..count).chain(0..from.min(count));
        let found = order.into_iter().find_map(|number| {
            trials += 1;
            let fails = trials <= TRIALS_MAX && violates(try_quietly(&candidates[number]).as_ref(), violation);
            fails.then(|| (number, candidates[number].clone()))
        });
        match found {
            Some((number, smaller)) => {
                (smallest, from) = (smaller, number);
                cuts.push(number);
            }
            None => return (smallest, cuts),
        }
    }
}

fn violates(found: Option<&Violation>, wanted: &Violation) -> bool {
    found.is_some_and(|found| found.invariant() == wanted.invariant())
}

fn try_quietly(scenario: &Scenario) -> Option<Violation> {
    let Trial { violation, .. } = try_scenario(scenario);
    violation
}
