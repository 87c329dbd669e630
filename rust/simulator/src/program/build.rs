// SPDX-License-Identifier: Apache-2.0
//! From a federate's plan to its program.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;

use lf_compiler::plan::{self, Argument, Federate, Plan, ReactionKind, TriggerKind, VariableKind};
use lf_model::time::Tag;
use lf_model::{Port, Timer};
use lf_testkit::random::mix;

use super::cells::{self, CAPACITY_MAX, Cell, Replayed};
use super::tables::{port_id, tables, trigger_id};
use super::value::{Shape, Value};
use super::{Body, Effect, InstanceId, Place, Scripted, Variable};
use crate::scenario::{Scenario, Script};
use crate::world::Side;

/// The plan asks for a queue that this program has no type for.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct BuildError {
    trigger: String,
    capacity: usize,
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is to hold {} events, and {CAPACITY_MAX} is the most here", self.trigger, self.capacity)
    }
}

/// Physical events that are known beforehand: by trigger, the tags and values.
pub(crate) type Played = BTreeMap<String, Vec<(Tag, Option<Value>)>>;

impl Scripted {
    /// The program of a federate. With `played`, stops and physical events are known beforehand.
    pub(crate) fn new(
        scenario: &Scenario,
        plan: &Plan,
        federate: &Federate,
        side: &'static Side,
        played: Option<&Played>,
    ) -> Result<Self, BuildError> {
        let mut ports: Vec<_> =
            (0..federate.ports.len()).map(|index| Place::Own(Port::new(port_id(plan::PortIndex(index))))).collect();
        let mut sources = vec![None; federate.triggers.len()];
        let mut made = Vec::new();
        for (index, trigger) in federate.triggers.iter().enumerate() {
            if let TriggerKind::Delay { fills, .. } | TriggerKind::NetworkInput { fills, .. } = trigger.kind {
                ports[fills.0] = Place::Queue(index);
            }
            if let TriggerKind::Delay { source, .. } = trigger.kind {
                sources[index] = Some(source.0);
            }
            let cell = cell(plan, federate, plan::TriggerIndex(index), trigger, played, side);
            made.push(cell.ok_or_else(|| BuildError { trigger: trigger.path.clone(), capacity: trigger.capacity })?);
        }
        let startup = federate.triggers.iter().find(|trigger| trigger.kind == TriggerKind::Startup);
        let started = |index: usize| startup.is_some_and(|it| it.reactions.iter().any(|reaction| reaction.0 == index));
        let bodies = federate.reactions.iter().enumerate();
        let bodies = bodies.map(|(index, reaction)| body(scenario, plan, federate, reaction, started(index)));
        Ok(Self {
            tables: tables(plan, federate),
            bodies: bodies.collect(),
            cells: made,
            ports,
            sources,
            states: vec![scenario.seed; federate.instances.len()],
            side,
            trace: Vec::new(),
            stops: Vec::new(),
            replayed: played.is_some(),
            handled_tardy: Vec::new(),
            mishandled: None,
        })
    }
}

fn cell(
    plan: &Plan,
    federate: &Federate,
    index: plan::TriggerIndex,
    trigger: &plan::Trigger,
    played: Option<&Played>,
    side: &'static Side,
) -> Option<Cell> {
    let id = trigger_id(index);
    match &trigger.kind {
        TriggerKind::Startup | TriggerKind::Shutdown => Some(Cell::None),
        TriggerKind::Timer { .. } => Some(Cell::Timer(Timer::new())),
        TriggerKind::Action { physical: true, .. } => match played {
            Some(played) => {
                let events: VecDeque<_> = played.get(&trigger.path).into_iter().flatten().copied().collect();
                Some(Cell::Replayed(Replayed { events, present: None }))
            }
            None => cells::physical(id, trigger.capacity),
        },
        TriggerKind::Action { .. } => cells::logical(id, trigger.capacity),
        TriggerKind::NetworkInput { input, fills } if plan.is_decentralized() && !federate.inputs[input.0].physical => {
            cells::tardy(port_id(*fills), trigger.capacity, side)
        }
        TriggerKind::Delay { fills, .. } | TriggerKind::NetworkInput { fills, .. } => {
            cells::queued(port_id(*fills), trigger.capacity)
        }
    }
}

fn body(
    scenario: &Scenario,
    plan: &Plan,
    federate: &Federate,
    reaction: &plan::ScheduledReaction,
    is_startup: bool,
) -> Option<Body> {
    let ReactionKind::Body { instance, reaction: number, arguments } = &reaction.kind else { return None };
    let path = &federate.instances[instance.0].path;
    let declared = &plan.class(&federate.instances[instance.0]).reactions[number - 1];
    let (mut reads, mut effects) = (Vec::new(), Vec::new());
    for (parameter, argument) in declared.parameters.iter().zip(arguments) {
        let variable = match argument {
            Argument::Port(port) => Variable::Port(port.0),
            Argument::Trigger(trigger) => Variable::Trigger(trigger.0),
        };
        if parameter.triggers || parameter.uses {
            reads.push(variable);
        }
        if parameter.effect {
            let shape = match &parameter.kind {
                VariableKind::Port { ty } => Shape::of(&ty.text),
                _ => Shape::Fixed(1),
            };
            let outside = match argument {
                Argument::Trigger(trigger) => scenario.outside(&federate.triggers[trigger.0].path).to_vec(),
                Argument::Port(_) => Vec::new(),
            };
            effects.push(Effect { variable, shape, outside });
        }
    }
    Some(Body {
        instance: instance.0,
        id: instance_id(path),
        number: u16::try_from(*number).unwrap_or(u16::MAX),
        reads,
        effects,
        tardy: declared.tardy.is_some(),
        script: Script::parse(&declared.body.text),
        runs: 0,
        is_startup,
    })
}

/// The instance with this path, which begins with the federate's name.
fn instance_id(path: &str) -> InstanceId {
    let name = path.split('.').next().unwrap_or_default();
    InstanceId {
        federate: name.get(1..).and_then(|digits| digits.parse().ok()).unwrap_or(usize::MAX),
        path: path.bytes().fold(0, |hash, byte| mix(hash ^ u64::from(byte))),
    }
}
