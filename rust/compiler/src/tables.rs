// SPDX-License-Identifier: Apache-2.0
//! Derives the tables of a federate's program, which the engine and the event loop read, from its plan.
//!
//! This module derives, once, all that follows from the plan without being in it: the memory of each trigger, the
//! readers of each input, the inputs that can be tardy. Emitters print these tables; the simulator builds real ones
//! from them.

use lf_model::time::Interval;
use lf_model::{ActionTiming, ModeId, ModeTrigger, Policy, PortId, ReactionId, ReactionKind, TriggerId, TriggerKind};

use crate::plan::{self, Federate, InstanceIndex, Plan, SpacingPolicy, StateVariable, Type};

/// The tables of a federate: rows in the order of their ids.
#[derive(Clone, Debug)]
pub struct Tables<'p> {
    /// The reactions in the order in which they run.
    pub reactions: Vec<ReactionRow<'p>>,
    /// All sources of events.
    pub triggers: Vec<TriggerRow<'p>>,
    /// The ports that store a value.
    pub ports: Vec<PortRow<'p>>,
    /// The connections to other federates.
    pub outputs: Vec<OutputRow<'p>>,
    /// The connections from other federates, by wire port.
    pub inputs: Vec<InputRow<'p>>,
    /// Port numbers that none of the inputs has.
    pub own_ports: &'p [u16],
    /// The reactions that send absences: they run at every tag.
    pub absence: Vec<ReactionId>,
    /// The states that the federate, which is transient, hands over.
    pub handed_over: Vec<HandedOverRow<'p>>,
    /// The modes, those of a container before those of its contents.
    pub modes: Vec<ModeRow<'p>>,
    /// The federates that send to this one, each with the least delay in nanoseconds; `None` without `after`.
    pub upstream: Vec<(u16, Option<i64>)>,
    /// The wire ports whose reactions wait until the status of the input is known, each with the lowest of their
    /// levels.
    pub awaited: Vec<(u16, u16)>,
}

/// A state variable of an instance that is handed over.
#[derive(Clone, Debug)]
pub struct HandedOverRow<'p> {
    /// The name for messages.
    pub name: String,
    /// A number that follows from its name and its type, and from nothing else.
    pub id: u64,
    /// The instance.
    pub instance: InstanceIndex,
    /// The variable.
    pub state: &'p StateVariable,
}

/// A mode of an instance.
#[derive(Clone, Debug)]
pub struct ModeRow<'p> {
    /// The name for messages.
    pub name: &'p str,
    /// The instance.
    pub instance: u16,
    /// The innermost mode that the instance is in.
    pub parent: Option<ModeId>,
    /// Whether the instance begins in it.
    pub initial: bool,
}

/// The triggers of a change of modes.
#[derive(Clone, Copy, Debug)]
pub struct ModeEvents<'t> {
    /// The trigger that has an event when a mode is entered.
    pub entry: TriggerId,
    /// The reactions to `startup`.
    pub startup: &'t [ReactionId],
    /// The reactions to `reset`.
    pub reset: &'t [ReactionId],
    /// The reactions to `shutdown`.
    pub shutdown: &'t [ReactionId],
}

/// A reaction.
#[derive(Clone, Debug)]
pub struct ReactionRow<'p> {
    /// The name for messages.
    pub name: &'p str,
    /// Its level.
    pub level: u16,
    /// Its deadline.
    pub deadline: Option<Interval>,
    /// Whether it has a rule for tardy inputs.
    pub tardy: bool,
    /// The innermost mode that it is in.
    pub mode: Option<ModeId>,
    /// The kind.
    pub kind: ReactionKind,
}

/// A trigger.
#[derive(Clone, Debug)]
pub struct TriggerRow<'p> {
    /// The name for messages.
    pub name: &'p str,
    /// The kind.
    pub kind: TriggerKind,
    /// The reactions that it triggers directly.
    pub reactions: Vec<ReactionId>,
    /// The innermost mode that it is in.
    pub mode: Option<ModeId>,
    /// The memory for its events.
    pub cell: Cell,
    /// The maximum number of pending events.
    pub capacity: usize,
    /// The port whose values it captures: that of a connection with `after`, unless it connects a port with itself.
    pub captures: Option<PortId>,
}

/// The memory for the events of a trigger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// None: startup, shutdown and reset.
    None,
    /// A timer.
    Timer,
    /// The queue of a logical action.
    Logical,
    /// The one event of a watchdog.
    Watchdog,
    /// The queue of a physical action, and an inbox for other threads.
    Physical,
    /// A queue with the port that it fills.
    Queued(PortId),
    /// The same for messages that can arrive after their tag.
    Tardy(PortId),
}

/// A port.
#[derive(Clone, Debug)]
pub struct PortRow<'p> {
    /// The name for messages.
    pub name: &'p str,
    /// The reactions that a value triggers.
    pub reactions: Vec<ReactionId>,
    /// The triggers of delayed connections from it.
    pub delays: Vec<TriggerId>,
    /// The trigger whose queue contains it, if there is one.
    pub filled_by: Option<TriggerId>,
}

/// A connection to another federate.
#[derive(Clone, Debug)]
pub struct OutputRow<'p> {
    /// The name for messages.
    pub name: &'p str,
    /// The port whose values are sent.
    pub source: PortId,
    /// The type of the values.
    pub ty: &'p Type,
    /// The receiving federate.
    pub federate: u16,
    /// The port on the wire.
    pub port: u16,
    /// The connection's `after`.
    pub delay: Option<Interval>,
    /// Whether the federate sends absences to the receiver.
    pub tells_absence: bool,
    /// Whether the connection is physical.
    pub physical: bool,
}

/// A connection from another federate.
#[derive(Clone, Debug)]
pub struct InputRow<'p> {
    /// The name for messages.
    pub name: &'p str,
    /// The trigger that holds the received messages.
    pub trigger: TriggerId,
    /// The port that it fills.
    pub fills: PortId,
    /// The type of the values.
    pub ty: &'p Type,
    /// The sending federate.
    pub federate: u16,
    /// The connection's `after`.
    pub delay: Option<Interval>,
    /// The lowest level of the reactions that see the input.
    pub level: u16,
    /// Whether these reactions wait until the status of the input is known.
    pub awaited: bool,
    /// Whether the connection is physical.
    pub physical: bool,
    /// Whether a message may arrive after its tag.
    pub tardy: bool,
    /// The time that a tag waits for earlier messages at this input.
    pub max_wait: Interval,
    /// The additional time that reactions wait for messages of the tag.
    pub absent_after: Interval,
    /// If messages can be tardy, the reactions that see the input and are not triggered by it.
    pub readers: Vec<ReactionId>,
}

impl<'p> Tables<'p> {
    /// Derives the tables of a federate.
    ///
    /// # Panics
    /// If the federate is not one of this plan's.
    pub fn of(plan: &'p Plan, federate: &'p Federate) -> Self {
        let inputs: Vec<_> = federate.inputs.iter().map(|input| input_row(plan, federate, input)).collect();
        let triggers: Vec<_> = federate.triggers.iter().map(|trigger| trigger_row(trigger, &inputs)).collect();
        let port = |(index, port): (usize, &'p plan::Port)| {
            let fills = |trigger: &TriggerRow<'_>| trigger.kind.fills() == Some(PortId(id(index)));
            PortRow {
                name: &port.path,
                reactions: reaction_ids(&port.reactions),
                delays: port.delays.iter().map(|delay| TriggerId(id(delay.0))).collect(),
                // The last one; a port has at most one.
                filled_by: triggers.iter().rposition(fills).map(|trigger| TriggerId(id(trigger))),
            }
        };
        let ports = federate.ports.iter().enumerate().map(port).collect();
        let reactions = federate.reactions.iter().map(|reaction| ReactionRow {
            name: &reaction.name,
            level: reaction.level,
            deadline: interval(reaction.deadline_ns),
            tardy: plan.tardy(federate, reaction).is_some(),
            mode: mode_id(reaction.mode),
            kind: match &reaction.kind {
                plan::ReactionKind::Body { .. } | plan::ReactionKind::Copy { .. } => ReactionKind::Body,
                plan::ReactionKind::Send(output) => ReactionKind::Send(lf_model::OutputId(id(output.0))),
            },
        });
        let awaited = (0..).zip(&inputs).filter(|(_, input)| input.awaited).map(|(port, input)| (port, input.level));
        Self {
            reactions: reactions.collect(),
            ports,
            outputs: federate.outputs.iter().map(output_row).collect(),
            own_ports: &federate.own_ports,
            handed_over: handed_over(plan, federate),
            absence: reaction_ids(&federate.absence()),
            modes: federate.modes.iter().map(mode_row).collect(),
            upstream: federate.upstream.iter().map(|upstream| (upstream.federate, upstream.delay_ns)).collect(),
            awaited: awaited.collect(),
            triggers,
            inputs,
        }
    }

    /// Returns the triggers in modes.
    pub fn mode_triggers(&self) -> Vec<ModeTrigger> {
        let of = |(id, row): (u16, &TriggerRow<'_>)| {
            let offset = match row.kind {
                TriggerKind::Timer { offset, .. } => Some(offset),
                _ => None,
            };
            Some(ModeTrigger { trigger: TriggerId(id), mode: row.mode?, offset })
        };
        (0..).zip(&self.triggers).filter_map(of).collect()
    }

    /// Returns the triggers of a change of modes.
    pub fn mode_events(&self) -> ModeEvents<'_> {
        let position = |kind| self.triggers.iter().position(|trigger| trigger.kind == kind);
        let reactions = |kind| position(kind).map_or(&[][..], |trigger| &self.triggers[trigger].reactions);
        ModeEvents {
            // A federate with modes has this trigger.
            entry: TriggerId(id(position(TriggerKind::Reset).unwrap_or_default())),
            startup: reactions(TriggerKind::Startup),
            reset: reactions(TriggerKind::Reset),
            shutdown: reactions(TriggerKind::Shutdown),
        }
    }

    /// Returns whether a reaction needs no more of the engine, between one before it and itself, than to be found.
    pub fn runs_in_turn(&self, reaction: usize) -> bool {
        let row = &self.reactions[reaction];
        row.deadline.is_none() && row.kind == ReactionKind::Body && self.modes.is_empty()
    }

    /// Returns whether a message can arrive after its tag at any input.
    pub fn has_tardy_inputs(&self) -> bool {
        self.inputs.iter().any(|input| input.tardy)
    }
}

/// Returns the states that a transient federate hands over.
pub(crate) fn handed_over<'p>(plan: &'p Plan, federate: &'p Federate) -> Vec<HandedOverRow<'p>> {
    let instances = (0..).map(InstanceIndex).zip(&federate.instances).filter(|_| federate.transient);
    let states = instances.flat_map(|(index, instance)| {
        let states = plan.class(instance).state.iter().filter(|state| state.handed_over.is_some());
        states.map(move |state| (index, instance, state))
    });
    let row = |(instance, at, state): (InstanceIndex, &plan::Instance, &'p StateVariable)| {
        let name = format!("{}.{}", at.path, state.name);
        HandedOverRow { id: fnv_1a(&format!("{name}: {}", state.ty.text)), name, instance, state }
    };
    states.map(row).collect()
}

/// Returns the 64-bit FNV-1a hash of a text: it is the same in all builds and versions.
fn fnv_1a(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

fn trigger_row<'p>(trigger: &'p plan::Trigger, inputs: &[InputRow<'p>]) -> TriggerRow<'p> {
    let kind = trigger_kind(&trigger.kind);
    let (cell, captures) = match &trigger.kind {
        plan::TriggerKind::Startup | plan::TriggerKind::Shutdown | plan::TriggerKind::Reset => (Cell::None, None),
        plan::TriggerKind::Timer { .. } => (Cell::Timer, None),
        plan::TriggerKind::Action { physical: false, .. } => (Cell::Logical, None),
        plan::TriggerKind::Action { physical: true, .. } => (Cell::Physical, None),
        plan::TriggerKind::Watchdog { .. } => (Cell::Watchdog, None),
        // A port that would feed itself has no other source, and so never a value.
        plan::TriggerKind::Delay { source, fills, .. } => {
            (Cell::Queued(port_id(*fills)), (source != fills).then(|| port_id(*source)))
        }
        plan::TriggerKind::NetworkInput { input, fills } => {
            let fills = port_id(*fills);
            (if inputs[input.0].tardy { Cell::Tardy(fills) } else { Cell::Queued(fills) }, None)
        }
    };
    let reactions = reaction_ids(&trigger.reactions);
    let mode = mode_id(trigger.mode);
    TriggerRow { name: &trigger.path, kind, reactions, mode, cell, capacity: trigger.capacity, captures }
}

fn trigger_kind(kind: &plan::TriggerKind) -> TriggerKind {
    match kind {
        plan::TriggerKind::Startup => TriggerKind::Startup,
        plan::TriggerKind::Shutdown => TriggerKind::Shutdown,
        plan::TriggerKind::Reset => TriggerKind::Reset,
        plan::TriggerKind::Timer { offset_ns, period_ns, .. } => TriggerKind::Timer {
            offset: Interval::from_nanos(*offset_ns),
            period: Interval::from_nanos(period_ns.unwrap_or(0)),
        },
        plan::TriggerKind::Action { physical, min_delay_ns, min_spacing_ns, policy, .. } => {
            let timing = ActionTiming {
                min_delay: Interval::from_nanos(*min_delay_ns),
                min_spacing: interval(*min_spacing_ns),
                policy: match policy {
                    SpacingPolicy::Defer => Policy::Defer,
                    SpacingPolicy::Drop => Policy::Drop,
                    SpacingPolicy::Replace => Policy::Replace,
                    SpacingPolicy::Update => Policy::Update,
                },
            };
            if *physical { TriggerKind::Physical(timing) } else { TriggerKind::Logical(timing) }
        }
        plan::TriggerKind::Watchdog { timeout_ns, .. } => {
            TriggerKind::Logical(ActionTiming { min_delay: Interval::from_nanos(*timeout_ns), ..ActionTiming::NONE })
        }
        plan::TriggerKind::Delay { fills, delay_ns, physical, .. } => {
            let (fills, delay) = (port_id(*fills), Interval::from_nanos(*delay_ns));
            if *physical { TriggerKind::PhysicalDelay { fills, delay } } else { TriggerKind::Delay { fills, delay } }
        }
        plan::TriggerKind::NetworkInput { fills, .. } => TriggerKind::NetworkInput { fills: port_id(*fills) },
    }
}

fn mode_row(mode: &plan::Mode) -> ModeRow<'_> {
    let (instance, parent) = (id(mode.instance.0), mode_id(mode.parent));
    ModeRow { name: &mode.path, instance, parent, initial: mode.initial }
}

fn mode_id(mode: Option<plan::ModeIndex>) -> Option<ModeId> {
    mode.map(|mode| ModeId(id(mode.0)))
}

fn output_row(output: &plan::NetworkOutput) -> OutputRow<'_> {
    OutputRow {
        name: &output.name,
        source: port_id(output.source),
        ty: &output.ty,
        federate: output.federate,
        port: output.port,
        delay: interval(output.delay_ns),
        tells_absence: output.tells_absence,
        physical: output.physical,
    }
}

fn input_row<'p>(plan: &Plan, federate: &Federate, input: &'p plan::NetworkInput) -> InputRow<'p> {
    let fills = match federate.triggers[input.trigger.0].kind {
        plan::TriggerKind::Delay { fills, .. } | plan::TriggerKind::NetworkInput { fills, .. } => fills,
        // A plan has no inputs with other triggers; the tables' own check would find one.
        _ => plan::PortIndex(0),
    };
    let tardy = plan.is_decentralized() && !input.physical;
    InputRow {
        name: &input.name,
        trigger: TriggerId(id(input.trigger.0)),
        fills: port_id(fills),
        ty: &input.ty,
        federate: input.federate,
        delay: interval(input.delay_ns),
        level: input.level,
        awaited: input.awaited,
        physical: input.physical,
        tardy,
        max_wait: Interval::from_nanos(input.max_wait_ns),
        absent_after: Interval::from_nanos(input.absent_after_ns),
        readers: if tardy { readers(federate, fills) } else { Vec::new() },
    }
}

/// Returns the reactions that see a port and are not triggered by it.
fn readers(federate: &Federate, port: plan::PortIndex) -> Vec<ReactionId> {
    let triggered = &federate.ports[port.0].reactions;
    let reads = |reaction: &plan::ScheduledReaction| match &reaction.kind {
        plan::ReactionKind::Body { arguments, .. } => arguments.iter().any(|argument| argument.ports().contains(&port)),
        plan::ReactionKind::Send(_) | plan::ReactionKind::Copy { .. } => false,
    };
    let all = federate.reactions.iter().enumerate().filter(|(_, reaction)| reads(reaction));
    let readers = all.filter(|(index, _)| !triggered.contains(&plan::ReactionIndex(*index)));
    readers.map(|(index, _)| ReactionId(id(index))).collect()
}

fn reaction_ids(reactions: &[plan::ReactionIndex]) -> Vec<ReactionId> {
    reactions.iter().map(|reaction| ReactionId(id(reaction.0))).collect()
}

fn port_id(port: plan::PortIndex) -> PortId {
    PortId(id(port.0))
}

/// Converts an index to an id; the analysis has refused a federate whose lists exceed the range of ids.
fn id(index: usize) -> u16 {
    u16::try_from(index).unwrap_or(u16::MAX)
}

fn interval(ns: Option<i64>) -> Option<Interval> {
    ns.map(Interval::from_nanos)
}
