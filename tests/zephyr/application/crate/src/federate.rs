// SPDX-License-Identifier: Apache-2.0
//! The program, its tables and its memory.

use lf::model::{
    ActionTiming, Interval, PhysicalActionQueue, PhysicalInbox, Program, ReactionId, ReactionInfo, Tables, TriggerCell,
    TriggerId, TriggerInfo, TriggerKind,
};
use lf::prelude::*;

/// How often the thread presses the button.
const PRESSES: u32 = 2;

static BUTTON: PhysicalInbox<u32, 4> = PhysicalInbox::new();

/// The program's only reactor, which counts.
pub struct Main {
    ticks: u32,
    presses: u32,
    timer: Timer,
    button: PhysicalActionQueue<u32, 4>,
}

impl Main {
    /// Everything as it is before the start.
    pub fn new() -> Self {
        Self { ticks: 0, presses: 0, timer: Timer::new(), button: PhysicalActionQueue::new(TriggerId(3), &BUTTON) }
    }

    fn reaction_startup(ctx: &mut ReactionContext<'_>, button: &PhysicalAction<u32>) {
        let button = (*button).clone();
        ctx.spawn_physical_thread(move |link| {
            for press in 1..=PRESSES {
                if link.schedule_physical_with_v(&button, Some(press), Asap).is_err() {
                    error!("the button is stuck");
                }
            }
        });
    }

    fn reaction_timer(&mut self, ctx: &mut ReactionContext<'_>) {
        self.ticks += 1;
        println!("tick {} at {} ms", self.ticks, ctx.get_elapsed_logical_time().as_millis());
        if self.ticks == 2 {
            warn!("half of the ticks");
        }
    }

    fn reaction_shutdown(&mut self) {
        println!("shutdown after {} ticks and {} presses", self.ticks, self.presses);
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
    ],
    triggers: &[
        TriggerInfo { name: "startup", kind: TriggerKind::Startup, reactions: &[ReactionId(0)] },
        TriggerInfo { name: "shutdown", kind: TriggerKind::Shutdown, reactions: &[ReactionId(3)] },
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
    ],
    ..Tables::DEFAULT
};
const _: () = TABLES.check();

/// The engine's memory.
pub type Storage = lf::model::storage_for!(TABLES);

/// What the event loop knows of this program.
pub static DESCRIPTION: lf::runtime::Description = lf::runtime::Description {
    program: "Application",
    name: "Application",
    timeout: Some(Interval::from_millis(35)),
    keepalive: false,
    fast: false,
    logging: lf::log::LevelFilter::Info,
    federation: None,
};

impl Program for Main {
    fn tables(&self) -> &'static Tables {
        &TABLES
    }

    fn react(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        match reaction.0 {
            0 => Self::reaction_startup(ctx, &self.button),
            1 => self.reaction_timer(ctx),
            2 => self.presses += 1,
            3 => self.reaction_shutdown(),
            _ => {}
        }
    }

    fn trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
        match trigger.0 {
            2 => Some(&mut self.timer),
            3 => Some(&mut self.button),
            _ => None,
        }
    }
}
