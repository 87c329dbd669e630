// SPDX-License-Identifier: Apache-2.0
//! A scenario: a federation as LF source text, and the world in which it runs. All of it follows from a seed.

mod decentralized;
mod generate;
mod ports;
mod reactors;
mod rich;
mod shrink;
mod source;
mod transients;

pub use rich::RICH;
pub(crate) use shrink::reductions;
pub(crate) use source::{Form, player, source};

impl Scenario {
    /// Returns the times at which a thread schedules the physical action with this path, in nanoseconds after the
    /// thread's start.
    pub(crate) fn outside(&self, path: &str) -> &[Nanos] {
        // A member of a bank has the number of the bank.
        let number = |text: &str| text.split('[').next()?.get(1..)?.parse::<usize>().ok();
        let parts: Vec<_> = path.split('.').filter_map(number).collect();
        let action = match parts[..] {
            [federate, action] => self.federates.get(federate).and_then(|reactor| reactor.actions.get(action)),
            [federate, child, action] => {
                let federate = self.federates.get(federate);
                federate.and_then(|reactor| reactor.children.get(child)?.actions.get(action))
            }
            _ => None,
        };
        action.map_or(&[], |action| &action.outside)
    }
}

/// A time in nanoseconds.
pub(crate) type Nanos = i64;

pub(crate) const US: Nanos = 1_000;
pub(crate) const MS: Nanos = 1_000_000;
pub(crate) const SEC: Nanos = 1_000_000_000;

/// All inputs of a run.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Scenario {
    /// The seed of reactions' effects, and of all choices that the world leaves open.
    pub(crate) seed: u64,
    pub(crate) target: Target,
    pub(crate) federates: Vec<Reactor>,
    pub(crate) connections: Vec<Connection>,
    pub(crate) conditions: Conditions,
    pub(crate) faults: Vec<Fault>,
    /// The federate of each instance: first one of each federate, then those that come later. Instance `i` is the
    /// participant `i + 1`.
    pub(crate) instances: Vec<usize>,
    /// The further properties of a federation with decentralized coordination.
    pub(crate) decentralized: Option<Decentralized>,
}

/// The properties of scenarios with decentralized coordination only.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Decentralized {
    /// Whether all waits are to cover all delays of a message. Otherwise they are too short on purpose.
    pub(crate) is_safe: bool,
    /// The size in bytes of the buffers between federates beyond the allowed minimum.
    pub(crate) peer_spare: usize,
}

/// The target properties.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Target {
    pub(crate) timeout: Option<Nanos>,
    pub(crate) fast: bool,
    pub(crate) keepalive: bool,
    pub(crate) auth: bool,
    /// The advance message interval, if it is not to be the default.
    pub(crate) advance: Option<Nanos>,
    /// Exchanges of the initial clock synchronization; none for off.
    pub(crate) clock_sync: Option<u16>,
    /// The period of its rounds while the federation runs, if there are any.
    pub(crate) rounds: Option<Nanos>,
}

/// The type of a port's values.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Ty {
    /// 8 bytes.
    Small,
    /// 256 bytes.
    Large,
    /// From 8 to 320 bytes, depending on the value.
    Varying,
}

/// A reactor: a federate, or one inside of it.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct Reactor {
    pub(crate) inputs: Vec<Ty>,
    pub(crate) outputs: Vec<Ty>,
    /// Whether its ports are multiports wherever they can be.
    pub(crate) wide: bool,
    /// The width of a contained reactor's bank, if it is one.
    pub(crate) bank: Option<usize>,
    /// The mode of its container that a contained reactor is in.
    pub(crate) mode: Option<usize>,
    /// The number of its modes.
    pub(crate) modes: usize,
    pub(crate) watchdogs: Vec<Watchdog>,
    /// Whether a federate comes and goes while the federation runs.
    pub(crate) transient: bool,
    /// Whether such a federate hands over its state.
    pub(crate) hands_over: bool,
    /// `@maxwait` of a federate, where its connections have none; forever where it has none either.
    pub(crate) max_wait: Option<Nanos>,
    pub(crate) timers: Vec<Timer>,
    pub(crate) actions: Vec<Action>,
    pub(crate) children: Vec<Reactor>,
    pub(crate) links: Vec<Link>,
    pub(crate) reactions: Vec<Reaction>,
}

#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Timer {
    pub(crate) offset: Nanos,
    /// The period; none for a single event.
    pub(crate) period: Option<Nanos>,
    pub(crate) mode: Option<usize>,
}

#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Watchdog {
    pub(crate) timeout: Nanos,
    /// The handler, without triggers, in the mode of the watchdog.
    pub(crate) handler: Reaction,
}

#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Action {
    pub(crate) physical: bool,
    pub(crate) min_delay: Nanos,
    pub(crate) min_spacing: Option<(Nanos, &'static str)>,
    pub(crate) capacity: usize,
    pub(crate) mode: Option<usize>,
    /// The times at which a thread of the program schedules a physical action, in nanoseconds after its start.
    pub(crate) outside: Vec<Nanos>,
}

/// Returns whether some federate reaches itself over connections, or over those without `after` only.
pub(crate) fn has_cycle(count: usize, connections: &[Connection], direct: bool) -> bool {
    let leads = |from: usize| {
        let usable = connections.iter().filter(move |one| !direct || one.after.is_none());
        usable.filter(move |one| one.from.0 == from).map(|one| one.to.0)
    };
    (0..count).any(|first| {
        let mut reached = vec![false; count];
        let mut open: Vec<_> = leads(first).collect();
        while let Some(next) = open.pop() {
            if !std::mem::replace(&mut reached[next], true) {
                open.extend(leads(next));
            }
        }
        reached[first]
    })
}

/// One end of a connection inside a reactor.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum LinkEnd {
    /// Its own port; an input at the source, an output at the destination.
    Own(usize),
    /// A port of a contained reactor; an output at the source, an input at the destination.
    Child(usize, usize),
}

/// A connection inside a reactor.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Link {
    pub(crate) from: LinkEnd,
    pub(crate) to: LinkEnd,
    pub(crate) after: Option<Nanos>,
    pub(crate) capacity: usize,
    pub(crate) mode: Option<usize>,
}

/// A connection between federates.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Connection {
    /// Federate and output.
    pub(crate) from: (usize, usize),
    /// Federate and input.
    pub(crate) to: (usize, usize),
    pub(crate) after: Option<Nanos>,
    pub(crate) capacity: Option<usize>,
    /// `@maxwait`.
    pub(crate) max_wait: Option<Nanos>,
    /// `@absent_after`.
    pub(crate) absent_after: Option<Nanos>,
}

/// A variable that a reaction reads or writes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Variable {
    Startup,
    Shutdown,
    Reset,
    Mode { mode: usize, history: bool },
    Watchdog(usize),
    Timer(usize),
    Action(usize),
    Input(usize),
    Output(usize),
    ChildInput(usize, usize),
    ChildOutput(usize, usize),
}

#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Reaction {
    pub(crate) triggers: Vec<Variable>,
    pub(crate) uses: Vec<Variable>,
    pub(crate) effects: Vec<Variable>,
    /// Whether it has a handler for tardy inputs.
    pub(crate) tardy: bool,
    pub(crate) script: Script,
    pub(crate) mode: Option<usize>,
}

/// The behavior of a reaction. Its body contains it as text.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(crate) struct Script {
    /// The percentage with which each effect is set or scheduled.
    pub(crate) percent: u64,
    /// The number of reactions in a row that its events can cause, if they have no other cause.
    pub(crate) energy: u64,
    /// The maximum duration.
    pub(crate) work_ns: i64,
    /// The maximum additional delay of a scheduled action.
    pub(crate) offset_ns: i64,
    /// The execution in which it requests a stop.
    pub(crate) stop_at: Option<u64>,
    /// The delay of the requested stop.
    pub(crate) stop_offset_ns: i64,
    /// The execution in which it stops its federate alone.
    pub(crate) leave_at: Option<u64>,
    /// Whether it only sets its effect to the value of its trigger.
    pub(crate) plays: bool,
}

/// The properties of the world.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Conditions {
    /// One per participant, the RTI first.
    pub(crate) hosts: Vec<Host>,
    /// Whether reads and writes move parts of what they could.
    pub(crate) pieces: bool,
    pub(crate) rti: RtiConditions,
    /// The size in bytes of a federate's receive buffer beyond the allowed minimum.
    pub(crate) receive_spare: usize,
    /// The size in bytes of a federate's send buffer beyond the allowed minimum.
    pub(crate) send_spare: usize,
}

/// The configuration and the memory of the RTI.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct RtiConditions {
    pub(crate) dnet: bool,
    pub(crate) stop_all_after_loss: bool,
    pub(crate) start_time_multiple: Option<Nanos>,
    /// Tags in transit that the RTI remembers per federate.
    pub(crate) in_transit: usize,
    /// Tags with messages that a federate may be behind its senders.
    pub(crate) window: u16,
    /// The size in bytes of each buffer beyond the allowed minimum.
    pub(crate) spare: usize,
}

/// One computer and its link to the network.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Host {
    /// The time at which it is switched on.
    pub(crate) begins: Nanos,
    /// The lead of its clock.
    pub(crate) clock_offset: Nanos,
    /// The drift of its clock, in parts per billion.
    pub(crate) clock_drift_ppb: i64,
    /// The maximum duration of a turn of the event loop.
    pub(crate) turn_ns: Nanos,
    /// The maximum delay of a wake-up.
    pub(crate) wake_ns: Nanos,
    pub(crate) link: Wire,
}

/// The properties of the connection between a federate and the RTI.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Wire {
    /// The minimum latency of a piece.
    pub(crate) latency: Nanos,
    /// The maximum additional latency of a piece.
    pub(crate) jitter: Nanos,
    /// The percentage of pieces that take ten times the jitter.
    pub(crate) slow_percent: u64,
    pub(crate) ns_per_byte: Nanos,
    /// The capacity in bytes of one direction.
    pub(crate) socket_bytes: usize,
}

/// An event from outside that happens to a participant: a fault, or its coming.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Fault {
    /// The virtual time since the RTI has chosen the start; if it is `early`, since the beginning of the world.
    pub(crate) at: Nanos,
    pub(crate) early: bool,
    /// The participant: the RTI is 0, the federates follow.
    pub(crate) participant: usize,
    pub(crate) kind: FaultKind,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum FaultKind {
    /// The process begins. Participants without this begin at [`Host::begins`].
    Begin,
    /// The process ends; its system closes its sockets.
    Vanish,
    /// All its connections break.
    Break,
    /// The program is interrupted.
    Interrupt,
}
