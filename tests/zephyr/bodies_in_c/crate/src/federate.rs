// SPDX-License-Identifier: Apache-2.0
//! The program, its tables and its memory.

use lf::c;
use lf::model::{
    ActionTiming, Inbox, Interval, Program, ReactionContext, ReactionId, ReactionInfo, Schedulable, Tables,
    TriggerCell, TriggerId, TriggerInfo, TriggerKind,
};

include!(concat!(env!("OUT_DIR"), "/sizes.rs"));
const _: () = assert!(LF_SIZE_0 == 16, "the compiler of the board says so");

static BUTTON: c::PhysicalInbox<4> = c::PhysicalInbox::new();

/// The program.
pub struct Main {
    timer: c::Timer,
    button: c::PhysicalAction<4>,
    points: c::LogicalAction<2>,
}

impl Main {
    /// Everything as it is before the start.
    pub fn new() -> Self {
        c::construct();
        Self {
            timer: c::Timer::new(TriggerId(2)),
            button: c::PhysicalAction::new(TriggerId(3), &BUTTON),
            points: c::LogicalAction::new(TriggerId(4)),
        }
    }
}

impl c::Bodies for Main {
    fn action(&mut self, action: TriggerId) -> Option<&mut dyn Schedulable<Value = c::Token>> {
        match action.0 {
            3 => Some(&mut self.button),
            4 => Some(&mut self.points),
            _ => None,
        }
    }

    fn inbox(action: TriggerId) -> Option<&'static dyn Inbox<c::Token>> {
        match action.0 {
            3 => Some(&BUTTON),
            _ => None,
        }
    }
}

impl Program for Main {
    fn tables(&self) -> &'static Tables {
        &TABLES
    }

    fn react(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        c::react(self, reaction, ctx);
    }

    fn trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
        match trigger.0 {
            2 => Some(&mut self.timer),
            3 => Some(&mut self.button),
            4 => Some(&mut self.points),
            _ => None,
        }
    }
}

const fn reaction(name: &'static str) -> ReactionInfo {
    ReactionInfo { name, ..ReactionInfo::DEFAULT }
}

/// What never changes.
pub const TABLES: Tables = Tables {
    reactions: &[
        reaction("main.reaction_1"),
        reaction("main.reaction_2"),
        reaction("main.reaction_3"),
        reaction("main.reaction_4"),
        reaction("main.reaction_5"),
    ],
    triggers: &[
        TriggerInfo { name: "startup", kind: TriggerKind::Startup, reactions: &[ReactionId(0)] },
        TriggerInfo { name: "shutdown", kind: TriggerKind::Shutdown, reactions: &[ReactionId(4)] },
        TriggerInfo {
            name: "main.timer",
            kind: TriggerKind::Timer { offset: Interval::from_millis(10), period: Interval::from_millis(10) },
            reactions: &[ReactionId(1)],
        },
        TriggerInfo {
            name: "main.button",
            kind: TriggerKind::Physical(ActionTiming::NONE),
            reactions: &[ReactionId(2)],
        },
        TriggerInfo {
            name: "main.points",
            kind: TriggerKind::Logical(ActionTiming::NONE),
            reactions: &[ReactionId(3)],
        },
    ],
    ..Tables::DEFAULT
};
const _: () = TABLES.check();

/// The engine's memory.
pub type Storage = lf::model::storage_for!(TABLES);

/// What the event loop knows of this program.
pub static DESCRIPTION: lf::runtime::Description = lf::runtime::Description {
    program: "BodiesInC",
    name: "BodiesInC",
    timeout: Some(Interval::from_millis(35)),
    keepalive: false,
    fast: false,
    logging: lf::log::LevelFilter::Info,
    federation: None,
};
