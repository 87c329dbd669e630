// SPDX-License-Identifier: Apache-2.0
//! One participant: its instances, its storage, its reactions in execution order, and its part in the network.
//!
//! All times are nanoseconds. A connection delay of `None` means that there is no `after`; `Some(0)` is one microstep.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::serializer::Serializer;
use super::shape::Shape;
use super::source::{
    ClassIndex, InputIndex, InstanceIndex, Location, ModeIndex, OutputIndex, PortIndex, ReactionIndex, TriggerIndex,
    Type,
};

/// A federate, or the whole of a program that is not federated.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Federate {
    /// The id on the wire: the position in [`Plan::federates`](super::Plan::federates).
    pub id: u16,
    /// The name of the top-level instance, or of the main reactor.
    pub name: String,
    /// The place of the instance's or the main reactor's declaration.
    pub at: Location,
    /// The host from `at`, if it is given.
    pub host: Option<String>,
    /// Whether it comes and goes while the federation runs.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub transient: bool,
    /// The instance tree, parents before children, in order of declaration.
    pub instances: Vec<Instance>,
    /// The ports that store a value. An input that is connected without delay is the port that feeds it.
    pub ports: Vec<Port>,
    /// The modes of all instances, those of a container before those of its contents.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub modes: Vec<Mode>,
    /// All sources of events.
    pub triggers: Vec<Trigger>,
    /// The reactions in the order in which they run within a tag.
    pub reactions: Vec<ScheduledReaction>,
    /// The connections to other federates.
    pub outputs: Vec<NetworkOutput>,
    /// The connections from other federates, in the order of port numbers on the wire.
    pub inputs: Vec<NetworkInput>,
    /// Port numbers that none of the inputs has, ascending: those of connections from the federate to itself, over
    /// which other compilers also send.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub own_ports: Vec<u16>,
    /// The federates that send to this one directly, in order of id, with the least delay of the connections.
    pub upstream: Vec<Upstream>,
    /// The federates to which this one sends directly, in order of id.
    pub downstream: Vec<u16>,
    /// The least delay in nanoseconds on a path from a physical action, its minimum delay included, to an output to
    /// another federate; `None` if there is no such path. In a cycle without delay, the least minimum delay of any.
    pub physical_delay_ns: Option<i64>,
}

impl Federate {
    /// Returns the reactions that send outputs with [`NetworkOutput::tells_absence`].
    pub fn absence(&self) -> Vec<ReactionIndex> {
        let reports =
            |kind: &ReactionKind| matches!(kind, ReactionKind::Send(output) if self.outputs[output.0].tells_absence);
        let reactions = self.reactions.iter().enumerate();
        reactions.filter(|(_, reaction)| reports(&reaction.kind)).map(|(index, _)| ReactionIndex(index)).collect()
    }

    /// Returns the children of each class of which it has instances.
    pub(crate) fn children(&self, main: ClassIndex) -> BTreeSet<(ClassIndex, usize)> {
        let parent = |instance: &Instance| instance.parent.map_or(main, |parent| self.instances[parent.0].class);
        self.instances.iter().filter_map(|instance| Some((parent(instance), instance.child?))).collect()
    }

    /// Returns the reactions of each class that it has, by their numbers: all, except for those of the federated
    /// reactor.
    pub(crate) fn bodies(&self) -> BTreeSet<(ClassIndex, usize)> {
        let body = |reaction: &ScheduledReaction| match reaction.kind {
            ReactionKind::Body { instance, reaction, .. } => Some((self.instances[instance.0].class, reaction)),
            _ => None,
        };
        self.reactions.iter().filter_map(body).collect()
    }

    /// Returns the port number of an input on the wire.
    pub fn port_of(&self, input: InputIndex) -> u16 {
        port_of(&self.own_ports, input.0)
    }

    /// Returns the input with this port number on the wire, if there is one.
    pub fn input_of(&self, port: u16) -> Option<InputIndex> {
        (0..self.inputs.len()).map(InputIndex).find(|input| self.port_of(*input) == port)
    }
}

/// Returns the port number of the input at this position, skipping those of connections from the federate to itself.
pub(crate) fn port_of(own_ports: &[u16], input: usize) -> u16 {
    let port = u16::try_from(input).unwrap_or(u16::MAX);
    own_ports.iter().fold(port, |port, own| if *own <= port { port.saturating_add(1) } else { port })
}

impl Federate {
    /// Returns the federates that send directly to this one, in order of id.
    pub fn peers_in(&self) -> Vec<u16> {
        in_order(self.inputs.iter().filter(|input| input.direct).map(|input| input.federate))
    }

    /// Returns the federates to which this one sends directly, in order of id.
    pub fn peers_out(&self) -> Vec<u16> {
        in_order(self.outputs.iter().filter(|output| output.direct).map(|output| output.federate))
    }
}

fn in_order(federates: impl Iterator<Item = u16>) -> Vec<u16> {
    federates.collect::<std::collections::BTreeSet<_>>().into_iter().collect()
}

/// An instance of a reactor.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Instance {
    /// The path, with the federate's name first: `unit_a.sensor`.
    pub path: String,
    /// The reactor.
    pub class: ClassIndex,
    /// The instance that contains it; the top has none.
    pub parent: Option<InstanceIndex>,
    /// Its position in the containing class's [`children`](super::ReactorClass::children); for a federate's top, in
    /// those of the main class. `None` for the main reactor itself, and for a federate's share of the federated one.
    pub child: Option<usize>,
    /// The index of the member of a bank.
    pub bank_index: Option<usize>,
    /// The innermost mode that it is in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<ModeIndex>,
    /// The place of the instantiation.
    pub at: Location,
}

/// A mode of an instance.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mode {
    /// The path: `unit_a.sensor.Calibrating`.
    pub path: String,
    /// The instance.
    pub instance: InstanceIndex,
    /// Its position among the modes of the class.
    pub declared: usize,
    /// The innermost mode that the instance is in.
    pub parent: Option<ModeIndex>,
    /// Whether the instance begins in it.
    pub initial: bool,
    /// The place of the declaration.
    pub at: Location,
}

/// Storage for the value of a port.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Port {
    /// The path of the port that owns this storage: `unit_a.sensor.voltage`.
    pub path: String,
    /// The type of its values.
    pub ty: Type,
    /// The reactions that a value triggers, [`ReactionKind::Send`] included, in order of execution.
    pub reactions: Vec<ReactionIndex>,
    /// The [`TriggerKind::Delay`] triggers that delay its values.
    pub delays: Vec<TriggerIndex>,
    /// The place of the port's declaration.
    pub at: Location,
}

/// A source of events, with a queue of pending values if it has values.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trigger {
    /// The path of the timer, action or destination port; `startup` or `shutdown`.
    pub path: String,
    /// The kind.
    pub kind: TriggerKind,
    /// The maximum number of pending events; 1 for triggers that repeat or occur once.
    pub capacity: usize,
    /// The reactions that it triggers directly, in order of execution. Triggers that fill a port have none.
    pub reactions: Vec<ReactionIndex>,
    /// The innermost mode that it is in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<ModeIndex>,
    /// The place of the declaration; `None` for startup, shutdown and reset.
    pub at: Option<Location>,
}

/// The treatment of an action that is scheduled closer than its minimum spacing to the event before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SpacingPolicy {
    /// Defers the later event.
    Defer,
    /// Drops the later event.
    Drop,
    /// Replaces the earlier event's value by the later one's; without a spacing, at the same tag only.
    Replace,
    /// Drops the earlier event.
    Update,
}

/// The kinds of triggers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TriggerKind {
    /// Once, at the first tag.
    Startup,
    /// Once, at the last tag.
    Shutdown,
    /// When a mode is entered by reset, and for startup when one is entered for the first time.
    Reset,
    /// At the start plus the offset, then every period.
    Timer {
        /// The instance that owns it.
        instance: InstanceIndex,
        /// Nanoseconds after the start.
        offset_ns: i64,
        /// Nanoseconds between events; `None` for once.
        period_ns: Option<i64>,
    },
    /// A logical or a physical action.
    Action {
        /// The instance that owns it.
        instance: InstanceIndex,
        /// Whether it is physical.
        physical: bool,
        /// The type of its values.
        ty: Type,
        /// The minimum delay in nanoseconds.
        min_delay_ns: i64,
        /// The minimum spacing in nanoseconds; `None` for none.
        min_spacing_ns: Option<i64>,
        /// The treatment of an event that is too close to the previous one.
        policy: SpacingPolicy,
    },
    /// A watchdog, which has at most one pending event.
    Watchdog {
        /// The instance that owns it.
        instance: InstanceIndex,
        /// The time from its start to the event, in nanoseconds.
        timeout_ns: i64,
    },
    /// A connection with `after` inside this federate.
    Delay {
        /// The port whose values it carries.
        source: PortIndex,
        /// The port that it fills.
        fills: PortIndex,
        /// The delay in nanoseconds; 0 is the next microstep.
        delay_ns: i64,
        /// Whether the delay counts from physical time, as in a physical connection.
        physical: bool,
    },
    /// Received messages of another federate.
    NetworkInput {
        /// The input.
        input: InputIndex,
        /// The port that it fills.
        fills: PortIndex,
    },
}

/// A reaction with its position in the order of execution.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScheduledReaction {
    /// The name for messages: `unit_a.sensor.reaction_1`, or `unit_a.out -> unit_b.in` for one that sends.
    pub name: String,
    /// The level, which is common to all federates; reactions of one level do not depend on each other.
    pub level: u16,
    /// The deadline in nanoseconds.
    pub deadline_ns: Option<i64>,
    /// The innermost mode that it is in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<ModeIndex>,
    /// The code that it runs.
    pub kind: ReactionKind,
}

/// The code of a reaction.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ReactionKind {
    /// A body of the program.
    Body {
        /// The instance whose state it sees.
        instance: InstanceIndex,
        /// The reaction's number within the class, from 1.
        reaction: usize,
        /// One per parameter of the reaction, in the same order.
        arguments: Vec<Argument>,
    },
    /// Sending a port's value to another federate.
    Send(OutputIndex),
    /// A connection in a mode to a port outside of that mode.
    Copy {
        /// The port whose value is copied.
        from: PortIndex,
        /// The port that gets it.
        to: PortIndex,
    },
}

/// The storage that a variable of a reaction stands for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Argument {
    /// A port.
    Port(PortIndex),
    /// The channels of a multiport, or a port of each member of a bank.
    Ports(Vec<PortIndex>),
    /// The channels of a multiport of each member of a bank.
    Bank {
        /// All of them, those of the first member first.
        ports: Vec<PortIndex>,
        /// The number of channels of each member.
        widths: Vec<usize>,
    },
    /// An action, a timer or a watchdog.
    Trigger(TriggerIndex),
    /// A mode that the reaction can change to.
    Mode(ModeIndex),
}

impl Argument {
    /// Returns the ports behind it.
    pub fn ports(&self) -> &[PortIndex] {
        match self {
            Self::Port(port) => core::slice::from_ref(port),
            Self::Ports(ports) | Self::Bank { ports, .. } => ports,
            Self::Trigger(_) | Self::Mode(_) => &[],
        }
    }
}

/// A connection to another federate, at its source.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct NetworkOutput {
    /// The name for messages: `unit_a.out -> unit_b.in`.
    pub name: String,
    /// The port whose values are sent.
    pub source: PortIndex,
    /// The receiving federate.
    pub federate: u16,
    /// The port number on the wire: the position in the receiver's `inputs`.
    pub port: u16,
    /// The delay in nanoseconds.
    pub delay_ns: Option<i64>,
    /// Whether the sender reports absences to the receiver at each tag: there is no delay, and this federate is in a
    /// cycle without delay.
    pub tells_absence: bool,
    /// Whether the connection is physical; then its delay belongs to the receiver.
    pub physical: bool,
    /// Whether messages go directly to the receiving federate, not through the RTI.
    pub direct: bool,
    /// The type of the values.
    pub ty: Type,
    /// The serializer, if the type alone does not determine the bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serializer: Option<Serializer>,
    /// The layout of a value at the other end, if that is in another language, and this one's compiler has to check
    /// that it is the same here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counterpart: Option<Shape>,
    /// The place of the connection.
    pub at: Location,
}

/// A connection from another federate, at its destination.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct NetworkInput {
    /// The name for messages: `unit_a.out -> unit_b.in`.
    pub name: String,
    /// The trigger that holds the received messages.
    pub trigger: TriggerIndex,
    /// The sending federate.
    pub federate: u16,
    /// The delay in nanoseconds.
    pub delay_ns: Option<i64>,
    /// The lowest level of the reactions that see the port that it fills, those that send it included; `u16::MAX` if
    /// there are none.
    pub level: u16,
    /// Whether reactions from that level on wait until the status of the input is known. In centralized coordination,
    /// at a tag that is granted provisionally: there is no delay, the sender is in a cycle without delay, and this
    /// federate is in the same one or in none. In decentralized coordination, at all inputs of logical connections.
    pub awaited: bool,
    /// Whether the connection is physical: the delay counts from the physical time at which a message arrives.
    pub physical: bool,
    /// Whether messages come directly from the sending federate, not through the RTI.
    pub direct: bool,
    /// `@maxwait` in decentralized coordination: a tag begins this number of nanoseconds after its time if the input is
    /// not known earlier; [`i64::MAX`] means without end.
    pub max_wait_ns: i64,
    /// `@absent_after` in decentralized coordination, less the delay: the number of nanoseconds after that until an
    /// unknown value counts as absent; [`i64::MAX`] is never.
    pub absent_after_ns: i64,
    /// The minimum distance of two values in nanoseconds, for each timer or action that causes some; none for one that
    /// happens once. `None` if the rate of values is unknown.
    pub spacings_ns: Option<Vec<Option<i64>>>,
    /// The type of the values.
    pub ty: Type,
    /// The serializer, if the type alone does not determine the bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serializer: Option<Serializer>,
    /// The layout of a value at the other end, if that is in another language, and this one's compiler has to check
    /// that it is the same here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counterpart: Option<Shape>,
    /// The place of the connection.
    pub at: Location,
}

/// A federate that sends to this one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Upstream {
    /// Its id.
    pub federate: u16,
    /// The least delay in nanoseconds over all connections from it; `None` when one has no `after`.
    pub delay_ns: Option<i64>,
}
