// SPDX-License-Identifier: Apache-2.0
//! A small program in the shape that the compiler generates: a timer, inputs from other federates, one output port.
//!
//! The timer sets the output to how often it has fired. An input is noted, and with `relay` the output is set to it
//! plus one. `N` is the capacity of each input's queue.

use lf_model::prelude::Asap;
use lf_model::time::{Interval, Tag};
use lf_model::{
    Full, InputId, NetworkInput, NetworkOutput, OutputId, PayloadError, Port, PortCell, PortId, PortInfo, Program,
    QueuedPort, ReactionContext, ReactionId, ReactionInfo, ReactionKind, Tables, Timer, TriggerCell, TriggerId,
    TriggerInfo, TriggerKind, Undelivered,
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
}

/// What a node has noted: the tag from the start, the input, the value.
pub type Log = Vec<(i64, u32, usize, u32)>;

pub struct Node<const N: usize> {
    tables: &'static Tables,
    behavior: Behavior,
    side: &'static Side,
    timer: Timer,
    output: Port<u32>,
    inputs: Vec<QueuedPort<u32, N>>,
    fired: u32,
    pub log: Log,
    pub ended: bool,
}

const FIRST_INPUT_PORT: u16 = 1;
const FIRST_INPUT_TRIGGER: u16 = 3;

/// A connection as one of its ends sees it: the other federate, the port at the receiver, the delay.
pub type End = (u16, u16, Option<Interval>);

fn body(name: &'static str, level: u16) -> ReactionInfo {
    ReactionInfo { name, level, deadline: None, kind: ReactionKind::Body }
}

impl<const N: usize> Node<N> {
    /// A node with these connections from and to others; inputs in order of port.
    pub fn new(behavior: Behavior, side: &'static Side, inputs: &[End], outputs: &[End]) -> Self {
        let (input_count, output_count) = (u16::try_from(inputs.len()).unwrap(), u16::try_from(outputs.len()).unwrap());
        let mut reactions = vec![body("node.timer", 0)];
        reactions.extend((0..input_count).map(|input| body("node.input", 1 + input)));
        let shutdown = 1 + input_count;
        reactions.push(body("node.shutdown", shutdown));
        let sends: Vec<_> = (0..output_count).map(|output| ReactionId(shutdown + 1 + output)).collect();
        reactions.extend((0..output_count).map(|output| ReactionInfo {
            kind: ReactionKind::Send(OutputId(output)),
            ..body("node.send", shutdown + 1)
        }));
        let trigger = |name, kind, reactions: &[u16]| TriggerInfo {
            name,
            kind,
            reactions: reactions.iter().map(|id| ReactionId(*id)).collect::<Vec<_>>().leak(),
        };
        let (offset, period) = behavior.timer.unwrap_or((Interval::from_nanos(i64::MAX), Interval::ZERO));
        let mut triggers = vec![
            trigger("startup", TriggerKind::Startup, &[]),
            trigger("shutdown", TriggerKind::Shutdown, &[shutdown]),
            trigger("node.t", TriggerKind::Timer { offset, period }, &[0]),
        ];
        let mut ports = vec![PortInfo { name: "node.out", reactions: sends.leak(), delays: &[] }];
        for input in 0..input_count {
            triggers.push(trigger(
                "node.in",
                TriggerKind::NetworkInput { fills: PortId(FIRST_INPUT_PORT + input) },
                &[],
            ));
            ports.push(PortInfo { name: "node.in", reactions: vec![ReactionId(1 + input)].leak(), delays: &[] });
        }
        let network_inputs = (0..).zip(inputs).map(|(input, (federate, _, delay))| NetworkInput {
            name: "node.in",
            trigger: TriggerId(FIRST_INPUT_TRIGGER + input),
            federate: *federate,
            delay: *delay,
            max_len: 4,
            level: 1 + input,
            awaited: false,
        });
        let network_outputs = outputs.iter().map(|(federate, port, delay)| NetworkOutput {
            name: "node.out",
            source: PortId(0),
            federate: *federate,
            port: *port,
            delay: *delay,
            max_len: 4,
            tells_absence: false,
        });
        let tables = Tables {
            reactions: reactions.leak(),
            triggers: triggers.leak(),
            ports: ports.leak(),
            outputs: network_outputs.collect::<Vec<_>>().leak(),
            inputs: network_inputs.collect::<Vec<_>>().leak(),
            absence: &[],
        };
        tables.check();
        Self {
            tables: Box::leak(Box::new(tables)),
            behavior,
            side,
            timer: Timer::new(),
            output: Port::new(PortId(0)),
            inputs: (0..input_count).map(|input| QueuedPort::new(PortId(FIRST_INPUT_PORT + input))).collect(),
            fired: 0,
            log: Log::new(),
            ended: false,
        }
    }

    fn on_timer(&mut self, ctx: &mut ReactionContext<'_>) {
        self.fired += 1;
        ctx.set(&mut self.output, self.fired);
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
        if self.behavior.relay {
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
        match usize::from(reaction.0) {
            0 => self.on_timer(ctx),
            index if index <= self.inputs.len() => self.on_input(index - 1, ctx),
            _ => self.on_shutdown(ctx),
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
