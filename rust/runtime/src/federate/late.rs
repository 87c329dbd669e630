// SPDX-License-Identifier: Apache-2.0
//! Messages that have come too late, with decentralized coordination: told and counted.

use core::time::Duration;

use crate::log_event::{PeerEvent, report};
use lf_coordination::{Tally, Times};
use lf_model::time::{EventTag, Tag};
use lf_model::{Delivery, Engine, InputId, NetworkInput, ReactionKind, Tables};
use log::Level;

/// Messages that have come too late.
#[derive(Debug, Default)]
pub(super) struct Late {
    messages: u64,
    /// Those of them that not all reactions handle.
    unhandled: u64,
    /// The same, to tell them now and then.
    told: Tally,
}

impl Late {
    /// How many there have been.
    pub(super) fn messages(&self) -> u64 {
        self.messages
    }

    /// Says what has come too late, by so much, to which `federate` and which of its inputs, and counts it.
    pub(super) fn report(
        &mut self,
        engine: &Engine<'_>,
        federate: u16,
        input: InputId,
        (tag, lateness): (Tag, Duration),
        delivery: Delivery,
    ) {
        let Some(info) = engine.tables().inputs.get(usize::from(input.0)) else { return };
        let start = engine.start_time();
        let (name, intended) = (info.name, EventTag::relative(tag, start));
        match delivery {
            Delivery::InTime(_) => return,
            Delivery::AfterStop => {
                report(Level::Info, &PeerEvent::AfterStop { input: name, intended });
                return;
            }
            Delivery::Tardy(actual) if is_handled(engine.tables(), info) => {
                let actual = EventTag::relative(actual, start);
                log::debug!("late message over {name} for {intended}: it happens at {actual}, {lateness:?} late");
            }
            Delivery::Tardy(actual) => {
                let (level, times) = self.count_unhandled();
                let actual = EventTag::relative(actual, start);
                report(
                    level,
                    &PeerEvent::Late { input: name, intended, actual: Some(actual), lateness, federate, times },
                );
            }
            Delivery::Lost => {
                let (level, times) = self.count_unhandled();
                report(level, &PeerEvent::Late { input: name, intended, actual: None, lateness, federate, times });
            }
        }
        self.messages = self.messages.saturating_add(1);
    }

    /// One more that not all reactions handle: how loudly it is said, with how many there have been.
    fn count_unhandled(&mut self) -> (log::Level, Times) {
        self.unhandled = self.unhandled.saturating_add(1);
        let times = self.told.count();
        (if times.is_logged() { log::Level::Warn } else { log::Level::Debug }, times)
    }

    /// Says at the end how many there have been.
    pub(super) fn sum_up(&self) {
        let Self { messages, unhandled, .. } = *self;
        if messages > 0 {
            report(Level::Warn, &PeerEvent::LateInAll { messages, unhandled });
        }
    }
}

/// Whether every reaction that a value of this input triggers has a handler for tardy ones.
fn is_handled(tables: &Tables, info: &NetworkInput) -> bool {
    let port = tables.triggers.get(usize::from(info.trigger.0)).and_then(|trigger| trigger.kind.fills());
    let reactions = port.and_then(|port| tables.ports.get(usize::from(port.0))).map_or(&[][..], |port| port.reactions);
    let handles = |reaction: &lf_model::ReactionInfo| reaction.kind == ReactionKind::Body && reaction.tardy;
    !reactions.is_empty() && reactions.iter().all(|id| tables.reactions.get(usize::from(id.0)).is_some_and(handles))
}
