// SPDX-License-Identifier: Apache-2.0
//! A running body, with all state that it changes, separate from the rest of the program, which it can only read. So
//! several bodies can run in parallel, and one alone behaves the same.

use std::collections::BTreeMap;
use std::time::Duration;

use lf_model::prelude::{After, Asap};
use lf_model::time::{Interval, Tag};
use lf_model::{PhysicalActionRef, Port, ReactionContext, ReactionId, Readable, TriggerId};
use lf_testkit::random::combine;
use lf_testkit::world::{Side, Thread};

use super::cells::Cell;
use super::tables::keep;
use super::value::{Shape, Value};
use crate::scenario::Script;

/// The number of reactions in a row that a thread's events can cause.
const THREAD_ENERGY: u64 = 4;

/// An instance of a reactor, the same one whether federated or not.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct InstanceId {
    pub(crate) federate: usize,
    /// A hash of its path.
    pub(crate) path: u64,
}

/// The inputs of a reaction, with its tag and state.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Record {
    pub(crate) tag: Tag,
    pub(crate) instance: InstanceId,
    /// The reaction's number in its reactor, from 1.
    pub(crate) reaction: u16,
    /// A hash of all its inputs and the state.
    pub(crate) digest: u64,
    /// Whether its federate's last tag was running.
    pub(crate) last_tag: bool,
    /// The duration of the reaction.
    pub(crate) work_ns: u64,
}

/// The state that reactions share.
pub(super) struct Memory {
    pub(super) cells: Vec<Cell>,
    pub(super) ports: Vec<PortStorage>,
    pub(super) side: &'static Side,
    /// Whether stops and physical events are known in advance, and reactions do not cause them.
    pub(super) replayed: bool,
}

/// The location of a port's value.
pub(super) enum PortStorage {
    Own(Port<Value>),
    /// In the cell of this trigger.
    Queue(usize),
    /// In a body that runs.
    Taken,
}

/// A reaction with a body.
pub(super) struct Body {
    pub(super) instance: usize,
    pub(super) id: InstanceId,
    /// The reaction's number in its reactor, from 1.
    pub(super) number: u16,
    pub(super) reads: Vec<VariableId>,
    pub(super) effects: Vec<Effect>,
    /// Whether it has a handler for tardy inputs.
    pub(super) tardy: bool,
    pub(super) script: Script,
    pub(super) runs: u64,
    pub(super) is_startup: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum VariableId {
    Port(usize),
    Trigger(usize),
    Mode(lf_model::Transition),
}

pub(super) struct Effect {
    pub(super) variable: VariableId,
    pub(super) shape: Shape,
    /// The times at which threads schedule a physical action, in nanoseconds after their start.
    pub(super) outside: Vec<i64>,
}

/// A variable that a body has taken out of the memory while it runs.
pub(super) enum TakenVariable {
    Port(PortStorage),
    Trigger(Cell),
}

/// The reactions of one instance at one level: several, if they are in different modes.
#[derive(Clone, Copy)]
pub(super) struct Group {
    pub(super) level: u16,
    pub(super) reactions: &'static [ReactionId],
    /// The actions that they can schedule.
    pub(super) actions: &'static [TriggerId],
}

impl Group {
    /// Returns the groups of a program, in the order of their first reactions.
    pub(super) fn all(levels: impl Iterator<Item = u16>, bodies: &[Option<Body>]) -> Vec<Self> {
        let mut members = BTreeMap::<(u16, usize), (Vec<ReactionId>, Vec<TriggerId>)>::new();
        for (index, (level, body)) in (0..).zip(levels.zip(bodies)) {
            let Some(body) = body else { continue };
            let (reactions, actions) = members.entry((level, body.instance)).or_default();
            reactions.push(ReactionId(index));
            actions.extend(body.effects.iter().filter_map(|effect| match effect.variable {
                VariableId::Trigger(trigger) => u16::try_from(trigger).ok().map(TriggerId),
                VariableId::Port(_) | VariableId::Mode(_) => None,
            }));
        }
        let group =
            |((level, _), (reactions, actions))| Self { level, reactions: keep(reactions), actions: keep(actions) };
        let mut groups: Vec<_> = members.into_iter().map(group).collect();
        groups.sort_by_key(|group| group.reactions[0].0);
        groups
    }
}

/// Bodies of one instance with the variables that they change.
pub(super) struct TakenBodies {
    pub(super) bodies: Vec<(ReactionId, Body)>,
    pub(super) state: u64,
    pub(super) own: Vec<(VariableId, TakenVariable)>,
    pub(super) record: Option<Record>,
    pub(super) stop: Option<Tag>,
    /// Whether a reaction has ended its federate, and only that.
    pub(super) leaves: bool,
}

impl TakenBodies {
    /// Returns the presence of a variable, with the value if it has one.
    #[expect(clippy::option_option, reason = "what is present has a value or none")]
    fn read(owned: &[(VariableId, TakenVariable)], memory: &Memory, variable: VariableId) -> Option<Option<Value>> {
        let own = owned.iter().find(|(own, _)| *own == variable).map(|(_, own)| own);
        match (variable, own) {
            (VariableId::Mode(_), _) => None,
            (VariableId::Port(_), Some(TakenVariable::Port(PortStorage::Own(port)))) => {
                port.value().map(|value| Some(*value))
            }
            (VariableId::Port(port), _) => memory.port(port)?.value().map(|value| Some(*value)),
            (VariableId::Trigger(_), Some(TakenVariable::Trigger(cell))) => cell.read(),
            (VariableId::Trigger(trigger), _) => memory.cells[trigger].read(),
        }
    }

    /// Runs a reaction: its effects follow from its script and all its inputs.
    pub(super) fn run(&mut self, reaction: ReactionId, memory: &Memory, ctx: &mut ReactionContext<'_>) {
        let Self { bodies, state, own, record, stop, leaves } = self;
        let Some((_, body)) = bodies.iter_mut().find(|(id, _)| *id == reaction) else { return };
        body.runs += 1;
        let mut digest = combine(*state, combine(body.id.path, body.number.into()));
        // An effect of events can cause fewer further reactions than they; an effect without a cause as many as the
        // script says.
        let (mut caused, mut fresh) = (None, body.is_startup || ctx.is_shutdown());
        for (position, variable) in (1..).zip(&body.reads) {
            let Some(value) = Self::read(own, memory, *variable) else { continue };
            digest = combine(digest, combine(position, value.map_or(0, Value::number)));
            match value {
                Some(value) => caused = caused.max(Some(value.energy().saturating_sub(1))),
                None => fresh = true,
            }
        }
        let energy = caused.unwrap_or(0).max(if fresh { body.script.energy } else { 0 });
        *state = digest;
        let (tag, last_tag) = (current_tag(ctx), ctx.is_shutdown());
        let work_ns = combine(digest, 2).checked_rem(body.script.work_ns.unsigned_abs()).unwrap_or(0);
        *record = Some(Record { tag, instance: body.id, reaction: body.number, digest, last_tag, work_ns });
        memory.side.work(work_ns);
        if body.script.plays {
            let value = body.reads.first().and_then(|variable| Self::read(own, memory, *variable)).flatten();
            if let (Some(value), Some((_, TakenVariable::Port(PortStorage::Own(port))))) = (value, own.first_mut()) {
                ctx.set(port, value);
            }
            return;
        }
        for (position, effect) in (0..).zip(&body.effects) {
            let choice = combine(digest, 100 + position);
            let own = own.iter_mut().find(|(own, _)| *own == effect.variable).map(|(_, own)| own);
            if body.is_startup && !effect.outside.is_empty() {
                if let Some(TakenVariable::Trigger(Cell::Physical(physical))) = own {
                    // A thread that schedules the action repeatedly.
                    let action = PhysicalActionRef::clone(physical.action());
                    let link = ctx.physical_link();
                    memory.side.start(Thread::new(&effect.outside, move |left| {
                        let value = Value::new(combine(choice, left as u64), THREAD_ENERGY, Shape::Fixed(1));
                        // A full inbox refuses the event, which then happens in none of the runs.
                        let _ = link.schedule_physical_with_v(&action, Some(value), Asap);
                    }));
                }
            } else if energy > 0 && choice % 100 < body.script.percent {
                cause(effect, own, choice, (energy, body.script.offset_ns), ctx);
            }
        }
        if body.script.leave_at == Some(body.runs) && !memory.replayed {
            *leaves = true;
            ctx.stop();
        }
        if body.script.stop_at == Some(body.runs) && !memory.replayed {
            let offset = body.script.stop_offset_ns;
            *stop = Some(tag.after(Interval::from_nanos(offset)));
            let offset = offset.unsigned_abs();
            ctx.request_stop(if offset == 0 { Asap } else { After(Duration::from_nanos(offset)) });
        }
    }
}

/// Sets a port, schedules an action, or changes the mode.
fn cause(
    effect: &Effect,
    own: Option<&mut TakenVariable>,
    origin: u64,
    (energy, offset_ns): (u64, i64),
    ctx: &mut ReactionContext<'_>,
) {
    let value = Value::new(combine(origin, 3), energy, effect.shape);
    let later = Duration::from_nanos(combine(origin, 4) % offset_ns.unsigned_abs().saturating_add(1));
    let offset = After(later);
    match (effect.variable, own) {
        (VariableId::Mode(transition), _) => ctx.set_mode(transition),
        (_, Some(TakenVariable::Port(PortStorage::Own(port)))) => ctx.set(port, value),
        (_, Some(TakenVariable::Trigger(Cell::Watchdog(watchdog)))) if combine(origin, 5).is_multiple_of(4) => {
            ctx.stop_watchdog(watchdog);
        }
        (_, Some(TakenVariable::Trigger(Cell::Watchdog(watchdog)))) => ctx.start_watchdog(watchdog, later),
        (_, Some(TakenVariable::Trigger(Cell::Logical(logical)))) => {
            ctx.schedule_with_v(logical.action_mut(), Some(value), offset);
        }
        (_, Some(TakenVariable::Trigger(Cell::Physical(physical)))) => {
            ctx.schedule_with_v(physical.action_mut(), Some(value), offset);
        }
        _ => {}
    }
}

pub(super) fn current_tag(ctx: &ReactionContext<'_>) -> Tag {
    Tag { time: ctx.get_logical_time(), microstep: lf_model::Microstep(ctx.get_tag().microstep) }
}

impl Memory {
    pub(super) fn port(&self, index: usize) -> Option<&Port<Value>> {
        match self.ports.get(index)? {
            PortStorage::Own(port) => Some(port),
            PortStorage::Queue(trigger) => match &self.cells[*trigger] {
                Cell::Queued(queued) => Some(queued.queue.port()),
                _ => None,
            },
            PortStorage::Taken => None,
        }
    }

    pub(super) fn port_mut(&mut self, index: usize) -> Option<&mut Port<Value>> {
        match self.ports.get_mut(index)? {
            PortStorage::Own(port) => Some(port),
            PortStorage::Queue(trigger) => match &mut self.cells[*trigger] {
                Cell::Queued(queued) => Some(queued.queue.port_mut()),
                _ => None,
            },
            PortStorage::Taken => None,
        }
    }
}
