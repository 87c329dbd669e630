// SPDX-License-Identifier: Apache-2.0
//! The selection of steps to explore.
//!
//! Steps of different federates, and steps of a federate and of the RTI, are independent: one reads messages from the
//! front of a connection, the other appends messages. Only two orders matter: the order in which the RTI reads the
//! federates' messages, and, for each federate, the order of its own steps. So it suffices to explore a *persistent*
//! set of steps: whatever the others do, they neither disturb nor replace a step of the set. (Godefroid, "Partial-Order
//! Methods for the Verification of Concurrent Systems", 1996; the reduction preserves all deadlocks, and a violation is
//! permanent.) In this order:
//!
//! 1. If a federate can only read a message of the RTI, it reads it: nothing else can enable another step of it.
//! 2. If a federate has a message to read and has sent none, all its steps: later messages queue behind that one.
//! 3. If every federate that can act has already sent a message, the RTI reads one of them: further messages queue
//!    behind it. The steps of federates that have sent nothing yet are added, because the RTI can read those first.
//!
//! A message that the RTI holds back does not change that: whether the RTI accepts it depends on the messages that the
//! RTI has read, and not on anything that a federate does by itself.

use crate::state::State;
use crate::step::{Action, number, runs};
use crate::world::World;

pub(crate) fn actions(world: &World, state: &State, steps: &mut Vec<Action>) {
    let all = 0..world.instances();
    let heard = |id: usize, steps: &mut Vec<Action>| {
        if !state.down[id].is_empty() {
            steps.push(Action::Hear(number(id)));
        }
    };
    if !world.bounds.reduced || state.may_change() {
        for id in all {
            heard(id, steps);
            runs(world, state, id, steps);
            rti(state, id, steps);
            goes(world, state, id, steps);
        }
        steps.extend(state.newcomer(world).map(|id| Action::Come(number(id))));
        return;
    }
    let can_run = |id: &usize| state.federates[*id].can_run(world.federate(*id), world).is_some();
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

/// Adds the ends of an instance that are possible now.
fn goes(world: &World, state: &State, id: usize, steps: &mut Vec<Action>) {
    let federate = &state.federates[id];
    let is_transient = world.is_transient(id);
    if federate.gone || (world.bounds.transient.is_some() && !is_transient) {
        return;
    }
    if state.losses_left > 0 {
        steps.push(Action::Lose(number(id)));
    }
    if is_transient && federate.may_leave() && (state.losses_left > 0 || federate.is_told_to_stop()) {
        steps.push(Action::Leave(number(id)));
    }
}

fn rti(state: &State, id: usize, steps: &mut Vec<Action>) {
    if !state.up[id].is_empty() {
        steps.push(Action::Rti(number(id)));
    }
}
