// SPDX-License-Identifier: Apache-2.0
//! All that can happen in one federation.

use std::fmt;

use lf_model::time::Tag;
use stateright::Property;

use crate::bounds::Bounds;
use crate::federate::{Federate, Phase};
use crate::graph::{Delay, FEDERATES_MAX, Graph};
use crate::moment::{Moment, START};
use crate::reduction;
use crate::rti::{Suspension, next_tag};
use crate::state::{State, Up};

/// Name of the property that no promise is broken.
pub(crate) const SAFETY: &str = "no promise is broken";
/// Name of the property that all events are handled.
pub(crate) const LIVENESS: &str = "every event is handled";

/// What does not change while a federation runs.
#[derive(Clone, Debug)]
pub(crate) struct World {
    pub(crate) graph: Graph,
    pub(crate) bounds: Bounds,
    awaited: [[bool; FEDERATES_MAX]; FEDERATES_MAX],
    ranks: [usize; FEDERATES_MAX],
}

impl World {
    pub(crate) fn has_upstream(&self, id: usize) -> bool {
        self.graph.upstream(id).next().is_some()
    }

    /// The federates whose messages a federate may have to wait for within a tag.
    pub(crate) fn awaited(&self, to: usize) -> impl Iterator<Item = usize> {
        (0..self.graph.federates()).filter(move |from| self.awaited[*from][to])
    }

    pub(crate) fn is_awaited(&self, from: usize, to: usize) -> bool {
        self.awaited[from][to]
    }

    /// The place of a federate's reactions among those of its cycle.
    pub(crate) fn rank(&self, id: usize) -> usize {
        self.ranks[id]
    }

    /// This tag, if it is within the bounds.
    pub(crate) fn moment(&self, tag: Tag) -> Option<Moment> {
        let Bounds { time_max, microstep_max, .. } = self.bounds;
        let time = u8::try_from(tag.time.as_nanos().checked_sub(START.as_nanos())?).ok()?;
        let microstep = u8::try_from(tag.microstep.0).ok()?;
        (time <= time_max && microstep <= microstep_max).then(|| Moment::new(time, microstep))
    }

    /// A tag that is later than all within the bounds: which one it is makes no difference to anybody.
    pub(crate) fn end(&self) -> Tag {
        Moment::new(self.bounds.time_max + 1, 0).tag()
    }

    /// When a message arrives that is sent at `at`, if that is within the bounds.
    fn arrival(&self, delay: Delay, at: Moment) -> Option<Moment> {
        let within = match delay {
            Delay::Zero => true,
            Delay::Microstep => at.microstep() < self.bounds.microstep_max,
            Delay::Tick => at.time() < self.bounds.time_max,
        };
        within.then(|| delay.after(at))
    }
}

/// All that can happen in one federation. See the [crate's description](crate).
#[derive(Clone, Debug)]
pub struct Model {
    world: World,
}

/// One step of one participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// The RTI hears the next message of a federate.
    Rti(u8),
    /// A federate hears the next message of the RTI.
    Hear(u8),
    /// The reactions of a federate run.
    Run {
        /// The federate.
        federate: u8,
        /// The federates that get a message, as bits.
        sends: u8,
        /// The next event of its own that it plans.
        plan: Option<Moment>,
    },
    /// A federate is lost: its connection ends.
    Lose(u8),
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rti(from) => write!(f, "the RTI hears federate {from}"),
            Self::Hear(federate) => write!(f, "federate {federate} hears the RTI"),
            Self::Run { federate, sends, plan } => {
                let to: Vec<_> = (0..FEDERATES_MAX).filter(|to| sends >> to & 1 == 1).collect();
                write!(f, "federate {federate} runs, sends to {to:?}")?;
                plan.map_or(Ok(()), |plan| write!(f, ", plans an event at {plan:?}"))
            }
            Self::Lose(federate) => write!(f, "federate {federate} is lost"),
        }
    }
}

impl Model {
    /// All that can happen in this graph within these bounds. In a cycle without delay, the reactions of the federates
    /// come in the order of `ranks`: those of a lower one wait for nothing that those of a higher one send.
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

    /// What can happen from here on, without what the reduction leaves out.
    pub(crate) fn world(&self) -> &World {
        &self.world
    }

    /// All that the reactions of a federate can do now.
    pub(crate) fn runs(&self, state: &State, id: usize, actions: &mut Vec<Action>) {
        let federate = &state.federates[id];
        let Some((at, phase)) = federate.can_run(id, &self.world) else { return };
        let may_send = |(to, delay): (usize, Delay)| {
            let arrives = federate.is_triggered(at) && self.world.arrival(delay, at).is_some();
            (arrives && federate.may_send(id, phase, &self.world, to)).then_some(1 << to)
        };
        let possible: u8 = self.world.graph.downstream(id).filter_map(may_send).sum();
        let plans = [None, self.world.arrival(Delay::Microstep, at), self.world.arrival(Delay::Tick, at)];
        let may_plan = state.own_events_left > 0 && phase == Phase::Rest && federate.may_plan(at);
        for sends in (0..=possible).filter(|sends| sends & !possible == 0) {
            if sends.count_ones() > u32::from(state.messages_left) {
                continue;
            }
            for (choice, plan) in plans.into_iter().enumerate() {
                if choice == 0 || (may_plan && plan.is_some()) {
                    actions.push(Action::Run { federate: number(id), sends, plan });
                }
            }
        }
    }
}

impl stateright::Model for Model {
    type State = State;
    type Action = Action;

    fn init_states(&self) -> Vec<State> {
        let World { graph, bounds, .. } = &self.world;
        let federates = std::array::from_fn(|id| Federate::new(id >= graph.federates()));
        let mut up: [Vec<Up>; FEDERATES_MAX] = Default::default();
        for up in &mut up[..graph.federates()] {
            up.push(Up::Next(next_tag(Some(Moment::FIRST))));
        }
        let rti = Suspension::started(graph, bounds);
        vec![State {
            rti,
            federates,
            up,
            down: Default::default(),
            own_events_left: bounds.own_events_max,
            messages_left: bounds.messages_max,
            losses_left: bounds.losses_max,
            broken: None,
        }]
    }

    fn actions(&self, state: &State, actions: &mut Vec<Action>) {
        if state.broken.is_none() {
            reduction::actions(self, state, actions);
        }
    }

    fn next_state(&self, state: &State, action: Action) -> Option<State> {
        let World { bounds, .. } = &self.world;
        let mut state = match action {
            Action::Rti(from) => {
                let from = usize::from(from);
                let (rti, outlet) = state.rti.hear(from, *state.up[from].first()?, bounds)?;
                let mut next = state.clone();
                next.rti = rti;
                next.up[from].remove(0);
                for ((down, said), federate) in next.down.iter_mut().zip(outlet.said).zip(&next.federates) {
                    if !federate.gone {
                        down.extend(said);
                    }
                }
                next.broken = outlet.broken;
                return Some(next);
            }
            _ => state.clone(),
        };
        match action {
            Action::Hear(id) => {
                let id = usize::from(id);
                let message = state.down[id].remove(0);
                let (said, broken) = state.federates[id].hear(id, message, &self.world);
                state.up[id].extend(said);
                state.broken = broken;
            }
            Action::Run { federate, sends, plan } => {
                let id = usize::from(federate);
                let run = state.federates[id].can_run(id, &self.world)?;
                state.messages_left -= u8::try_from(sends.count_ones()).unwrap_or(u8::MAX);
                state.own_events_left -= u8::from(plan.is_some());
                let said = state.federates[id].run(id, run, sends, plan, &self.world);
                state.up[id].extend(said);
            }
            Action::Lose(id) => {
                let id = usize::from(id);
                state.federates[id] = Federate::new(true);
                state.down[id].clear();
                state.up[id].push(Up::End);
                state.losses_left -= 1;
            }
            Action::Rti(_) => return None,
        }
        Some(state)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::always(SAFETY, |_, state: &State| state.broken.is_none()),
            Property::eventually(LIVENESS, |_, state: &State| state.broken.is_some() || state.is_done()),
        ]
    }
}

pub(crate) fn number(federate: usize) -> u8 {
    u8::try_from(federate).unwrap_or(u8::MAX)
}
