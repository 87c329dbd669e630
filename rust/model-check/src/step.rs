// SPDX-License-Identifier: Apache-2.0
//! The steps of participants.

use std::fmt;

use crate::federate::Phase;
use crate::graph::{Delay, FEDERATES_MAX};
use crate::small_tag::SmallTag;
use crate::state::State;
use crate::world::World;

/// One step of one participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// The RTI reads the next message of an instance.
    Rti(u8),
    /// An instance reads the next message of the RTI.
    Hear(u8),
    /// The reactions of an instance run.
    Run {
        /// The instance.
        instance: u8,
        /// The federates that get a message, as bits.
        sends: u8,
        /// The next local event that it schedules.
        plan: Option<SmallTag>,
    },
    /// An instance is lost: its connection ends.
    Lose(u8),
    /// An instance of the transient federate leaves in order.
    Leave(u8),
    /// An instance of the transient federate comes.
    Come(u8),
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rti(from) => write!(f, "the RTI hears federate {from}"),
            Self::Hear(federate) => write!(f, "federate {federate} hears the RTI"),
            Self::Run { instance, sends, plan } => {
                let to: Vec<_> = (0..FEDERATES_MAX).filter(|to| sends >> to & 1 == 1).collect();
                write!(f, "federate {instance} runs, sends to {to:?}")?;
                plan.map_or(Ok(()), |plan| write!(f, ", plans an event at {plan:?}"))
            }
            Self::Lose(federate) => write!(f, "federate {federate} is lost"),
            Self::Leave(federate) => write!(f, "federate {federate} leaves"),
            Self::Come(federate) => write!(f, "federate {federate} comes"),
        }
    }
}

/// Adds all steps of an instance's reactions that are possible now.
pub(crate) fn runs(world: &World, state: &State, instance: usize, actions: &mut Vec<Action>) {
    let (federate, id) = (&state.federates[instance], world.federate(instance));
    let Some((at, phase)) = federate.can_run(id, world) else { return };
    let may_send = |(to, delay): (usize, Delay)| {
        let arrives = federate.is_triggered(at) && world.arrival(delay, at).is_some();
        (arrives && federate.may_send(id, phase, world, to)).then_some(1 << to)
    };
    let possible: u8 = world.graph.downstream(id).filter_map(may_send).sum();
    let plans = [None, world.arrival(Delay::Microstep, at), world.arrival(Delay::Tick, at)];
    let may_plan = state.own_events_left > 0 && phase == Phase::Rest && federate.may_plan(at);
    for sends in (0..=possible).filter(|sends| sends & !possible == 0) {
        if sends.count_ones() > u32::from(state.messages_left) {
            continue;
        }
        for (choice, plan) in plans.into_iter().enumerate() {
            if choice == 0 || (may_plan && plan.is_some()) {
                actions.push(Action::Run { instance: number(instance), sends, plan });
            }
        }
    }
}

pub(crate) fn number(federate: usize) -> u8 {
    u8::try_from(federate).unwrap_or(u8::MAX)
}
