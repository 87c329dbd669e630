// SPDX-License-Identifier: Apache-2.0
//! A small program in the shape that the compiler generates: a timer, inputs from other federates, one output port.
//!
//! The timer sets the output to how often it has fired. An input is noted, and with `relay` the output is set to it
//! plus one. `N` is the capacity of each input's queue. Levels can be set apart, for cycles without delay.

use lf_model::prelude::Asap;
use lf_model::time::{Interval, Tag};
use lf_model::{
    ActionTiming, Full, InputId, NetworkInput, NetworkOutput, OutputId, PayloadError, PhysicalActionQueue,
    PhysicalInbox, Port, PortCell, PortId, PortInfo, Program, QueuedPort, ReactionContext, ReactionId, ReactionInfo,
    ReactionKind, Tables, Timer, TriggerCell, TriggerId, TriggerInfo, TriggerKind, Undelivered,
};

use super::world::Side;

/// The engine's memory for any node of a test.
pub type NodeStorage = lf_model::Storage<16, 1, 1, 1>;

/// What a node does.
#[derive(Clone, Copy, Debug, Default)]
pub struct Behavior {
    /// Offset and period of its timer.
    pub timer: Option<(Interval, Interval)>,
    /// The output is set by inputs too.
    pub relay: bool,
    /// The timer's reaction takes this long.
    pub work: Interval,
    /// The program asks to stop when the timer has fired so often.
    pub stop_at: Option<u32>,
    /// The output is set once more at the end.
    pub farewell: bool,
    /// The timer schedules a physical action, which sets the output in its place.
    pub physical: bool,
    /// The level of the timer's reaction; the others follow.
    pub level: u16,
    /// The output is sent before this input and later ones are looked at, whose levels count from here.
    pub answers: Option<(usize, u16)>,
}

/// What a node has noted: the tag from the start, the input, the value.
pub type Log = Vec<(i64, u32, usize, u32)>;

pub struct Node<const N: usize> {
    tables: &'static Tables,
    behavior: Behavior,
    side: &'static Side,
    order: Vec<Does>,
    timer: Timer,
    physical: PhysicalActionQueue<u32, 4>,
    output: Port<u32>,
    inputs: Vec<QueuedPort<u32, N>>,
    fired: u32,
    pub log: Log,
    pub ended: bool,
}

const FIRST_INPUT_PORT: u16 = 1;
const PHYSICAL: TriggerId = TriggerId(3);
const FIRST_INPUT_TRIGGER: u16 = 4;

/// A connection as one of its ends sees it: the other federate, the port at the receiver, the delay, and whether the
/// receiver waits within a tag for what comes.
pub type End = (u16, u16, Option<Interval>, bool, bool);

/// What a reaction does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Does {
    Timer,
    Physical,
    Input(u16),
    Shutdown,
    Send(u16),
}

impl Does {
    fn info(self, level: u16) -> ReactionInfo {
        let kind = match self {
            Self::Send(output) => ReactionKind::Send(OutputId(output)),
            _ => ReactionKind::Body,
        };
        ReactionInfo { name: "node.reaction", level, deadline: None, tardy: false, kind }
    }
}

impl Behavior {
    /// The reactions in order, with their levels.
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
    /// A node with these connections from and to others; inputs in order of port.
    pub fn new(behavior: Behavior, side: &'static Side, inputs: &[End], outputs: &[End]) -> Self {
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
        let network_inputs = (0..).zip(inputs).map(|(input, (federate, _, delay, awaited, physical))| NetworkInput {
            name: "node.in",
            trigger: TriggerId(FIRST_INPUT_TRIGGER + input),
            federate: *federate,
            delay: *delay,
            max_len: 4,
            level: level(input),
            awaited: *awaited,
            physical: *physical,
            tardy: false,
            max_wait: Interval::ZERO,
            absent_after: Interval::ZERO,
            readers: &[],
        });
        let network_outputs = outputs.iter().map(|(federate, port, delay, awaited, physical)| NetworkOutput {
            name: "node.out",
            source: PortId(0),
            federate: *federate,
            port: *port,
            delay: delay.filter(|_| !physical),
            max_len: 4,
            tells_absence: *awaited,
            physical: *physical,
        });
        let tables = Tables {
            reactions: reactions.iter().map(|(does, level)| does.info(*level)).collect::<Vec<_>>().leak(),
            triggers: triggers.leak(),
            ports: ports.leak(),
            outputs: network_outputs.collect::<Vec<_>>().leak(),
            inputs: network_inputs.collect::<Vec<_>>().leak(),
            absence: ids(&|does| matches!(does, Does::Send(output) if outputs[usize::from(output)].3)),
        };
        tables.check();
        Self {
            tables: Box::leak(Box::new(tables)),
            behavior,
            side,
            order: reactions.iter().map(|(does, _)| *does).collect(),
            timer: Timer::new(),
            physical: PhysicalActionQueue::new(PHYSICAL, Box::leak(Box::new(PhysicalInbox::<u32, 4>::new()))),
            output: Port::new(PortId(0)),
            inputs: (0..input_count).map(|input| QueuedPort::new(PortId(FIRST_INPUT_PORT + input))).collect(),
            fired: 0,
            log: Log::new(),
            ended: false,
        }
    }

    fn on_timer(&mut self, ctx: &mut ReactionContext<'_>) {
        self.fired += 1;
        if self.behavior.physical {
            ctx.schedule_with_v(&mut self.physical, Some(self.fired), Asap);
        } else {
            ctx.set(&mut self.output, self.fired);
        }
        if self.behavior.work > Interval::ZERO {
            self.side.compute(self.behavior.work);
        }
        if self.behavior.stop_at == Some(self.fired) {
            ctx.request_stop(Asap);
        }
    }

    fn on_input(&mut self, input: usize, ctx: &mut ReactionContext<'_>) {
        let Some(value) = ctx.get(&self.inputs[input].port) else { return };
        let offset = ctx.get_logical_time().since(ctx.get_start_time()).as_nanos();
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
            Does::Input(input) => self.on_input(usize::from(input), ctx),
            Does::Shutdown => self.on_shutdown(ctx),
            Does::Send(_) => unreachable!("the engine sends"),
        }
    }

    fn miss_deadline(&mut self, _reaction: ReactionId, _ctx: &mut ReactionContext<'_>) {}

    fn port(&mut self, port: PortId) -> Option<&mut dyn PortCell> {
        match port.0.checked_sub(FIRST_INPUT_PORT) {
            None => Some(&mut self.output),
            Some(input) => self.inputs.get_mut(usize::from(input)).map(|input| &mut input.port as &mut dyn PortCell),
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

    fn capture(&mut self, _trigger: TriggerId, _tag: Tag) -> Result<(), Full> {
        Ok(())
    }

    fn encode(&self, _output: OutputId, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        self.output.encode(bytes)
    }

    fn deliver(&mut self, input: InputId, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
        self.inputs.get_mut(usize::from(input.0)).ok_or(Undelivered::NoSuchPort)?.deliver(tag, bytes)
    }
}
