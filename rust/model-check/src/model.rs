// SPDX-License-Identifier: Apache-2.0
//! The behaviors of one federation, as a model for stateright.

use stateright::{Model as _, Property};

use crate::bounds::Bounds;
use crate::federate::Federate;
use crate::graph::{FEDERATES_MAX, Graph, INSTANCES_MAX};
use crate::messages::{ToFederate, ToRti, Violation};
use crate::reduction;
use crate::rti::{Collected, Suspension};
use crate::small_tag::{SmallTag, next_tag};
use crate::state::State;
use crate::step::{Action, number};
use crate::world::World;

/// The name of the property that there is no violation.
pub(crate) const SAFETY: &str = "no violation";
/// The name of the property that all events are handled.
pub(crate) const LIVENESS: &str = "every event is handled";

/// All behaviors of one federation. See the [crate's description](crate).
#[derive(Clone, Debug)]
pub struct Model {
    world: World,
}

impl Model {
    /// Returns the model of this graph within these bounds. In a cycle without delay, the reactions of the federates
    /// run in the order of `ranks`: those of a lower one do not wait for messages of a higher one.
    ///
    /// # Panics
    /// If there are not as many ranks as federates, or a bound is greater than the tags can say: times up to 2,
    /// microsteps up to 3.
    pub fn new(graph: Graph, bounds: Bounds, ranks: &[usize]) -> Self {
        assert_eq!(ranks.len(), graph.federates(), "every federate has a rank");
        assert!(bounds.time_max <= 2 && bounds.microstep_max <= 3, "times are at most 2, microsteps at most 3");
        let mut all = [0; FEDERATES_MAX];
        all[..ranks.len()].copy_from_slice(ranks);
        Self { world: World { awaited: graph.awaited(), graph, bounds, ranks: all } }
    }
}

impl Model {
    /// Returns the state in which the federation has just started, without this federate.
    fn started(&self, absent: Option<usize>) -> State {
        let World { graph, bounds, .. } = &self.world;
        let is_there = |id: usize| id < graph.federates() && absent != Some(id);
        let mut federates = std::array::from_fn(|id| Federate::new(!is_there(id)));
        let mut up: [Vec<ToRti>; INSTANCES_MAX] = Default::default();
        for (_, up) in up.iter_mut().enumerate().filter(|(id, _)| is_there(*id)) {
            up.push(ToRti::Next(next_tag(Some(SmallTag::FIRST))));
        }
        if let Some(absent) = absent {
            for federate in &mut federates {
                federate.misses(absent);
            }
        }
        State {
            rti: Suspension::started(&self.world, absent),
            federates,
            up,
            down: Default::default(),
            own_events_left: bounds.own_events_max,
            messages_left: bounds.messages_max,
            losses_left: bounds.losses_max,
            comings_left: bounds.comings_max,
            past: None,
            violation: None,
        }
    }

    /// Returns whether anything can happen in a state. All runs are finite, so events that are left when nothing can
    /// happen are never handled. (An `eventually` of stateright would not see that in a state that another path reaches
    /// on which all events were handled before the transient federate came.)
    fn goes_on(&self, state: &State) -> bool {
        let mut actions = Vec::new();
        self.actions(state, &mut actions);
        // Only a message that the RTI does not read yet is no step.
        actions.sort_by_key(|action| matches!(action, Action::Rti(_)));
        actions.into_iter().any(|action| self.next_state(state, action).is_some())
    }
}

impl State {
    /// Passes on what the RTI has said.
    fn hear_all(&mut self, outlet: Collected) {
        for ((down, said), federate) in self.down.iter_mut().zip(outlet.said).zip(&self.federates) {
            if !federate.gone {
                down.extend(said);
            }
        }
        self.violation = outlet.violation;
    }

    /// Returns the violation if an instance begins no later than what an earlier one had completed.
    fn in_past(&self, world: &World, instance: usize, message: ToFederate) -> Option<Violation> {
        let ToFederate::Begins(tag) = message else { return None };
        let federate = number(world.federate(instance));
        let is_late = self.past.is_some_and(|past| tag <= past.tag());
        is_late.then_some(Violation::BeginsInPast { federate, tag })
    }
}

impl stateright::Model for Model {
    type State = State;
    type Action = Action;

    fn init_states(&self) -> Vec<State> {
        let transient = self.world.bounds.transient.map(usize::from);
        [None].into_iter().chain(transient.map(Some)).map(|absent| self.started(absent)).collect()
    }

    fn actions(&self, state: &State, actions: &mut Vec<Action>) {
        if state.violation.is_none() {
            reduction::actions(&self.world, state, actions);
        }
    }

    fn next_state(&self, state: &State, action: Action) -> Option<State> {
        let world = &self.world;
        let mut state = match action {
            Action::Rti(from) => {
                let from = usize::from(from);
                let (rti, outlet) = state.rti.hear(world, from, *state.up[from].first()?)?;
                let mut next = state.clone();
                next.rti = rti;
                next.up[from].remove(0);
                next.hear_all(outlet);
                return Some(next);
            }
            _ => state.clone(),
        };
        match action {
            Action::Hear(id) => {
                let id = usize::from(id);
                let message = state.down[id].remove(0);
                let (said, violation) = state.federates[id].hear(world.federate(id), message, world);
                state.up[id].extend(said);
                state.violation = violation.or(state.in_past(world, id, message));
            }
            Action::Run { instance, sends, plan } => {
                let id = usize::from(instance);
                let federate = world.federate(id);
                let run = state.federates[id].can_run(federate, world)?;
                state.messages_left -= u8::try_from(sends.count_ones()).unwrap_or(u8::MAX);
                state.own_events_left -= u8::from(plan.is_some());
                let said = state.federates[id].run(federate, run, sends, plan, world);
                state.up[id].extend(said);
            }
            Action::Lose(id) => {
                let id = usize::from(id);
                state.federates[id] = Federate::new(true);
                state.down[id].clear();
                state.up[id].push(ToRti::End);
                state.losses_left -= 1;
            }
            Action::Leave(id) => {
                let id = usize::from(id);
                state.losses_left -= u8::from(!state.federates[id].is_told_to_stop());
                let (completed, said) = state.federates[id].leave();
                state.past = state.past.max(completed.filter(|_| world.bounds.comings_max > 0));
                state.down[id].clear();
                state.up[id].extend(said);
            }
            Action::Come(id) => {
                let id = usize::from(id);
                let (rti, outlet) = state.rti.meet(world, id);
                state.rti = rti;
                state.federates[id] = Federate::joining();
                state.up[id].push(ToRti::Clock);
                state.comings_left -= 1;
                state.hear_all(outlet);
            }
            Action::Rti(_) => return None,
        }
        Some(state)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::always(SAFETY, |_, state: &State| state.violation.is_none()),
            Property::always(LIVENESS, |model: &Self, state: &State| {
                state.violation.is_some() || state.is_done() || model.goes_on(state)
            }),
        ]
    }
}
