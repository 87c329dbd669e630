// SPDX-License-Identifier: Apache-2.0
//! A program that is not federated: a timer until the time-out.

use lf_model::{
    Interval, Program, ReactionId, ReactionInfo, Tables, Timer, TriggerCell, TriggerId, TriggerInfo, TriggerKind,
};
use lf_runtime::Description;

pub(crate) const TABLES: Tables = Tables {
    reactions: &[ReactionInfo { name: "alone.reaction_1", ..ReactionInfo::DEFAULT }],
    triggers: &[TriggerInfo {
        name: "alone.t",
        kind: TriggerKind::Timer { offset: Interval::ZERO, period: Interval::from_millis(10) },
        reactions: &[ReactionId(0)],
    }],
    ..Tables::DEFAULT
};
const _: () = TABLES.check();

pub(crate) type Storage = lf_model::storage_for!(TABLES);

pub(crate) static DESCRIPTION: Description =
    Description { program: "Alone", name: "alone", timeout: Some(Interval::from_millis(30)), ..Description::DEFAULT };

pub(crate) struct Alone {
    t: Timer,
}

impl Alone {
    pub(crate) fn new() -> Self {
        Self { t: Timer::new() }
    }
}

impl Program for Alone {
    fn tables(&self) -> &'static Tables {
        &TABLES
    }

    fn trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
        (trigger == TriggerId(0)).then_some(&mut self.t)
    }
}
