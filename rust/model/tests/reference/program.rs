// SPDX-License-Identifier: Apache-2.0
//! The random program for the engine, in the shape of generated code.

use lf_model::{
    ActionTiming, Full, InputId, Instant, Interval, LogicalActionQueue, NetworkInput, NetworkOutput, Offset, OutputId,
    PayloadError, Policy, Port, PortId, PortInfo, Program, QueuedPort, ReactionContext, ReactionId, ReactionInfo,
    ReactionKind, Tables, Tag, Timer, TriggerCell, TriggerId, TriggerInfo, TriggerKind, Undelivered,
};

use super::{
    ACTION_CAPACITY, ACTIONS, AT_ACTIONS, AT_DELAYED, AT_INPUTS, AT_PORTS, AT_SENDS, AT_TIMERS, Effect, INPUTS, PORTS,
    Plan, QUEUE_CAPACITY, SHUTDOWN, START, Step, TIMERS, TagPair, effects,
};

/// Triggers in order: startup, timers, actions, inputs, delays, shutdown. Ports: ports, delayed ends, inputs.
pub(crate) struct RandomProgram {
    plan: Plan,
    pub tables: &'static Tables,
    timers: [Timer; TIMERS],
    actions: [LogicalActionQueue<u32, ACTION_CAPACITY>; ACTIONS],
    inputs: [QueuedPort<u32, QUEUE_CAPACITY>; INPUTS],
    delayed: [QueuedPort<u32, QUEUE_CAPACITY>; PORTS],
    ports: [Port<u32>; PORTS],
    pub trace: Vec<Step>,
}

fn id(index: usize) -> u16 {
    u16::try_from(index).unwrap()
}

fn leak<T>(items: Vec<T>) -> &'static [T] {
    Box::leak(items.into_boxed_slice())
}

fn trigger(kind: TriggerKind, reaction: usize) -> TriggerInfo {
    let fills = matches!(kind, TriggerKind::Delay { .. } | TriggerKind::NetworkInput { .. });
    let reactions = if fills { &[] } else { leak(vec![ReactionId(id(reaction))]) };
    TriggerInfo { name: "trigger", kind, reactions }
}

fn tables(plan: &Plan) -> Tables {
    let reactions = (0..AT_SENDS + PORTS).map(|index| ReactionInfo {
        name: "reaction",
        level: id(index),
        deadline: None,
        tardy: false,
        kind: index.checked_sub(AT_SENDS).map_or(ReactionKind::Body, |port| ReactionKind::Send(OutputId(id(port)))),
    });
    let mut triggers = vec![trigger(TriggerKind::Startup, 0)];
    triggers.extend(plan.timers.iter().enumerate().map(|(index, &(offset, period))| {
        trigger(
            TriggerKind::Timer { offset: Interval::from_nanos(offset), period: Interval::from_nanos(period) },
            AT_TIMERS + index,
        )
    }));
    triggers.extend(plan.actions.iter().enumerate().map(|(index, action)| {
        let policy = [Policy::Defer, Policy::Drop, Policy::Replace, Policy::Update][action.policy];
        let min_spacing = action.spacing.map(Interval::from_nanos);
        let timing = ActionTiming { min_delay: Interval::from_nanos(action.min_delay), min_spacing, policy };
        trigger(TriggerKind::Logical(timing), AT_ACTIONS + index)
    }));
    triggers.extend(
        (0..INPUTS).map(|index| trigger(TriggerKind::NetworkInput { fills: PortId(id(2 * PORTS + index)) }, 0)),
    );
    triggers.extend(plan.delays.iter().enumerate().map(|(index, &delay)| {
        trigger(TriggerKind::Delay { fills: PortId(id(PORTS + index)), delay: Interval::from_nanos(delay) }, 0)
    }));
    triggers.push(trigger(TriggerKind::Shutdown, SHUTDOWN));
    let port = |reactions: &[usize], delays| PortInfo {
        name: "port",
        reactions: leak(reactions.iter().map(|reaction| ReactionId(id(*reaction))).collect()),
        delays,
    };
    let mut ports: Vec<PortInfo> = (0..PORTS)
        .map(|index| port(&[AT_PORTS + index, AT_SENDS + index], leak(vec![TriggerId(id(AT_DELAYED + index))])))
        .collect();
    ports.extend((0..PORTS).map(|index| port(&[AT_DELAYED + index], &[])));
    ports.extend((0..INPUTS).map(|index| port(&[AT_INPUTS + index], &[])));
    let outputs = (0..PORTS).map(|index| NetworkOutput {
        name: "output",
        source: PortId(id(index)),
        federate: 0,
        port: id(index),
        delay: None,
        max_len: 4,
        tells_absence: true,
        physical: false,
    });
    let inputs = (0..INPUTS).map(|index| NetworkInput {
        name: "input",
        trigger: TriggerId(id(AT_INPUTS + index)),
        max_len: 4,
        level: id(AT_INPUTS + index),
        awaited: true,
        ..NetworkInput::DEFAULT
    });
    Tables {
        reactions: leak(reactions.collect()),
        triggers: leak(triggers),
        ports: leak(ports),
        outputs: leak(outputs.collect()),
        inputs: leak(inputs.collect()),
        absence: leak((AT_SENDS..AT_SENDS + PORTS).map(|reaction| ReactionId(id(reaction))).collect()),
        ..Tables::DEFAULT
    }
}

impl RandomProgram {
    pub(crate) fn new(plan: Plan) -> Self {
        let tables: &'static Tables = Box::leak(Box::new(tables(&plan)));
        tables.check();
        Self {
            plan,
            tables,
            timers: Default::default(),
            actions: std::array::from_fn(|index| LogicalActionQueue::new(TriggerId(id(AT_ACTIONS + index)))),
            inputs: std::array::from_fn(|index| QueuedPort::new(PortId(id(2 * PORTS + index)))),
            delayed: std::array::from_fn(|index| QueuedPort::new(PortId(id(PORTS + index)))),
            ports: std::array::from_fn(|index| Port::new(PortId(id(index)))),
            trace: Vec::new(),
        }
    }
}

impl RandomProgram {
    fn body(&mut self, reaction: usize, ctx: &mut ReactionContext<'_>) {
        let tag: TagPair = ((ctx.get_logical_time().as_nanos()) - START, ctx.get_tag().microstep);
        let value = match reaction {
            AT_TIMERS..AT_ACTIONS => ctx.is_present(&self.timers[reaction - AT_TIMERS]).then_some(1),
            AT_ACTIONS..AT_INPUTS => ctx.get(&self.actions[reaction - AT_ACTIONS]),
            AT_INPUTS..AT_DELAYED => ctx.get(&self.inputs[reaction - AT_INPUTS].port),
            AT_DELAYED..AT_PORTS => ctx.get(&self.delayed[reaction - AT_DELAYED].port),
            AT_PORTS..SHUTDOWN => ctx.get(&self.ports[reaction - AT_PORTS]),
            _ => None,
        };
        self.trace.push((tag, reaction, value));
        for effect in effects(self.plan.seed, tag, reaction) {
            match effect {
                Effect::Schedule { action, offset, value } => {
                    let offset = Offset::After(Interval::from_nanos(offset).to_duration());
                    ctx.schedule_with_v(&mut self.actions[action], value, offset);
                }
                Effect::Set { port, value } => ctx.set(&mut self.ports[port], value),
                Effect::Stop => ctx.request_stop(Offset::Asap),
            }
        }
        assert_eq!(ctx.get_start_time(), Instant::from_nanos(START));
    }
}

impl Program for RandomProgram {
    fn tables(&self) -> &'static Tables {
        self.tables
    }

    fn react(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        ctx.in_turn(reaction.0, id(SHUTDOWN), |ctx, id| self.body(usize::from(id.0), ctx));
    }

    fn clear_port(&mut self, port: PortId) {
        let index = usize::from(port.0);
        match index {
            0..PORTS => self.ports[index].clear(),
            _ if index < 2 * PORTS => self.delayed[index - PORTS].port.clear(),
            _ => self.inputs[index - 2 * PORTS].port.clear(),
        }
    }

    fn trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
        let index = usize::from(trigger.0);
        match index {
            AT_TIMERS..AT_ACTIONS => Some(&mut self.timers[index - AT_TIMERS]),
            AT_ACTIONS..AT_INPUTS => Some(&mut self.actions[index - AT_ACTIONS]),
            AT_INPUTS..AT_DELAYED => Some(&mut self.inputs[index - AT_INPUTS]),
            AT_DELAYED..AT_PORTS => Some(&mut self.delayed[index - AT_DELAYED]),
            _ => None,
        }
    }

    fn capture(&mut self, trigger: TriggerId, tag: Tag) -> Result<(), Full> {
        let index = usize::from(trigger.0) - AT_DELAYED;
        self.delayed[index].capture(tag, &self.ports[index])
    }

    fn encode(&self, output: OutputId, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        self.ports[usize::from(output.0)].encode(bytes)
    }

    fn deliver(&mut self, input: InputId, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
        self.inputs[usize::from(input.0)].deliver(tag, bytes)
    }
}
