// SPDX-License-Identifier: Apache-2.0
//! A scenario: a federation as LF source text, and the world in which it runs. All of it follows from a seed.

mod decentralized;
mod generate;
mod ports;
mod reactors;
mod rich;
mod shrink;
mod source;

pub use rich::RICH;
pub(crate) use shrink::reductions;
pub(crate) use source::source;

impl Scenario {
    /// When a thread schedules the physical action with this path, in nanoseconds after the thread was started.
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

/// All that a run follows from.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Scenario {
    /// Decides what reactions do, and all that the world leaves open.
    pub(crate) seed: u64,
    pub(crate) target: Target,
    pub(crate) federates: Vec<Reactor>,
    pub(crate) connections: Vec<Connection>,
    pub(crate) conditions: Conditions,
    pub(crate) faults: Vec<Fault>,
    /// What a federation with decentralized coordination has beyond.
    pub(crate) decentralized: Option<Decentralized>,
}

/// What only scenarios with decentralized coordination have.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Decentralized {
    /// Whether all waits are to be as long as anything can delay a message. Else they are too short on purpose.
    pub(crate) is_safe: bool,
    /// Bytes of the buffers between federates beyond the least that is allowed.
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
    /// From 8 to 320 bytes, as the value wants it.
    Varying,
}

/// A reactor: a federate, or one inside of it.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct Reactor {
    pub(crate) inputs: Vec<Ty>,
    pub(crate) outputs: Vec<Ty>,
    /// Whether its ports are multiports as far as they can be.
    pub(crate) wide: bool,
    /// How many there are of a contained reactor, if it is a bank.
    pub(crate) bank: Option<usize>,
    /// The mode of its container that a contained reactor is in.
    pub(crate) mode: Option<usize>,
    /// How many modes it has.
    pub(crate) modes: usize,
    pub(crate) watchdogs: Vec<Watchdog>,
    /// `@maxwait` of a federate, where its connections have none; for ever where it has none either.
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
    /// None for once.
    pub(crate) period: Option<Nanos>,
    pub(crate) mode: Option<usize>,
}

#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Watchdog {
    pub(crate) timeout: Nanos,
    /// It has no triggers, and the mode of the watchdog.
    pub(crate) handler: Reaction,
}

#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Action {
    pub(crate) physical: bool,
    pub(crate) min_delay: Nanos,
    pub(crate) min_spacing: Option<(Nanos, &'static str)>,
    pub(crate) capacity: usize,
    pub(crate) mode: Option<usize>,
    /// When a thread that the program starts schedules a physical action, in nanoseconds after the start of the thread.
    pub(crate) outside: Vec<Nanos>,
}

/// Whether some federate reaches itself over connections, or over those without `after` only.
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
    /// An own port; an input at the source, an output at the destination.
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

/// What a reaction reads or writes.
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
    /// Whether it has a handler for what comes too late.
    pub(crate) tardy: bool,
    pub(crate) script: Script,
    pub(crate) mode: Option<usize>,
}

/// What a reaction does. It stands in the body, as words.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(crate) struct Script {
    /// How often of a hundred times each effect is set or scheduled.
    pub(crate) percent: u64,
    /// How many reactions in a row its events can cause, when nothing else caused it.
    pub(crate) energy: u64,
    /// How long it takes at most.
    pub(crate) work_ns: i64,
    /// How much later than it has to be an action is scheduled at most.
    pub(crate) offset_ns: i64,
    /// It asks to stop when it has run so often.
    pub(crate) stop_at: Option<u64>,
    /// The stop that it asks for is so much later.
    pub(crate) stop_offset_ns: i64,
}

/// What the world is like.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Conditions {
    /// One per participant, the RTI first.
    pub(crate) hosts: Vec<Host>,
    /// Whether reads and writes move parts of what they could.
    pub(crate) pieces: bool,
    pub(crate) rti: RtiConditions,
    /// Bytes of a federate's receive buffer beyond the least that is allowed.
    pub(crate) receive_spare: usize,
    /// Bytes of a federate's send buffer beyond the least that is allowed.
    pub(crate) send_spare: usize,
}

/// What the RTI is told, and how much memory it has.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct RtiConditions {
    pub(crate) dnet: bool,
    pub(crate) stop_all_after_loss: bool,
    pub(crate) start_time_multiple: Option<Nanos>,
    /// Tags in transit that are remembered per federate.
    pub(crate) in_transit: usize,
    /// Tags with messages that a federate may be behind its senders.
    pub(crate) window: usize,
    /// Bytes of each buffer beyond the least that is allowed.
    pub(crate) spare: usize,
}

/// One computer and its link to the network.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Host {
    /// When it is switched on.
    pub(crate) begins: Nanos,
    /// How far its clock is ahead.
    pub(crate) clock_offset: Nanos,
    /// How much too fast its clock is, in parts per thousand million.
    pub(crate) clock_drift_ppb: i64,
    /// What a turn of the event loop takes at most.
    pub(crate) turn_ns: Nanos,
    /// How late it is woken at most.
    pub(crate) wake_ns: Nanos,
    pub(crate) link: Wire,
}

/// What the connection between a federate and the RTI is like.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Wire {
    /// What every piece takes at least.
    pub(crate) latency: Nanos,
    /// What a piece takes longer, at most.
    pub(crate) jitter: Nanos,
    /// How often of a hundred times a piece takes ten times the jitter.
    pub(crate) slow_percent: u64,
    pub(crate) ns_per_byte: Nanos,
    /// Bytes that one direction holds.
    pub(crate) socket_bytes: usize,
}

/// Something that goes wrong.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Fault {
    /// Virtual time since the beginning of the world.
    pub(crate) at: Nanos,
    /// The RTI is 0, the federates follow.
    pub(crate) participant: usize,
    pub(crate) kind: FaultKind,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum FaultKind {
    /// The program is no more; its system closes its sockets.
    Vanish,
    /// All its connections break.
    Break,
    /// Somebody interrupts the program.
    Interrupt,
}
