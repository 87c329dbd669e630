// SPDX-License-Identifier: Apache-2.0
//! Makes a scenario that violates something as small as it gets.

use crate::check::Violation;
use crate::scenario::{Scenario, reductions};
use crate::trial::{Trial, try_scenario};

/// So many smaller scenarios are tried at most.
const TRIALS_MAX: usize = 3000;

/// The scenario after these cuts: each is the number of one of the reductions of what the cuts before have left.
pub(crate) fn cut(scenario: &Scenario, cuts: &[usize]) -> Option<Scenario> {
    let mut smaller = scenario.clone();
    for number in cuts {
        smaller = reductions(&smaller).into_iter().nth(*number)?;
    }
    Some(smaller)
}

/// The smallest scenario found that violates the same invariant, and the cuts that lead to it.
pub(crate) fn shrink(scenario: &Scenario, violation: &Violation) -> (Scenario, Vec<usize>) {
    let (mut smallest, mut cuts) = (scenario.clone(), Vec::new());
    let (mut trials, mut from) = (0, 0);
    loop {
        let candidates = reductions(&smallest);
        let count = candidates.len();
        // What could not be left out before hardly ever can be now, so that the search goes on where it is, and comes
        // back to the beginning once.
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
