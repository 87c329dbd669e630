// SPDX-License-Identifier: Apache-2.0
//! A federate's program, interpreted from the compiler's plan: the model's own ports, queues and triggers, and
//! reactions that do what their script and a hash of all that they see say.
//!
//! What a reaction does follows from its program, its instance's state and what is present, and from nothing else. So
//! a program does the same wherever and however it runs, as long as tags and presence are the same.

mod build;
mod cells;
mod lent;
mod tables;
mod value;

use lf_model::time::Tag;
use lf_model::{
    Full, InputId, Job, Level, ModeCell, ModeCells, OutputId, Part, PayloadError, Placed, Port, PortCell, PortId,
    Program, ReactionContext, ReactionId, Readable, Tables, TriggerCell, TriggerId, Undelivered,
};

pub(crate) use build::{BuildError, Played};
pub(crate) use tables::Runs;
pub(crate) use value::{Shape, Value};

use crate::world::Side;
pub(crate) use cells::{CAPACITY_MAX, Handled};
use cells::{Cell, Queued};
use lent::{Body, Group, Variable, current_tag};

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
    /// What can run side by side with others of its level.
    groups: Vec<Group>,
    /// By reaction: from where to where it copies, if it stands for a connection.
    copies: Vec<Option<(usize, usize)>>,
    memory: Memory,
    /// By trigger: the port that a delayed connection reads.
    sources: Vec<Option<usize>>,
    /// By instance.
    states: Vec<u64>,
    /// What reactions saw, in the order in which they ran.
    pub(crate) trace: Vec<Record>,
    /// The stops that reactions asked for.
    pub(crate) stops: Vec<Tag>,
    /// At which tags handlers of late messages ran.
    pub(crate) handled_tardy: Vec<Tag>,
    /// Where a body ran in place of such a handler, or a handler though nothing was late.
    pub(crate) mishandled: Option<Tag>,
}

/// What reactions share.
struct Memory {
    cells: Vec<Cell>,
    ports: Vec<Place>,
    side: &'static Side,
    /// Whether stops and physical events are known beforehand, and reactions do not cause them.
    replayed: bool,
}

/// Where a port's value lies.
enum Place {
    Own(Port<Value>),
    /// In the cell of this trigger.
    Queue(usize),
    /// With a body that runs.
    Lent,
}

impl Scripted {
    fn run(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        let mut lent = self.lend(&[reaction]);
        lent.run(reaction, &self.memory, ctx);
        self.take_back(lent);
    }

    /// The fullest that the queues ever were, each with its capacity.
    pub(crate) fn high_water(&self) -> impl Iterator<Item = (usize, usize)> {
        self.memory.cells.iter().filter_map(|cell| match cell {
            Cell::Queued(queued) => Some((queued.most, queued.capacity)),
            _ => None,
        })
    }

    /// What a reaction sees directly of what came too late.
    fn sees_tardy(&self, body: &Body) -> bool {
        body.reads.iter().any(|variable| {
            let Variable::Port(port) = variable else { return false };
            let Some(Place::Queue(trigger)) = self.memory.ports.get(*port) else { return false };
            matches!(&self.memory.cells[*trigger], Cell::Queued(queued) if queued.is_tardy())
        })
    }

    /// By network input: what happened when, where it can come too late.
    pub(crate) fn handled(&self) -> impl Iterator<Item = &[Handled]> {
        self.tables.inputs.iter().map(|input| match &self.memory.cells[usize::from(input.trigger.0)] {
            Cell::Queued(Queued { kept: Some(kept), .. }) => &kept.handled[..],
            _ => &[],
        })
    }

    /// When the physical actions happened, by trigger.
    pub(crate) fn physical_events(&self) -> impl Iterator<Item = (&'static str, &[(Tag, Option<Value>)])> {
        self.tables.triggers.iter().zip(&self.memory.cells).filter_map(|(info, cell)| match cell {
            Cell::Physical(recorded) => Some((info.name, &recorded.happened[..])),
            _ => None,
        })
    }
}

impl ModeCells for Scripted {
    fn in_mode(&mut self, trigger: TriggerId) -> Option<&mut dyn ModeCell> {
        self.memory.cells.get_mut(usize::from(trigger.0)).and_then(Cell::as_mode)
    }
}

impl Program for Scripted {
    fn tables(&self) -> &'static Tables {
        self.tables
    }

    fn react(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        let index = usize::from(reaction.0);
        if let Some((from, to)) = self.copies[index]
            && let Some(value) = self.memory.port(from).and_then(Readable::value).copied()
            && let Some(port) = self.memory.port_mut(to)
        {
            ctx.set(port, value);
        }
        if self.bodies.get(index).and_then(Option::as_ref).is_some_and(|body| body.tardy && self.sees_tardy(body)) {
            self.mishandled.get_or_insert(current_tag(ctx));
        }
        self.run(reaction, ctx);
    }

    /// Does what the body does.
    fn handle_tardy(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        let tag = current_tag(ctx);
        self.handled_tardy.push(tag);
        let mut inputs = self.memory.cells.iter();
        if !inputs.any(|cell| matches!(cell, Cell::Queued(queued) if queued.is_tardy())) {
            self.mishandled.get_or_insert(tag);
        }
        self.run(reaction, ctx);
    }

    fn miss_deadline(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        self.react(reaction, ctx);
    }

    fn share(&mut self, number: u16, level: &mut Level<'_, '_>) {
        let groups: Vec<_> = self.groups.iter().filter(|group| group.level == number).copied().collect();
        let mut lent: Vec<_> = groups.iter().map(|group| self.lend(group.reactions)).collect();
        let memory = &self.memory;
        let mut bodies = Vec::new();
        for lent in &mut lent {
            bodies.push(move |id: ReactionId, _: Part, ctx: &mut ReactionContext<'_>| lent.run(id, memory, ctx));
        }
        let jobs = groups.iter().zip(&mut bodies).map(|(group, run)| Job::new(group.reactions, group.actions, run));
        level.run(&mut jobs.collect::<Vec<_>>());
        for lent in lent {
            self.take_back(lent);
        }
    }

    fn port(&mut self, port: PortId) -> Option<&mut dyn PortCell> {
        self.memory.port_mut(usize::from(port.0)).map(|port| port as &mut dyn PortCell)
    }

    fn trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
        self.memory.cells.get_mut(usize::from(trigger.0)).and_then(Cell::as_trigger)
    }

    fn modes(&mut self) -> Option<&mut dyn ModeCells> {
        Some(self)
    }

    fn capture(&mut self, trigger: TriggerId, tag: Tag) -> Result<(), Full> {
        let index = usize::from(trigger.0);
        let Some(source) = self.sources[index] else { return Ok(()) };
        let mut cell = std::mem::replace(&mut self.memory.cells[index], Cell::None);
        let outcome = match (&mut cell, self.memory.port(source)) {
            (Cell::Queued(queued), Some(source)) => queued.capture(tag, source),
            _ => Ok(()),
        };
        self.memory.cells[index] = cell;
        outcome
    }

    fn encode(&self, output: OutputId, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        let source = self.tables.outputs.get(usize::from(output.0)).ok_or(PayloadError::Absent)?.source;
        self.memory.port(usize::from(source.0)).ok_or(PayloadError::Absent)?.encode(bytes)
    }

    fn deliver(&mut self, input: InputId, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
        let info = self.tables.inputs.get(usize::from(input.0)).ok_or(Undelivered::NoSuchPort)?;
        match &mut self.memory.cells[usize::from(info.trigger.0)] {
            Cell::Queued(queued) => queued.deliver(tag, bytes),
            _ => Err(Undelivered::NoSuchPort),
        }
    }

    fn deliver_tardy(&mut self, input: InputId, tag: Tag, intended: Tag, bytes: &[u8]) -> Result<Placed, Undelivered> {
        let info = self.tables.inputs.get(usize::from(input.0)).ok_or(Undelivered::NoSuchPort)?;
        match &mut self.memory.cells[usize::from(info.trigger.0)] {
            Cell::Queued(queued) => queued.deliver_tardy(tag, intended, bytes),
            _ => Err(Undelivered::NoSuchPort),
        }
    }
}
