// SPDX-License-Identifier: Apache-2.0
//! Notes what comes.

use std::sync::Mutex;

use lf_model::{
    InputId, Interval, NetworkInput, PortCell, PortId, PortInfo, Program, QueuedPort, ReactionContext, ReactionId,
    ReactionInfo, Tables, Tag, TriggerCell, TriggerId, TriggerInfo, TriggerKind, Undelivered,
};
use lf_runtime::{ClockSync, DELAY_NONE, Description, Federation};

/// The received values.
pub(crate) static RECEIVED: Mutex<Vec<u32>> = Mutex::new(Vec::new());

pub(crate) const TABLES: Tables = Tables {
    reactions: &[ReactionInfo { name: "receiver.reaction_1", ..ReactionInfo::DEFAULT }],
    triggers: &[TriggerInfo {
        name: "receiver.x",
        kind: TriggerKind::NetworkInput { fills: PortId(0) },
        reactions: &[],
    }],
    ports: &[PortInfo { name: "receiver.x", reactions: &[ReactionId(0)], delays: &[] }],
    inputs: &[NetworkInput {
        name: "sender.y -> receiver.x",
        max_len: super::VALUE_BYTES,
        level: 0,
        ..NetworkInput::DEFAULT
    }],
    ..Tables::DEFAULT
};
const _: () = TABLES.check();

pub(crate) type Storage = lf_model::storage_for!(TABLES);

const FEDERATION: Federation = Federation {
    id: 1,
    federation_id: "images",
    federates: 2,
    upstream: &[(0, DELAY_NONE)],
    clock_sync: ClockSync::On { trials: 3, attenuation: 10 },
    ..Federation::DEFAULT
};

pub(crate) static DESCRIPTION: Description = Description {
    program: "Images",
    name: "receiver",
    timeout: Some(Interval::from_millis(40)),
    federation: Some(FEDERATION.with_buffers(&TABLES)),
    ..Description::DEFAULT
};

pub(crate) struct Receiver {
    x: QueuedPort<u32, 2>,
}

impl Receiver {
    pub(crate) fn new() -> Self {
        Self { x: QueuedPort::new(PortId(0)) }
    }
}

impl Program for Receiver {
    fn tables(&self) -> &'static Tables {
        &TABLES
    }

    fn react(&mut self, _reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        RECEIVED.lock().unwrap().extend(ctx.get(&self.x.port));
    }

    fn port(&mut self, port: PortId) -> Option<&mut dyn PortCell> {
        (port == PortId(0)).then_some(&mut self.x.port)
    }

    fn trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
        (trigger == TriggerId(0)).then_some(&mut self.x)
    }

    fn deliver(&mut self, _input: InputId, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
        self.x.deliver(tag, bytes)
    }
}
