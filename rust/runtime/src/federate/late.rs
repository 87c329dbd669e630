// SPDX-License-Identifier: Apache-2.0
//! Messages that have come too late, with decentralized coordination: logged and counted.

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
    /// The number of those that not all reactions handle.
    unhandled: u64,
    /// The same number, to log them now and then.
    told: Tally,
}

impl Late {
    /// Returns their number.
    pub(super) fn messages(&self) -> u64 {
        self.messages
    }

    /// Logs a message that has come too late, by this time, for `federate` and one of its inputs, and counts it.
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

    /// Counts one more that not all reactions handle. Returns the level at which to log it, with their number.
    fn count_unhandled(&mut self) -> (log::Level, Times) {
        self.unhandled = self.unhandled.saturating_add(1);
        let times = self.told.count();
        (if times.is_logged() { log::Level::Warn } else { log::Level::Debug }, times)
    }

    /// Logs their number at the end.
    pub(super) fn sum_up(&self) {
        let Self { messages, unhandled, .. } = *self;
        if messages > 0 {
            report(Level::Warn, &PeerEvent::LateInAll { messages, unhandled });
        }
    }
}

/// Returns whether every reaction that a value of this input triggers has a handler for tardy ones.
fn is_handled(tables: &Tables, info: &NetworkInput) -> bool {
    let port = tables.triggers.get(usize::from(info.trigger.0)).and_then(|trigger| trigger.kind.fills());
    let reactions = port.and_then(|port| tables.ports.get(usize::from(port.0))).map_or(&[][..], |port| port.reactions);
    let handles = |reaction: &lf_model::ReactionInfo| reaction.kind == ReactionKind::Body && reaction.tardy;
    !reactions.is_empty() && reactions.iter().all(|id| tables.reactions.get(usize::from(id.0)).is_some_and(handles))
}
