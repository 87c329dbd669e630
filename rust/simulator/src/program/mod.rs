// SPDX-License-Identifier: Apache-2.0
//! A federate's program, interpreted from the compiler's plan: the model's own ports, queues and triggers, and
//! reactions whose effects follow from their script and a hash of all inputs.
//!
//! The effects of a reaction follow only from its program, its instance's state and the present inputs. So a program
//! behaves the same wherever and however it runs, as long as tags and presence are the same.

mod build;
mod cells;
mod tables;
mod taken;
mod value;

use std::mem;

use lf_model::time::Tag;
use lf_model::{
    Full, InputId, Job, Level, ModeCell, ModeCells, OutputId, Part, Payload as _, PayloadError, Placed, PortId,
    Program, ReactionContext, ReactionId, Readable, Tables, TriggerCell, TriggerId, Undelivered,
};

pub(crate) use build::{BuildError, Played};
pub(crate) use tables::Runs;
use tables::Shuffled;
pub(crate) use value::Value;

pub(crate) use cells::{CAPACITY_MAX, Handled};
use cells::{Cell, Queued};
use taken::{Body, Effect, Group, Memory, PortStorage, TakenBodies, TakenVariable, VariableId, current_tag};
pub(crate) use taken::{InstanceId, Record};

/// A program with its memory.
pub(crate) struct Scripted {
    tables: &'static Tables,
    bodies: Vec<Option<Body>>,
    /// The groups of bodies that can run in parallel with others of their level.
    groups: Vec<Group>,
    /// By reaction: the last one of those that run in turn with it.
    last_in_turn: Vec<u16>,
    /// By reaction: source and destination, if it stands for a connection.
    copies: Vec<Option<(usize, usize)>>,
    memory: Memory,
    /// By trigger: the port that a delayed connection reads.
    sources: Vec<Option<usize>>,
    /// The states by instance.
    states: Vec<u64>,
    /// The instances whose states are handed over, by number.
    handed_over: Vec<usize>,
    /// The state of the first of them, if it is one that an earlier instance of the federate had.
    pub(crate) taken_over: Option<u64>,
    /// The records of reactions, in the order in which they ran.
    pub(crate) trace: Vec<Record>,
    /// The stops that reactions requested.
    pub(crate) stops: Vec<Tag>,
    /// Whether a reaction has ended this federate, and only this.
    pub(crate) has_left: bool,
    /// The tags at which handlers of tardy messages ran.
    pub(crate) handled_tardy: Vec<Tag>,
    /// The tag at which a body ran instead of such a handler, or a handler without a tardy message.
    pub(crate) mishandled: Option<Tag>,
}

impl Scripted {
    /// Takes the bodies of reactions of one instance out of the program; omits reactions without one.
    fn take(&mut self, reactions: &[ReactionId]) -> TakenBodies {
        let taken = |id: &ReactionId| Some((*id, self.bodies.get_mut(usize::from(id.0)).and_then(Option::take)?));
        let bodies: Vec<_> = reactions.iter().filter_map(taken).collect();
        let (memory, mut own) = (&mut self.memory, Vec::<(VariableId, TakenVariable)>::new());
        for Effect { variable, .. } in bodies.iter().flat_map(|(_, body)| &body.effects) {
            match *variable {
                _ if own.iter().any(|(taken, _)| taken == variable) => {}
                VariableId::Port(port) => {
                    let place = mem::replace(&mut memory.ports[port], PortStorage::Taken);
                    own.push((*variable, TakenVariable::Port(place)));
                }
                VariableId::Trigger(trigger) => {
                    let cell = mem::replace(&mut memory.cells[trigger], Cell::None);
                    own.push((*variable, TakenVariable::Trigger(cell)));
                }
                VariableId::Mode(_) => {}
            }
        }
        let state = bodies.first().map_or(0, |(_, body)| self.states[body.instance]);
        TakenBodies { bodies, state, own, record: None, stop: None, leaves: false }
    }

    /// Puts the bodies back, and adds their records to the trace.
    fn put_back(&mut self, taken: TakenBodies) {
        let TakenBodies { bodies, state, own, record, stop, leaves } = taken;
        for (variable, own) in own {
            match (variable, own) {
                (VariableId::Port(port), TakenVariable::Port(place)) => self.memory.ports[port] = place,
                (VariableId::Trigger(trigger), TakenVariable::Trigger(cell)) => self.memory.cells[trigger] = cell,
                _ => {}
            }
        }
        self.trace.extend(record);
        self.stops.extend(stop);
        self.has_left |= leaves;
        for (reaction, body) in bodies {
            self.states[body.instance] = state;
            self.bodies[usize::from(reaction.0)] = Some(body);
        }
    }
}

impl Scripted {
    fn body(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
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

    fn run(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        let mut taken = self.take(&[reaction]);
        taken.run(reaction, &self.memory, ctx);
        self.put_back(taken);
    }

    /// Returns the maximum length of each queue so far, with its capacity.
    pub(crate) fn high_water(&self) -> impl Iterator<Item = (usize, usize)> {
        self.memory.cells.iter().filter_map(|cell| match cell {
            Cell::Queued(queued) => Some((queued.most, queued.capacity)),
            _ => None,
        })
    }

    /// Returns whether a reaction reads a tardy input directly.
    fn sees_tardy(&self, body: &Body) -> bool {
        body.reads.iter().any(|variable| {
            let VariableId::Port(port) = variable else { return false };
            let Some(PortStorage::Queue(trigger)) = self.memory.ports.get(*port) else { return false };
            matches!(&self.memory.cells[*trigger], Cell::Queued(queued) if queued.is_tardy())
        })
    }

    /// Sets the state of all instances before the first tag, which is the seed otherwise.
    pub(crate) fn set_states(&mut self, state: u64) {
        self.states.fill(state);
    }

    /// Sets the state of one instance.
    pub(crate) fn set_state(&mut self, instance: usize, state: u64) {
        self.states[instance] = state;
    }

    /// Returns the state of the first instance whose state is handed over.
    pub(crate) fn handed_over(&self) -> Option<u64> {
        self.handed_over.first().map(|instance| self.states[*instance])
    }

    /// Returns the handled messages by network input, where a check needs them.
    pub(crate) fn handled(&self) -> impl Iterator<Item = &[Handled]> {
        self.tables.inputs.iter().map(|input| match &self.memory.cells[usize::from(input.trigger.0)] {
            Cell::Queued(Queued { kept: Some(kept), .. }) => &kept.handled[..],
            _ => &[],
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
        let last = self.last_in_turn[usize::from(reaction.0)];
        ctx.in_turn(reaction.0, last, |ctx, reaction| self.body(reaction, ctx));
    }

    /// Does the same as the body.
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
        self.body(reaction, ctx);
    }

    fn share(&mut self, number: u16, level: &mut Level<'_>) {
        let groups: Vec<_> = self.groups.iter().filter(|group| group.level == number).copied().collect();
        let mut taken: Vec<_> = groups.iter().map(|group| self.take(group.reactions)).collect();
        let memory = &self.memory;
        let mut bodies = Vec::new();
        for taken in &mut taken {
            bodies.push(move |id: ReactionId, _: Part, ctx: &mut ReactionContext<'_>| taken.run(id, memory, ctx));
        }
        let jobs = groups.iter().zip(&mut bodies).map(|(group, run)| Job::new(group.reactions, group.actions, run));
        let mut jobs: Vec<_> = jobs.collect();
        match self.tables.note_words() {
            0..=16 => level.run::<3, 16>(&Shuffled, &mut jobs),
            _ => level.run::<3, 256>(&Shuffled, &mut jobs),
        }
        for taken in taken {
            self.put_back(taken);
        }
    }

    fn clear_port(&mut self, port: PortId) {
        if let Some(port) = self.memory.port_mut(usize::from(port.0)) {
            port.clear();
        }
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

    fn hand_over(&self, state: u16, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        let instance = self.handed_over.get(usize::from(state)).ok_or(PayloadError::Absent)?;
        self.states[*instance].encode(bytes)
    }

    fn take_over(&mut self, state: u16, bytes: &[u8]) -> Result<(), PayloadError> {
        let instance = self.handed_over.get(usize::from(state)).ok_or(PayloadError::Absent)?;
        self.states[*instance] = u64::decode(bytes)?;
        self.taken_over = self.handed_over();
        Ok(())
    }
}
