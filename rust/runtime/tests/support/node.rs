// SPDX-License-Identifier: Apache-2.0
//! A small program in the shape that the compiler generates: a timer, inputs from other federates, one output port.
//!
//! The timer sets the output to the number of times that it has fired. The program notes each input, and with `relay`
//! sets the output to it plus one. `N` is the capacity of each input's queue. Levels can be set separately, for cycles
//! without delay.

use lf_model::prelude::Asap;
use lf_model::time::{Interval, Tag};
use lf_model::{
    ActionTiming, InputId, NetworkInput, NetworkOutput, OutputId, PayloadError, PhysicalActionQueue, PhysicalInbox,
    Placed, Port, PortId, PortInfo, Program, ReactionContext, ReactionId, ReactionInfo, ReactionKind, Tables,
    TardyInput, Timer, TriggerCell, TriggerId, TriggerInfo, TriggerKind, Undelivered,
};

use lf_testkit::world::Side;

/// The engine's memory for any node of a test.
pub(crate) type NodeStorage = lf_model::Storage<16, 1, 1, 1>;
/// The engine's memory for a node whose inputs can be tardy.
pub(crate) type TardyStorage = lf_model::Storage<16, 1, 1, 1, 1, 8>;

/// The behavior of a node.
#[derive(Clone, Copy, Debug, Default)]
#[allow(clippy::struct_excessive_bools, reason = "each is a feature of its own")]
pub(crate) struct Behavior {
    /// Offset and period of its timer.
    pub timer: Option<(Interval, Interval)>,
    /// Whether inputs set the output too.
    pub relay: bool,
    /// The duration of the timer's reaction.
    pub work: Interval,
    /// The number of times that the timer fires before the program requests a stop.
    pub stop_at: Option<u32>,
    /// Whether the output is set once more at the end.
    pub farewell: bool,
    /// Whether the timer schedules a physical action, which then sets the output.
    pub physical: bool,
    /// The level of the timer's reaction; the others follow.
    pub level: u16,
    /// The first input that is read only after the output is sent, and the level from which the levels of it and later
    /// ones count.
    pub answers: Option<(usize, u16)>,
    /// Whether the reactions to inputs have handlers for tardy ones.
    pub handles_tardy: bool,
}

/// The inputs that a node has noted: the tag from the start, the input, the value.
pub(crate) type Log = Vec<(i64, u32, usize, u32)>;

/// The tardy values of a node: the index in the log, the intended tag, and whether the handler saw it.
pub(crate) type Late = Vec<(usize, (i64, u32), bool)>;

pub(crate) struct Node<const N: usize> {
    tables: &'static Tables,
    behavior: Behavior,
    side: &'static Side,
    order: Vec<Does>,
    timer: Timer,
    physical: PhysicalActionQueue<u32, 4>,
    output: Port<u32>,
    inputs: Vec<TardyInput<u32, N>>,
    fired: u32,
    pub log: Log,
    pub late: Late,
    pub ended: bool,
}

const FIRST_INPUT_PORT: u16 = 1;
const PHYSICAL: TriggerId = TriggerId(3);
const FIRST_INPUT_TRIGGER: u16 = 4;

/// A connection as one of its ends sees it: the other federate, the port at the receiver, the delay, and whether the
/// receiver waits within a tag for messages; whether it is physical; with decentralized coordination, the time that the
/// receiver waits for it, before a tag and within it.
pub(crate) type End = (u16, u16, Option<Interval>, bool, bool, Option<(Interval, Interval)>);

/// The effect of a reaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Does {
    Timer,
    Physical,
    Input(u16),
    Shutdown,
    Send(u16),
}

impl Does {
    fn info(self, level: u16, handles_tardy: bool) -> ReactionInfo {
        let kind = match self {
            Self::Send(output) => ReactionKind::Send(OutputId(output)),
            _ => ReactionKind::Body,
        };
        let tardy = handles_tardy && matches!(self, Self::Input(_));
        ReactionInfo { name: "node.reaction", level, deadline: None, tardy, kind }
    }
}

/// The state that a node can hand over.
#[cfg(feature = "transients")]
pub(crate) const FIRED: lf_model::HandedOver =
    lf_model::HandedOver { name: "node.fired", id: 0x0706_0504_0302_0100, max_len: 4 };

impl Behavior {
    /// Returns the reactions in order, with their levels.
    fn reactions(&self, inputs: u16, outputs: u16) -> Vec<(Does, u16)> {
        let (early, late) = self.answers.map_or((inputs, 0), |(early, level)| (u16::try_from(early).unwrap(), level));
        let first =
            [Does::Timer, Does::Physical].into_iter().chain((0..early).map(Does::Input)).chain([Does::Shutdown]);
        let mut reactions: Vec<_> = first.zip(self.level..).collect();
        let send = reactions.last().unwrap().1 + 1;
        reactions.extend((0..outputs).map(|output| (Does::Send(output), send)));
        reactions.extend((early..inputs).map(Does::Input).zip(late..));
        reactions
    }
}

impl<const N: usize> Node<N> {
    /// Returns a node with these connections from and to others; inputs in order of port.
    pub(crate) fn new(behavior: Behavior, side: &'static Side, inputs: &[End], outputs: &[End]) -> Self {
        let (input_count, output_count) = (u16::try_from(inputs.len()).unwrap(), u16::try_from(outputs.len()).unwrap());
        let reactions = behavior.reactions(input_count, output_count);
        let ids = |which: &dyn Fn(Does) -> bool| -> &'static [ReactionId] {
            let chosen = (0..).zip(&reactions).filter(|(_, (does, _))| which(*does)).map(|(id, _)| ReactionId(id));
            chosen.collect::<Vec<_>>().leak()
        };
        let trigger = |name, kind, by: Option<Does>| TriggerInfo {
            name,
            kind,
            reactions: by.map_or(&[], |by| ids(&|does| does == by)),
        };
        let (offset, period) = behavior.timer.unwrap_or((Interval::from_nanos(i64::MAX), Interval::ZERO));
        let mut triggers = vec![
            trigger("startup", TriggerKind::Startup, None),
            trigger("shutdown", TriggerKind::Shutdown, Some(Does::Shutdown)),
            trigger("node.t", TriggerKind::Timer { offset, period }, Some(Does::Timer)),
            trigger("node.p", TriggerKind::Physical(ActionTiming::NONE), Some(Does::Physical)),
        ];
        let sends = ids(&|does| matches!(does, Does::Send(_)));
        let mut ports = vec![PortInfo { name: "node.out", reactions: sends, delays: &[] }];
        for input in 0..input_count {
            let fills = PortId(FIRST_INPUT_PORT + input);
            triggers.push(trigger("node.in", TriggerKind::NetworkInput { fills }, None));
            ports.push(PortInfo { name: "node.in", reactions: ids(&|does| does == Does::Input(input)), delays: &[] });
        }
        let level = |input| reactions.iter().find(|(does, _)| *does == Does::Input(input)).unwrap().1;
        let tables = Tables {
            reactions: reactions
                .iter()
                .map(|(does, level)| does.info(*level, behavior.handles_tardy))
                .collect::<Vec<_>>()
                .leak(),
            triggers: triggers.leak(),
            ports: ports.leak(),
            outputs: network_outputs(outputs),
            inputs: network_inputs(inputs, level),
            absence: ids(&|does| matches!(does, Does::Send(output) if outputs[usize::from(output)].3)),
            ..Tables::DEFAULT
        };
        tables.check();
        Self {
            tables: Box::leak(Box::new(tables)),
            behavior,
            side,
            order: reactions.iter().map(|(does, _)| *does).collect(),
            timer: Timer::new(),
            physical: PhysicalActionQueue::new(PHYSICAL, Box::leak(Box::new(PhysicalInbox::<u32, 4>::new())))
                .encoded_by(lf_model::encoder!(u32)),
            output: Port::new(PortId(0)),
            inputs: (0..input_count).map(|input| TardyInput::new(PortId(FIRST_INPUT_PORT + input))).collect(),
            fired: 0,
            log: Log::new(),
            late: Late::new(),
            ended: false,
        }
    }

    /// Leaves out port numbers, which none of its inputs has.
    pub(crate) fn with_own_ports(self, own_ports: &'static [u16]) -> Self {
        let tables = Tables { own_ports, ..*self.tables };
        tables.check();
        Self { tables: Box::leak(Box::new(tables)), ..self }
    }

    /// Hands over how often its timer has fired.
    #[cfg(feature = "transients")]
    pub(crate) fn with_state(self) -> Self {
        let tables = Tables { handed_over: &[FIRED], ..*self.tables };
        Self { tables: Box::leak(Box::new(tables)), ..self }
    }

    fn on_timer(&mut self, ctx: &mut ReactionContext<'_>) {
        self.fired += 1;
        if self.behavior.physical {
            ctx.schedule_with_v(&mut self.physical, Some(self.fired), Asap);
        } else {
            ctx.set(&mut self.output, self.fired);
        }
        if self.behavior.work > Interval::ZERO {
            self.side.compute(self.behavior.work.as_nanos().unsigned_abs());
        }
        if self.behavior.stop_at == Some(self.fired) {
            ctx.request_stop(Asap);
        }
    }

    fn on_input(&mut self, input: usize, ctx: &mut ReactionContext<'_>, is_handler: bool) {
        let Some(value) = ctx.get(&self.inputs[input].port) else { return };
        let offset = ctx.get_logical_time().since(ctx.get_start_time()).as_nanos();
        let intended = ctx.get_intended_tag(&self.inputs[input].port);
        if is_handler || intended != ctx.get_tag() {
            let meant = i64::try_from(intended.offset_from_t0.as_nanos()).unwrap();
            self.late.push((self.log.len(), (meant, intended.microstep), is_handler));
        }
        self.log.push((offset, ctx.get_tag().microstep, input, value));
        let sent = self.behavior.answers.is_some_and(|(early, _)| early <= input);
        if self.behavior.relay && !sent {
            ctx.set(&mut self.output, value.wrapping_add(1));
        }
    }

    fn on_shutdown(&mut self, ctx: &mut ReactionContext<'_>) {
        self.ended = true;
        if self.behavior.farewell {
            ctx.set(&mut self.output, u32::MAX);
        }
    }
}

/// Returns the table of inputs, whose reactions have the levels that `level` returns.
fn network_inputs(inputs: &[End], level: impl Fn(u16) -> u16) -> &'static [NetworkInput] {
    let inputs = (0..).zip(inputs).map(|(input, (federate, _, delay, awaited, physical, waits))| NetworkInput {
        name: "node.in",
        trigger: TriggerId(FIRST_INPUT_TRIGGER + input),
        federate: *federate,
        delay: *delay,
        max_len: 4,
        level: level(input),
        awaited: *awaited,
        physical: *physical,
        tardy: waits.is_some(),
        max_wait: waits.unwrap_or_default().0,
        absent_after: waits.unwrap_or_default().1,
        readers: &[],
    });
    inputs.collect::<Vec<_>>().leak()
}

/// Returns the table of outputs.
fn network_outputs(outputs: &[End]) -> &'static [NetworkOutput] {
    let outputs = outputs.iter().map(|(federate, port, delay, awaited, physical, _)| NetworkOutput {
        name: "node.out",
        source: PortId(0),
        federate: *federate,
        port: *port,
        delay: delay.filter(|_| !physical),
        max_len: 4,
        tells_absence: *awaited,
        physical: *physical,
    });
    outputs.collect::<Vec<_>>().leak()
}

impl<const N: usize> Program for Node<N> {
    fn tables(&self) -> &'static Tables {
        self.tables
    }

    fn react(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        match self.order[usize::from(reaction.0)] {
            Does::Timer => self.on_timer(ctx),
            Does::Physical => {
                let value = ctx.get(&self.physical);
                ctx.set_opt(&mut self.output, value);
            }
            Does::Input(input) => self.on_input(usize::from(input), ctx, false),
            Does::Shutdown => self.on_shutdown(ctx),
            Does::Send(_) => unreachable!("the engine sends"),
        }
    }

    fn handle_tardy(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        if let Does::Input(input) = self.order[usize::from(reaction.0)] {
            self.on_input(usize::from(input), ctx, true);
        }
    }

    fn clear_port(&mut self, port: PortId) {
        match port.0.checked_sub(FIRST_INPUT_PORT) {
            None => self.output.clear(),
            Some(input) => self.inputs[usize::from(input)].port.clear(),
        }
    }

    fn trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
        match trigger.0.checked_sub(FIRST_INPUT_TRIGGER) {
            None if trigger.0 == 2 => Some(&mut self.timer),
            None if trigger == PHYSICAL => Some(&mut self.physical),
            None => None,
            Some(input) => self.inputs.get_mut(usize::from(input)).map(|input| input as &mut dyn TriggerCell),
        }
    }

    fn encode(&self, _output: OutputId, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        self.output.encode(bytes)
    }

    fn deliver(&mut self, input: InputId, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
        self.inputs.get_mut(usize::from(input.0)).ok_or(Undelivered::NoSuchPort)?.deliver(tag, bytes)
    }

    fn deliver_tardy(&mut self, input: InputId, tag: Tag, intended: Tag, bytes: &[u8]) -> Result<Placed, Undelivered> {
        let input = self.inputs.get_mut(usize::from(input.0)).ok_or(Undelivered::NoSuchPort)?;
        input.deliver_tardy(tag, intended, bytes)
    }

    #[cfg(feature = "transients")]
    fn hand_over(&self, _state: u16, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        lf_model::Payload::encode(&self.fired, bytes)
    }

    #[cfg(feature = "transients")]
    fn take_over(&mut self, _state: u16, bytes: &[u8]) -> Result<(), PayloadError> {
        self.fired = lf_model::Payload::decode(bytes)?;
        Ok(())
    }
}
