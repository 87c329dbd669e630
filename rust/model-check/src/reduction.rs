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
    let federates = world.graph.federates();
    let all = 0..federates;
    let heard = |id: usize, steps: &mut Vec<Action>| {
        if !state.down[id].is_empty() {
            steps.push(Action::Hear(number(id)));
        }
    };
    let transient = world.bounds.transient.map(usize::from);
    if !world.bounds.reduced || state.losses_left > 0 || state.comings_left > 0 {
        for id in all {
            heard(id, steps);
            runs(world, state, id, steps);
            rti(state, id, steps);
            let federate = &state.federates[id];
            if state.losses_left > 0 && !federate.gone && transient.is_none_or(|transient| transient == id) {
                steps.push(Action::Lose(number(id)));
                if transient.is_some() && federate.may_leave() {
                    steps.push(Action::Leave(number(id)));
                }
            }
            if state.comings_left > 0 && transient == Some(id) && federate.gone && state.up[id].is_empty() {
                steps.push(Action::Come(number(id)));
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
