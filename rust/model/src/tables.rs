// SPDX-License-Identifier: Apache-2.0
//! The structure of a program: reactions, triggers, ports and network connections as constant tables.
//!
//! The generator writes one `const TABLES: Tables` per federate, and `const _: () = TABLES.check();` beside it, so that
//! inconsistent tables do not compile. The engine then trusts the tables.
pub(crate) use crate::ids::{InputId, OutputId, PortId, ReactionId, TriggerId};
use crate::modes::{ModeState, Modes, Transition};
use crate::time::Interval;

/// Everything about a program that does not change while it runs.
#[derive(Clone, Copy, Debug)]
pub struct Tables {
    /// The reactions in the order in which they run within a tag: by level, then by instantiation.
    pub reactions: &'static [ReactionInfo],
    /// Everything that can put an event into the queue.
    pub triggers: &'static [TriggerInfo],
    /// The ports that store a value. An input that is connected without delay is the port that feeds it.
    pub ports: &'static [PortInfo],
    /// The outputs to other federates.
    pub outputs: &'static [NetworkOutput],
    /// The inputs from other federates, in the order of port numbers on the wire.
    pub inputs: &'static [NetworkInput],
    /// Port numbers that none of the inputs has, ascending: other compilers send the messages from this federate to
    /// itself there.
    pub own_ports: &'static [u16],
    /// The reactions that send outputs with [`NetworkOutput::tells_absence`]: they run at every tag.
    pub absence: &'static [ReactionId],
    /// The modes, and their parts, if there are any.
    pub modes: Option<&'static Modes>,
    /// The states that a transient federate hands over to the instance that takes its place.
    #[cfg(feature = "transients")]
    pub handed_over: &'static [HandedOver],
    /// The number of threads that run reactions: more than one run those of a level side by side.
    #[cfg(feature = "workers")]
    pub workers: u16,
}

impl Tables {
    /// The tables of a program without any parts, for what generated ones leave out.
    pub const DEFAULT: Self = Self {
        reactions: &[],
        triggers: &[],
        ports: &[],
        outputs: &[],
        inputs: &[],
        own_ports: &[],
        absence: &[],
        modes: None,
        #[cfg(feature = "transients")]
        handed_over: &[],
        #[cfg(feature = "workers")]
        workers: 1,
    };
}

/// A reaction, at its rank in the order of execution.
#[derive(Clone, Copy, Debug)]
pub struct ReactionInfo {
    /// For people: `unit_a.sensor.reaction_1`.
    pub name: &'static str,
    /// Reactions of one level do not depend on each other; a lower level runs before a higher one.
    pub level: u16,
    /// The longest time after the tag's time within which the body may begin; later, the deadline's handler runs
    /// instead.
    pub deadline: Option<Interval>,
    /// Whether it has a handler that runs instead of the body when an input is tardy.
    pub tardy: bool,
    /// The kind of its code.
    pub kind: ReactionKind,
}

impl ReactionInfo {
    /// A body of level 0 with neither a deadline nor a handler, for what generated tables leave out.
    pub const DEFAULT: Self = Self { name: "", level: 0, deadline: None, tardy: false, kind: ReactionKind::Body };
}

/// The kind of a reaction's code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReactionKind {
    /// A body of the program, through [`Program::react`](crate::Program::react).
    Body,
    /// Sends a port's value to another federate; it is one of the reactions that the port triggers.
    Send(OutputId),
}

/// A source of events.
#[derive(Clone, Copy, Debug)]
pub struct TriggerInfo {
    /// For people: `unit_a.sensor.sample`, `startup`.
    pub name: &'static str,
    /// Its kind.
    pub kind: TriggerKind,
    /// The reactions that an event triggers. None for a trigger that fills a port: there, the port has them.
    pub reactions: &'static [ReactionId],
}

/// The kinds of triggers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TriggerKind {
    /// Once, at the first tag.
    Startup,
    /// Once, at the last tag.
    Shutdown,
    /// When a mode is entered: its reactions are those that `reset` triggers. A program with modes has one, which also
    /// triggers startup reactions in modes that are not active from the start.
    Reset,
    /// At the start plus `offset`, then every `period`; a period of zero means once.
    Timer {
        /// From the start to the first event.
        offset: Interval,
        /// From event to event.
        period: Interval,
    },
    /// An action whose events count from the tag at which they are scheduled.
    Logical(ActionTiming),
    /// An action whose events count from the physical time at which they are scheduled, by any thread.
    Physical(ActionTiming),
    /// A connection with `after` inside the federate.
    Delay {
        /// The port that it fills.
        fills: PortId,
        /// The delay; zero is the next microstep.
        delay: Interval,
    },
    /// A physical connection inside the federate: events count from the physical time at which the tag of the source
    /// is complete, as those of a physical action do.
    PhysicalDelay {
        /// The port that it fills.
        fills: PortId,
        /// Added to physical time.
        delay: Interval,
    },
    /// Messages from another federate.
    NetworkInput {
        /// The port that it fills.
        fills: PortId,
    },
}

impl TriggerKind {
    /// Returns the port that such a trigger fills.
    pub const fn fills(&self) -> Option<PortId> {
        match *self {
            Self::Delay { fills, .. } | Self::PhysicalDelay { fills, .. } | Self::NetworkInput { fills } => Some(fills),
            _ => None,
        }
    }
}

/// The timing of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActionTiming {
    /// Added to the offset of every event.
    pub min_delay: Interval,
    /// The minimum time from one event to the next; `None` for none.
    pub min_spacing: Option<Interval>,
    /// The rule for an event that comes closer than that.
    pub policy: Policy,
}

impl ActionTiming {
    /// No delay and no spacing, as for `logical action a`.
    pub const NONE: Self = Self { min_delay: Interval::ZERO, min_spacing: None, policy: Policy::Defer };
}

/// The rule for an event that is scheduled closer than the minimum spacing to the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Policy {
    /// It happens later, when the spacing is kept.
    Defer,
    /// It does not happen. Without a spacing, that goes for an event at the same tag only.
    Drop,
    /// Its value replaces that of the pending event; if that one has happened, it is deferred. Without a spacing, that
    /// goes for an event at the same tag only.
    Replace,
    /// It replaces the pending event; it is deferred if it would come too close to another.
    Update,
}

/// A port that stores a value.
#[derive(Clone, Copy, Debug)]
pub struct PortInfo {
    /// For people: `unit_a.sensor.voltage`.
    pub name: &'static str,
    /// The reactions that a value triggers, those that send it included, in order of execution.
    pub reactions: &'static [ReactionId],
    /// The [`TriggerKind::Delay`] and [`TriggerKind::PhysicalDelay`] triggers that carry a value on.
    pub delays: &'static [TriggerId],
}

/// A connection to another federate, at its source.
#[derive(Clone, Copy, Debug)]
pub struct NetworkOutput {
    /// For people: `unit_a.out -> unit_b.in`.
    pub name: &'static str,
    /// The port whose values are sent.
    pub source: PortId,
    /// The receiving federate.
    pub federate: u16,
    /// The port number on the wire.
    pub port: u16,
    /// The connection's `after`; `None` without one.
    pub delay: Option<Interval>,
    /// The longest payload in bytes: `<T as Payload>::MAX_LEN`.
    pub max_len: usize,
    /// Whether the receiver is sent the absence of a value at each tag, because this federate is in a cycle without
    /// delay and the receiver may wait for that.
    pub tells_absence: bool,
    /// Whether the connection is physical: the receiver chooses the tag, and adds the delay of `after`.
    pub physical: bool,
}

impl NetworkOutput {
    /// A logical connection without a delay, for what generated tables leave out.
    pub const DEFAULT: Self = Self {
        name: "",
        source: PortId(0),
        federate: 0,
        port: 0,
        delay: None,
        max_len: 0,
        tells_absence: false,
        physical: false,
    };
}

/// A connection from another federate, at its destination.
#[derive(Clone, Copy, Debug)]
pub struct NetworkInput {
    /// For people: `unit_a.out -> unit_b.in`.
    pub name: &'static str,
    /// The trigger that holds received messages, of kind [`TriggerKind::NetworkInput`].
    pub trigger: TriggerId,
    /// The sending federate.
    pub federate: u16,
    /// The connection's `after`; `None` without one.
    pub delay: Option<Interval>,
    /// The longest payload in bytes: `<T as Payload>::MAX_LEN`.
    pub max_len: usize,
    /// The lowest level of the reactions that see the port that it fills, those that send included; `u16::MAX` if none
    /// does. A message for a tag that is open is in time while no reaction from this level on has run.
    pub level: u16,
    /// Whether reactions from [`level`](Self::level) on have to wait until the input is known at a provisionally
    /// granted tag, because the sender is in a cycle without delay. The event loop sees to that.
    pub awaited: bool,
    /// Whether the connection is physical: messages have no tag, and take effect on arrival, after the delay.
    pub physical: bool,
    /// Whether a message may come after its tag. Then it is tardy, and takes effect at the next microstep; the input's
    /// queue is a [`TardyInput`](crate::TardyInput).
    pub tardy: bool,
    /// The time after a tag's time for which the tag waits for messages here before it: `@maxwait`. The event loop
    /// sees to that, if inputs can be tardy.
    pub max_wait: Interval,
    /// The additional time for which, within a tag, reactions from [`level`](Self::level) on wait for messages here at
    /// that tag: `@absent_after` less the connection's delay.
    pub absent_after: Interval,
    /// The reactions that see the port that it fills, but are not triggered by it: they too are tardy with it.
    pub readers: &'static [ReactionId],
}

impl NetworkInput {
    /// A logical connection without a delay and without readers, for what generated tables leave out.
    pub const DEFAULT: Self = Self {
        name: "",
        trigger: TriggerId(0),
        federate: 0,
        delay: None,
        max_len: 0,
        level: u16::MAX,
        awaited: false,
        physical: false,
        tardy: false,
        max_wait: Interval::ZERO,
        absent_after: Interval::ZERO,
        readers: &[],
    };
}

/// A state variable that a transient federate hands over.
#[derive(Clone, Copy, Debug)]
pub struct HandedOver {
    /// For people: `filter.seen`.
    pub name: &'static str,
    /// A number that follows from its name and its type, by which another build of the program finds it.
    pub id: u64,
    /// The maximum number of bytes of its value.
    pub max_len: usize,
}

impl HandedOver {
    /// Bytes before the value where it is sent: those of [`HandedOver::id`], little-endian.
    pub const ID_BYTES: usize = size_of::<u64>();
}

/// Returns the number of 32-bit words that hold `bits` bits.
pub const fn words(bits: usize) -> usize {
    bits.div_ceil(32)
}

impl Tables {
    /// Returns the input that has this port number on the wire, if one has.
    pub fn input_of(&self, port: u16) -> Option<InputId> {
        let is_own = self.own_ports.contains(&port);
        let input = self.own_ports.iter().filter(|own| **own < port).fold(port, |input, _| input.saturating_sub(1));
        (!is_own && usize::from(input) < self.inputs.len()).then_some(InputId(input))
    }

    /// Returns the port number of an input on the wire.
    pub fn port_of(&self, input: InputId) -> u16 {
        self.own_ports.iter().fold(input.0, |port, own| if *own <= port { port.saturating_add(1) } else { port })
    }

    /// Returns the number of inputs whose intended tags the engine has to store: all, if any can be tardy.
    pub const fn tardy_inputs(&self) -> usize {
        let mut i = 0;
        while i < self.inputs.len() {
            if self.inputs[i].tardy {
                return self.inputs.len();
            }
            i += 1;
        }
        0
    }

    /// Returns the number of reactions that the engine has to mark as tardy: all, if any input can be.
    pub const fn tardy_reactions(&self) -> usize {
        if self.tardy_inputs() == 0 { 0 } else { self.reactions.len() }
    }

    /// Returns the number of modes whose state the engine has to store.
    pub const fn mode_count(&self) -> usize {
        match self.modes {
            Some(modes) => modes.modes.len(),
            None => 0,
        }
    }

    /// Returns the number of triggers whose event the engine has to store while they are not active: those in modes.
    pub const fn held_triggers(&self) -> usize {
        match self.modes {
            Some(modes) => modes.triggers.len(),
            None => 0,
        }
    }

    /// Returns whether a reaction is in no mode, or in an active one; the last tag has its own rule.
    pub(crate) fn runs(&self, modes: &[ModeState], reaction: ReactionId, is_last: bool) -> bool {
        self.modes.is_none_or(|known| (known.hooks.runs)(known, modes, reaction, is_last))
    }

    /// Returns whether a trigger is in no mode, or in an active one.
    pub(crate) fn is_active(&self, modes: &[ModeState], trigger: TriggerId) -> bool {
        self.modes.is_none_or(|known| (known.hooks.is_active)(known, modes, trigger))
    }

    /// Stores the mode that a reaction has requested.
    pub(crate) fn request_mode(&self, modes: &mut [ModeState], wanted: Transition) {
        if let Some(known) = self.modes {
            (known.hooks.request)(known, modes, wanted);
        }
    }

    /// Returns the number of words of memory that a worker needs for its notes.
    #[cfg(feature = "workers")]
    pub const fn note_words(&self) -> usize {
        words(self.reactions.len()) + words(self.tardy_reactions()) + words(self.ports.len())
    }

    /// Checks that ids are in range, levels rise with the order of execution, and the parts agree with each other.
    ///
    /// # Panics
    /// When they do not, with a sentence that says which table is wrong. It is meant for `const _: () = …`.
    pub const fn check(&self) {
        assert!(self.reactions.len() <= u16::MAX as usize, "more reactions than a ReactionId can number");
        assert!(self.triggers.len() <= u16::MAX as usize / 2, "more triggers than the event queue can number");
        assert!(self.ports.len() <= u16::MAX as usize, "more ports than a PortId can number");
        self.check_reactions();
        self.check_triggers();
        self.check_ports();
        self.check_network();
        if let Some(modes) = self.modes {
            modes.check(self.reactions.len(), self.triggers.len());
        }
    }

    const fn check_reactions(&self) {
        let mut i = 0;
        while i < self.reactions.len() {
            let reaction = &self.reactions[i];
            assert!(i == 0 || self.reactions[i - 1].level <= reaction.level, "reactions are not in order of level");
            if let ReactionKind::Send(output) = reaction.kind {
                assert!((output.0 as usize) < self.outputs.len(), "a reaction sends to an output that does not exist");
            }
            i += 1;
        }
    }

    const fn check_triggers(&self) {
        let mut i = 0;
        while i < self.triggers.len() {
            let trigger = &self.triggers[i];
            self.check_reaction_ids(trigger.reactions);
            if let Some(fills) = trigger.kind.fills() {
                assert!((fills.0 as usize) < self.ports.len(), "a trigger fills a port that does not exist");
                assert!(trigger.reactions.is_empty(), "a trigger that fills a port has reactions of its own");
            }
            i += 1;
        }
    }

    const fn check_ports(&self) {
        let mut i = 0;
        while i < self.ports.len() {
            self.check_reaction_ids(self.ports[i].reactions);
            let delays = self.ports[i].delays;
            let mut j = 0;
            while j < delays.len() {
                let delay = delays[j].0 as usize;
                assert!(delay < self.triggers.len(), "a port is delayed by a trigger that does not exist");
                assert!(
                    matches!(self.triggers[delay].kind, TriggerKind::Delay { .. } | TriggerKind::PhysicalDelay { .. }),
                    "a port is delayed by a trigger of another kind"
                );
                j += 1;
            }
            i += 1;
        }
    }

    const fn check_network(&self) {
        let mut i = 0;
        while i < self.outputs.len() {
            assert!((self.outputs[i].source.0 as usize) < self.ports.len(), "an output's source does not exist");
            i += 1;
        }
        let mut i = 0;
        while i < self.inputs.len() {
            let trigger = self.inputs[i].trigger.0 as usize;
            assert!(trigger < self.triggers.len(), "an input's trigger does not exist");
            assert!(
                matches!(self.triggers[trigger].kind, TriggerKind::NetworkInput { .. }),
                "an input's trigger is of another kind"
            );
            self.check_reaction_ids(self.inputs[i].readers);
            i += 1;
        }
        let mut i = 1;
        while i < self.own_ports.len() {
            assert!(self.own_ports[i - 1] < self.own_ports[i], "port numbers of its own are not in order");
            i += 1;
        }
        let mut i = 0;
        while i < self.absence.len() {
            let reaction = self.absence[i].0 as usize;
            assert!(reaction < self.reactions.len(), "a reaction that does not exist tells absence");
            assert!(
                matches!(self.reactions[reaction].kind, ReactionKind::Send(output)
                    if self.outputs[output.0 as usize].tells_absence),
                "a reaction tells absence, but does not send an output that does"
            );
            i += 1;
        }
    }

    const fn check_reaction_ids(&self, ids: &[ReactionId]) {
        let mut i = 0;
        while i < ids.len() {
            assert!((ids[i].0 as usize) < self.reactions.len(), "a reaction that does not exist is triggered");
            i += 1;
        }
    }
}
