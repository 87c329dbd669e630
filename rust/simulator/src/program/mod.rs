// SPDX-License-Identifier: Apache-2.0
//! A federate's program, interpreted from the compiler's plan: the model's own ports, queues and triggers, and
//! reactions that do what their script and a hash of all that they see say.
//!
//! What a reaction does follows from its program, its instance's state and what is present, and from nothing else. So
//! a program does the same wherever and however it runs, as long as tags and presence are the same.

mod build;
mod cells;
mod tables;
mod value;

use std::time::Duration;

use lf_model::prelude::{After, Asap};
use lf_model::time::Tag;
use lf_model::{
    Full, InputId, ModeCell, ModeCells, OutputId, PayloadError, PhysicalActionRef, Placed, Port, PortCell, PortId,
    Program, ReactionContext, ReactionId, Readable, Tables, Transition, TriggerCell, TriggerId, Undelivered,
};
use lf_testkit::random::combine;

pub(crate) use build::{BuildError, Played};
pub(crate) use value::{Shape, Value};

use crate::scenario::Script;
use crate::world::{Side, Thread};
pub(crate) use cells::{CAPACITY_MAX, Handled};
use cells::{Cell, Queued};

/// An instance of a reactor, the same one whether federated or not.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct InstanceId {
    pub(crate) federate: usize,
    /// A hash of its path.
    pub(crate) path: u64,
}

/// What a reaction saw, when and in which state.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Record {
    pub(crate) tag: Tag,
    pub(crate) instance: InstanceId,
    /// The reaction's number in its reactor, from 1.
    pub(crate) reaction: u16,
    /// All that it saw, and the state.
    pub(crate) digest: u64,
    /// Whether its federate's last tag was running.
    pub(crate) last_tag: bool,
    /// How long it took.
    pub(crate) work_ns: u64,
}

/// A program with its memory.
pub(crate) struct Scripted {
    tables: &'static Tables,
    bodies: Vec<Option<Body>>,
    /// By reaction: from where to where it copies, if it stands for a connection.
    copies: Vec<Option<(usize, usize)>>,
    cells: Vec<Cell>,
    ports: Vec<Place>,
    /// By trigger: the port that a delayed connection reads.
    sources: Vec<Option<usize>>,
    /// By instance.
    states: Vec<u64>,
    side: &'static Side,
    /// What reactions saw, in the order in which they ran.
    pub(crate) trace: Vec<Record>,
    /// The stops that reactions asked for.
    pub(crate) stops: Vec<Tag>,
    /// Whether stops and physical events are known beforehand, and reactions do not cause them.
    replayed: bool,
    /// At which tags handlers of late messages ran.
    pub(crate) handled_tardy: Vec<Tag>,
    /// Where a body ran in place of such a handler, or a handler though nothing was late.
    pub(crate) mishandled: Option<Tag>,
}

/// A reaction with a body.
struct Body {
    instance: usize,
    id: InstanceId,
    number: u16,
    reads: Vec<Variable>,
    effects: Vec<Effect>,
    /// It has a handler for what comes too late.
    tardy: bool,
    script: Script,
    runs: u64,
    is_startup: bool,
}

#[derive(Clone, Copy)]
enum Variable {
    Port(usize),
    Trigger(usize),
    Mode(Transition),
}

struct Effect {
    variable: Variable,
    shape: Shape,
    /// When threads schedule a physical action, in nanoseconds after they were started.
    outside: Vec<i64>,
}

/// Where a port's value lies.
enum Place {
    Own(Port<Value>),
    /// In the cell of this trigger.
    Queue(usize),
}

impl Scripted {
    fn port_of(&self, index: usize) -> Option<&Port<Value>> {
        match self.ports.get(index)? {
            Place::Own(port) => Some(port),
            Place::Queue(trigger) => match &self.cells[*trigger] {
                Cell::Queued(queued) => Some(queued.queue.port()),
                _ => None,
            },
        }
    }

    fn port_mut(&mut self, index: usize) -> Option<&mut Port<Value>> {
        match self.ports.get_mut(index)? {
            Place::Own(port) => Some(port),
            Place::Queue(trigger) => match &mut self.cells[*trigger] {
                Cell::Queued(queued) => Some(queued.queue.port_mut()),
                _ => None,
            },
        }
    }

    /// What is present of a variable: nothing, or perhaps a value.
    #[expect(clippy::option_option, reason = "what is present has a value or none")]
    fn read(&self, variable: Variable) -> Option<Option<Value>> {
        match variable {
            Variable::Mode(_) => None,
            Variable::Port(port) => self.port_of(port)?.value().map(|value| Some(*value)),
            Variable::Trigger(trigger) => match &self.cells[trigger] {
                Cell::Timer(timer) => timer.is_present().then_some(None),
                Cell::Watchdog(watchdog) => watchdog.is_present().then_some(None),
                Cell::Logical(logical) => logical.action().is_present().then(|| logical.action().value().copied()),
                Cell::Physical(recorded) => {
                    let action = recorded.action.action();
                    action.is_present().then(|| action.value().copied())
                }
                Cell::Replayed(replayed) => replayed.present,
                Cell::None | Cell::Queued(_) => None,
            },
        }
    }

    fn run(&mut self, body: &mut Body, ctx: &mut ReactionContext<'_>) {
        body.runs += 1;
        let mut digest = combine(self.states[body.instance], combine(body.id.path, body.number.into()));
        // What was caused by something can cause less; what was not, as much as the script says.
        let (mut caused, mut fresh) = (None, body.is_startup || ctx.is_shutdown());
        for (position, variable) in (1..).zip(&body.reads) {
            let Some(value) = self.read(*variable) else { continue };
            digest = combine(digest, combine(position, value.map_or(0, Value::number)));
            match value {
                Some(value) => caused = caused.max(Some(value.energy().saturating_sub(1))),
                None => fresh = true,
            }
        }
        let energy = caused.unwrap_or(0).max(if fresh { body.script.energy } else { 0 });
        self.states[body.instance] = digest;
        let (tag, last_tag) = (current_tag(ctx), ctx.is_shutdown());
        let work_ns = combine(digest, 2).checked_rem(body.script.work_ns.unsigned_abs()).unwrap_or(0);
        self.trace.push(Record { tag, instance: body.id, reaction: body.number, digest, last_tag, work_ns });
        self.side.work(work_ns);
        for (position, effect) in (0..).zip(&body.effects) {
            let choice = combine(digest, 100 + position);
            if body.is_startup && !effect.outside.is_empty() {
                self.start_thread(effect, choice, ctx);
            } else if energy > 0 && choice % 100 < body.script.percent {
                self.cause(effect, choice, energy, body.script.offset_ns, ctx);
            }
        }
        if body.script.stop_at == Some(body.runs) && !self.replayed {
            let offset = body.script.stop_offset_ns.unsigned_abs();
            self.stops.push(tag.after(lf_model::time::Interval::from_nanos(body.script.stop_offset_ns)));
            ctx.request_stop(if offset == 0 { Asap } else { After(Duration::from_nanos(offset)) });
        }
    }

    /// Sets a port, or schedules an action.
    fn cause(&mut self, effect: &Effect, origin: u64, energy: u64, offset_ns: i64, ctx: &mut ReactionContext<'_>) {
        let value = Value::new(combine(origin, 3), energy, effect.shape);
        let later = Duration::from_nanos(combine(origin, 4) % offset_ns.unsigned_abs().saturating_add(1));
        let offset = After(later);
        match effect.variable {
            Variable::Port(port) => {
                if let Some(port) = self.port_mut(port) {
                    ctx.set(port, value);
                }
            }
            Variable::Mode(transition) => ctx.set_mode(transition),
            Variable::Trigger(trigger) => match &mut self.cells[trigger] {
                Cell::Watchdog(watchdog) if combine(origin, 5).is_multiple_of(4) => ctx.stop_watchdog(watchdog),
                Cell::Watchdog(watchdog) => ctx.start_watchdog(watchdog, later),
                Cell::Logical(logical) => ctx.schedule_with_v(logical.action_mut(), Some(value), offset),
                Cell::Physical(recorded) => ctx.schedule_with_v(recorded.action.action_mut(), Some(value), offset),
                Cell::None | Cell::Timer(_) | Cell::Replayed(_) | Cell::Queued(_) => {}
            },
        }
    }

    /// Starts a thread that schedules a physical action again and again.
    fn start_thread(&mut self, effect: &Effect, origin: u64, ctx: &mut ReactionContext<'_>) {
        let Variable::Trigger(trigger) = effect.variable else { return };
        if let Cell::Physical(recorded) = &self.cells[trigger] {
            let action = PhysicalActionRef::clone(recorded.action.action());
            self.side.start(Thread::new(ctx.physical_link(), action, origin, &effect.outside));
        }
    }

    /// The fullest that the queues ever were, each with its capacity.
    pub(crate) fn high_water(&self) -> impl Iterator<Item = (usize, usize)> {
        self.cells.iter().filter_map(|cell| match cell {
            Cell::Queued(queued) => Some((queued.most, queued.capacity)),
            _ => None,
        })
    }

    /// What a reaction sees directly of what came too late.
    fn sees_tardy(&self, body: &Body) -> bool {
        body.reads.iter().any(|variable| {
            let Variable::Port(port) = variable else { return false };
            let Some(Place::Queue(trigger)) = self.ports.get(*port) else { return false };
            matches!(&self.cells[*trigger], Cell::Queued(queued) if queued.is_tardy())
        })
    }

    /// By network input: what happened when, where it can come too late.
    pub(crate) fn handled(&self) -> impl Iterator<Item = &[Handled]> {
        self.tables.inputs.iter().map(|input| match &self.cells[usize::from(input.trigger.0)] {
            Cell::Queued(Queued { kept: Some(kept), .. }) => &kept.handled[..],
            _ => &[],
        })
    }

    /// When the physical actions happened, by trigger.
    pub(crate) fn physical_events(&self) -> impl Iterator<Item = (&'static str, &[(Tag, Option<Value>)])> {
        self.tables.triggers.iter().zip(&self.cells).filter_map(|(info, cell)| match cell {
            Cell::Physical(recorded) => Some((info.name, &recorded.happened[..])),
            _ => None,
        })
    }
}

fn current_tag(ctx: &ReactionContext<'_>) -> Tag {
    Tag { time: ctx.get_logical_time(), microstep: lf_model::Microstep(ctx.get_tag().microstep) }
}

impl ModeCells for Scripted {
    fn in_mode(&mut self, trigger: TriggerId) -> Option<&mut dyn ModeCell> {
        self.cells.get_mut(usize::from(trigger.0)).and_then(Cell::as_mode)
    }
}

impl Program for Scripted {
    fn tables(&self) -> &'static Tables {
        self.tables
    }

    fn react(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        let index = usize::from(reaction.0);
        if let Some((from, to)) = self.copies[index]
            && let Some(value) = self.port_of(from).and_then(Readable::value).copied()
            && let Some(port) = self.port_mut(to)
        {
            ctx.set(port, value);
        }
        if self.bodies.get(index).and_then(Option::as_ref).is_some_and(|body| body.tardy && self.sees_tardy(body)) {
            self.mishandled.get_or_insert(current_tag(ctx));
        }
        // The body is taken out for as long as it runs, because it uses all the rest.
        if let Some(mut body) = self.bodies.get_mut(index).and_then(Option::take) {
            self.run(&mut body, ctx);
            self.bodies[index] = Some(body);
        }
    }

    /// Does what the body does.
    fn handle_tardy(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        let (index, tag) = (usize::from(reaction.0), current_tag(ctx));
        self.handled_tardy.push(tag);
        let mut inputs = self.cells.iter();
        if !inputs.any(|cell| matches!(cell, Cell::Queued(queued) if queued.is_tardy())) {
            self.mishandled.get_or_insert(tag);
        }
        if let Some(mut body) = self.bodies.get_mut(index).and_then(Option::take) {
            self.run(&mut body, ctx);
            self.bodies[index] = Some(body);
        }
    }

    fn miss_deadline(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        self.react(reaction, ctx);
    }

    fn port(&mut self, port: PortId) -> Option<&mut dyn PortCell> {
        self.port_mut(usize::from(port.0)).map(|port| port as &mut dyn PortCell)
    }

    fn trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
        self.cells.get_mut(usize::from(trigger.0)).and_then(Cell::as_trigger)
    }

    fn modes(&mut self) -> Option<&mut dyn ModeCells> {
        Some(self)
    }

    fn capture(&mut self, trigger: TriggerId, tag: Tag) -> Result<(), Full> {
        let index = usize::from(trigger.0);
        let Some(source) = self.sources[index] else { return Ok(()) };
        let mut cell = std::mem::replace(&mut self.cells[index], Cell::None);
        let outcome = match (&mut cell, self.port_of(source)) {
            (Cell::Queued(queued), Some(source)) => queued.capture(tag, source),
            _ => Ok(()),
        };
        self.cells[index] = cell;
        outcome
    }

    fn encode(&self, output: OutputId, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        let source = self.tables.outputs.get(usize::from(output.0)).ok_or(PayloadError::Absent)?.source;
        self.port_of(usize::from(source.0)).ok_or(PayloadError::Absent)?.encode(bytes)
    }

    fn deliver(&mut self, input: InputId, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
        let info = self.tables.inputs.get(usize::from(input.0)).ok_or(Undelivered::NoSuchPort)?;
        match &mut self.cells[usize::from(info.trigger.0)] {
            Cell::Queued(queued) => queued.deliver(tag, bytes),
            _ => Err(Undelivered::NoSuchPort),
        }
    }

    fn deliver_tardy(&mut self, input: InputId, tag: Tag, intended: Tag, bytes: &[u8]) -> Result<Placed, Undelivered> {
        let info = self.tables.inputs.get(usize::from(input.0)).ok_or(Undelivered::NoSuchPort)?;
        match &mut self.cells[usize::from(info.trigger.0)] {
            Cell::Queued(queued) => queued.deliver_tardy(tag, intended, bytes),
            _ => Err(Undelivered::NoSuchPort),
        }
    }
}
