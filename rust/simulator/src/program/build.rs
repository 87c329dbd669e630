// SPDX-License-Identifier: Apache-2.0
//! Builds a program from a federate's plan.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;

use lf_compiler::plan::{self, Argument, Federate, Plan, ReactionKind, TriggerKind, VariableKind};
use lf_compiler::tables::{Cell as PlannedCell, PortRow, Tables, TriggerRow};
use lf_model::time::Tag;
use lf_model::{ModeId, Port, PortId, Timer, Transition, TriggerId, Watchdog};
use lf_testkit::random::mix;

use super::Scripted;
use super::cells::{self, CAPACITY_MAX, Cell, Replayed};
use super::tables::{Runs, tables};
use super::taken::{Body, Effect, Group, InstanceId, Memory, PortStorage, VariableId};
use super::value::{Shape, Value};
use crate::scenario::{Scenario, Script};
use lf_testkit::world::Side;

/// The plan demands a queue that this program has no type for.
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

/// Physical events that are known in advance: by trigger, the tags and values.
pub(crate) type Played = BTreeMap<String, Vec<(Tag, Option<Value>)>>;

impl Scripted {
    /// Builds the program of a federate. With `played`, stops and physical events are known in advance.
    pub(crate) fn new(
        scenario: &Scenario,
        plan: &Plan,
        federate: &Federate,
        side: &'static Side,
        played: Option<&Played>,
        runs: Runs,
    ) -> Result<Self, BuildError> {
        let planned = Tables::of(plan, federate);
        let port = |(id, port): (u16, &PortRow<'_>)| match port.filled_by {
            Some(trigger) => PortStorage::Queue(usize::from(trigger.0)),
            None => PortStorage::Own(Port::new(PortId(id))),
        };
        let ports = (0..).zip(&planned.ports).map(port).collect();
        let sources = planned.triggers.iter().map(|trigger| trigger.captures.map(|port| usize::from(port.0)));
        let cell = |(id, trigger): (u16, &TriggerRow<'_>)| {
            let cell = cell(TriggerId(id), trigger, played, side);
            cell.ok_or_else(|| BuildError { trigger: trigger.name.to_owned(), capacity: trigger.capacity })
        };
        let mut cells = (0..).zip(&planned.triggers).map(cell).collect::<Result<Vec<_>, _>>()?;
        if scenario.has_transients() && played.is_none() {
            cells = cells.into_iter().map(|cell| cell.logged(side)).collect();
        }
        let startup = federate.triggers.iter().find(|trigger| trigger.kind == TriggerKind::Startup);
        let started = |index: usize| startup.is_some_and(|it| it.reactions.iter().any(|reaction| reaction.0 == index));
        let bodies = federate.reactions.iter().enumerate();
        let bodies = bodies.map(|(index, reaction)| body(scenario, plan, federate, reaction, started(index)));
        let bodies: Vec<_> = bodies.collect();
        Ok(Self {
            tables: tables(&planned, runs),
            groups: Group::all(planned.reactions.iter().map(|reaction| reaction.level), &bodies),
            bodies,
            last_in_turn: last_in_turn(&planned),
            copies: federate.reactions.iter().map(copy).collect(),
            memory: Memory { cells, ports, side, replayed: played.is_some() },
            sources: sources.collect(),
            states: vec![scenario.seed; federate.instances.len()],
            handed_over: planned.handed_over.iter().map(|row| row.instance.0).collect(),
            taken_over: None,
            trace: Vec::new(),
            stops: Vec::new(),
            has_left: false,
            handled_tardy: Vec::new(),
            mishandled: None,
        })
    }
}

/// Returns, by reaction, the last one of those that run in turn with it.
fn last_in_turn(planned: &Tables<'_>) -> Vec<u16> {
    let mut last: Vec<_> = (0..).zip(&planned.reactions).map(|(id, _)| id).collect();
    for id in (1..last.len()).rev() {
        if planned.runs_in_turn(id - 1) && planned.runs_in_turn(id) {
            last[id - 1] = last[id];
        }
    }
    last
}

fn cell(id: TriggerId, trigger: &TriggerRow<'_>, played: Option<&Played>, side: &'static Side) -> Option<Cell> {
    match (trigger.cell, played) {
        (PlannedCell::None, _) => Some(Cell::None),
        (PlannedCell::Timer, _) => Some(Cell::Timer(Timer::new())),
        (PlannedCell::Physical, Some(played)) => {
            let events: VecDeque<_> = played.get(trigger.name).into_iter().flatten().copied().collect();
            Some(Cell::Replayed(Replayed { events, present: None }))
        }
        (PlannedCell::Physical, None) => cells::physical(id, trigger.capacity),
        (PlannedCell::Watchdog, _) => Some(Cell::Watchdog(Watchdog::new(id))),
        (PlannedCell::Logical, _) => cells::logical(id, trigger.capacity),
        (PlannedCell::Tardy(fills), _) => cells::tardy(fills, trigger.capacity, side),
        (PlannedCell::Queued(fills), _) => cells::queued(fills, trigger.capacity),
    }
}

/// Returns the ports of a connection that copies.
fn copy(reaction: &plan::ScheduledReaction) -> Option<(usize, usize)> {
    let ReactionKind::Copy { from, to } = reaction.kind else { return None };
    Some((from.0, to.0))
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
        let variables: Vec<_> = match argument {
            Argument::Trigger(trigger) => vec![VariableId::Trigger(trigger.0)],
            Argument::Mode(mode) => {
                let mode = ModeId(u16::try_from(mode.0).unwrap_or(u16::MAX));
                let is_history = matches!(parameter.kind, VariableKind::Mode { history: true });
                vec![VariableId::Mode(if is_history { Transition::history(mode) } else { Transition::reset(mode) })]
            }
            Argument::Port(_) | Argument::Ports(_) | Argument::Bank { .. } => {
                argument.ports().iter().map(|port| VariableId::Port(port.0)).collect()
            }
        };
        if parameter.triggers || parameter.uses {
            reads.extend(&variables);
        }
        for variable in variables.into_iter().filter(|_| parameter.effect) {
            let shape = match &parameter.kind {
                VariableKind::Port { ty } | VariableKind::Multiport { ty } => Shape::of(&ty.text),
                _ => Shape::Fixed(1),
            };
            let outside = match argument {
                Argument::Trigger(trigger) => scenario.outside(&federate.triggers[trigger.0].path).to_vec(),
                Argument::Port(_) | Argument::Ports(_) | Argument::Bank { .. } | Argument::Mode(_) => Vec::new(),
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

/// Returns the instance with this path, which begins with the federate's name.
fn instance_id(path: &str) -> InstanceId {
    let name = path.split('.').next().unwrap_or_default();
    InstanceId {
        federate: name.get(1..).and_then(|digits| digits.parse().ok()).unwrap_or(usize::MAX),
        path: path.bytes().fold(0, |hash, byte| mix(hash ^ u64::from(byte))),
    }
}
