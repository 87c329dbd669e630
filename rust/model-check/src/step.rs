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
    /// The RTI reads the next message of a federate.
    Rti(u8),
    /// A federate reads the next message of the RTI.
    Hear(u8),
    /// The reactions of a federate run.
    Run {
        /// The federate.
        federate: u8,
        /// The federates that get a message, as bits.
        sends: u8,
        /// The next local event that it schedules.
        plan: Option<SmallTag>,
    },
    /// A federate is lost: its connection ends.
    Lose(u8),
    /// The transient federate leaves in order.
    Leave(u8),
    /// The transient federate comes.
    Come(u8),
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
            Self::Leave(federate) => write!(f, "federate {federate} leaves"),
            Self::Come(federate) => write!(f, "federate {federate} comes"),
        }
    }
}

/// Adds all steps of a federate's reactions that are possible now.
pub(crate) fn runs(world: &World, state: &State, id: usize, actions: &mut Vec<Action>) {
    let federate = &state.federates[id];
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
                actions.push(Action::Run { federate: number(id), sends, plan });
            }
        }
    }
}

pub(crate) fn number(federate: usize) -> u8 {
    u8::try_from(federate).unwrap_or(u8::MAX)
}
