// SPDX-License-Identifier: Apache-2.0
//! Which of all steps are looked at.
//!
//! Steps of different federates, and steps of a federate and of the RTI, do not disturb each other: one takes messages
//! from the front of a connection, the other puts messages behind them. Only the order matters in which the RTI hears
//! the federates, and, for each federate, the order of what it hears and what it does. So it suffices to look at a
//! *persistent* set of steps: whatever the others do, they neither disturb nor replace a step of the set. (Godefroid,
//! "Partial-Order Methods for the Verification of Concurrent Systems", 1996; it keeps all states from which nothing
//! leads on, and a broken promise stays broken.) In this order:
//!
//! 1. A federate that can do nothing but hear the RTI hears it: it can do something else only because of that.
//! 2. A federate with something to hear and nothing to say: all its steps. What comes later comes behind what it hears.
//! 3. The RTI hears somebody, if everybody that can do something has said something already: what they do now comes
//!    behind it. The steps of those that have said nothing yet are added, for they can be heard first.
//!
//! A message that the RTI leaves for later changes nothing about that: whether it is heard depends on what the RTI has
//! heard, and on nothing that a federate does by itself.

use crate::state::State;
use crate::step::{Action, number, runs};
use crate::world::World;

pub(crate) fn actions(world: &World, state: &State, steps: &mut Vec<Action>) {
    let federates = world.graph.federates();
    let all = 0..federates;
    let heard = |id: usize, steps: &mut Vec<Action>| {
        if !state.down[id].is_empty() {
            steps.push(Action::Hear(number(id)));
        }
    };
    if !world.bounds.reduced || state.losses_left > 0 {
        for id in all {
            heard(id, steps);
            runs(world, state, id, steps);
            rti(state, id, steps);
            if state.losses_left > 0 && !state.federates[id].gone {
                steps.push(Action::Lose(number(id)));
            }
        }
        return;
    }
    let can_run = |id: &usize| state.federates[*id].can_run(*id, world).is_some();
    let is_logged = |id: &usize| !state.down[*id].is_empty();
    if let Some(id) = all.clone().find(|id| is_logged(id) && !can_run(id)) {
        heard(id, steps);
        return;
    }
    if let Some(id) = all.clone().find(|id| is_logged(id) && state.up[*id].is_empty()) {
        heard(id, steps);
        runs(world, state, id, steps);
        return;
    }
    for id in all {
        rti(state, id, steps);
        if state.up[id].is_empty() {
            runs(world, state, id, steps);
        }
    }
}

fn rti(state: &State, id: usize, steps: &mut Vec<Action>) {
    if !state.up[id].is_empty() {
        steps.push(Action::Rti(number(id)));
    }
}
