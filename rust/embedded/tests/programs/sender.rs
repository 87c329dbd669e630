// SPDX-License-Identifier: Apache-2.0
//! Sends how often its timer has fired, five times.

use lf_model::{
    Interval, NetworkOutput, OutputId, PayloadError, Port, PortCell, PortId, PortInfo, Program, ReactionContext,
    ReactionId, ReactionInfo, ReactionKind, Tables, Timer, TriggerCell, TriggerId, TriggerInfo, TriggerKind,
};
use lf_runtime::{ClockSync, Description, Federation};

pub(crate) const TABLES: Tables = Tables {
    reactions: &[
        ReactionInfo { name: "sender.reaction_1", ..ReactionInfo::DEFAULT },
        ReactionInfo {
            name: "sender.y -> receiver.x",
            level: 1,
            kind: ReactionKind::Send(OutputId(0)),
            ..ReactionInfo::DEFAULT
        },
    ],
    triggers: &[TriggerInfo {
        name: "sender.t",
        kind: TriggerKind::Timer { offset: Interval::ZERO, period: Interval::from_millis(10) },
        reactions: &[ReactionId(0)],
    }],
    ports: &[PortInfo { name: "sender.y", reactions: &[ReactionId(1)], delays: &[] }],
    outputs: &[NetworkOutput {
        name: "sender.y -> receiver.x",
        federate: 1,
        max_len: super::VALUE_BYTES,
        ..NetworkOutput::DEFAULT
    }],
    ..Tables::DEFAULT
};
const _: () = TABLES.check();

pub(crate) type Storage = lf_model::storage_for!(TABLES);

const FEDERATION: Federation = Federation {
    id: 0,
    federation_id: "images",
    federates: 2,
    downstream: &[1],
    clock_sync: ClockSync::On { trials: 3, attenuation: 10 },
    ..Federation::DEFAULT
};

pub(crate) static DESCRIPTION: Description = Description {
    program: "Images",
    name: "sender",
    timeout: Some(Interval::from_millis(40)),
    federation: Some(FEDERATION.with_buffers(&TABLES)),
    ..Description::DEFAULT
};

pub(crate) struct Sender {
    count: u32,
    t: Timer,
    y: Port<u32>,
}

impl Sender {
    pub(crate) fn new() -> Self {
        Self { count: 0, t: Timer::new(), y: Port::new(PortId(0)) }
    }
}

impl Program for Sender {
    fn tables(&self) -> &'static Tables {
        &TABLES
    }

    fn react(&mut self, _reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        self.count += 1;
        ctx.set(&mut self.y, self.count);
    }

    fn port(&mut self, port: PortId) -> Option<&mut dyn PortCell> {
        (port == PortId(0)).then_some(&mut self.y)
    }

    fn trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
        (trigger == TriggerId(0)).then_some(&mut self.t)
    }

    fn encode(&self, _output: OutputId, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        self.y.encode(bytes)
    }
}
