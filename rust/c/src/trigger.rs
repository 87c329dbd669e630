// SPDX-License-Identifier: Apache-2.0
//! Actions, timers and watchdogs, whose events C sees while they happen.
use core::ops::{Deref, DerefMut};

use lf_model as model;
use lf_model::{
    ActionTiming, Bounds, Full, Inbox, LogicalActionQueue, ModeCell, PhysicalActionQueue, Readable, Schedulable,
    ScheduleContext, Tag, TriggerCell, TriggerId,
};

use crate::ffi;
use crate::token::Token;

/// The inbox for events of a physical action that other threads schedule; a static of the generated crate.
pub type PhysicalInbox<const N: usize> = model::PhysicalInbox<Token, N>;

/// Returns the id of a trigger that C sees.
fn shown(id: TriggerId) -> TriggerId {
    assert!(ffi::lf_c_shows_trigger(id.0), "C sees no trigger {}", id.0);
    id
}

/// Shows the event of a queue; the queue keeps the value until the event is over.
fn show(id: TriggerId, value: Option<&Token>) {
    // SAFETY: there is such a trigger, and the value lives until `clear`.
    unsafe { ffi::lf_c_trigger_show(id.0, Token::raw(value)) };
}

fn clear(id: TriggerId) {
    // SAFETY: there is such a trigger.
    unsafe { ffi::lf_c_trigger_clear(id.0) };
}

/// An action: its events are those of the model's queue, and C sees them.
macro_rules! action {
    ($(#[$attribute:meta])* $name:ident, $queue:ident) => {
        $(#[$attribute])*
        pub struct $name<const N: usize> {
            id: TriggerId,
            queue: $queue<Token, N>,
        }

        impl<const N: usize> Schedulable for $name<N> {
            type Value = Token;
            fn id(&self) -> TriggerId {
                self.id
            }
            fn schedule(&mut self, value: Option<Token>, context: &ScheduleContext<'_>) -> Result<(), Full> {
                self.queue.schedule(value, context)
            }
            fn pending(&self) -> Option<Tag> {
                Schedulable::pending(&self.queue)
            }
            fn capacity(&self) -> usize {
                N
            }
        }

        impl<const N: usize> TriggerCell for $name<N> {
            fn activate(&mut self, tag: Tag) -> Option<Tag> {
                let next = self.queue.activate(tag);
                show(self.id, self.queue.value());
                next
            }
            fn clear(&mut self) {
                clear(self.id);
                self.queue.clear();
            }
            fn pending(&self) -> Option<Tag> {
                TriggerCell::pending(&self.queue)
            }
            fn has_room(&self) -> bool {
                self.queue.has_room()
            }
            fn drain(&mut self, timing: &ActionTiming, bounds: &Bounds) {
                self.queue.drain(timing, bounds);
            }
            #[cfg(feature = "traces")]
            fn encode_event(&self, bytes: &mut [u8]) -> Option<Result<usize, model::PayloadError>> {
                self.queue.value().map(|token| token.encode(bytes))
            }
        }

        impl<const N: usize> ModeCell for $name<N> {
            fn shift(&mut self, from: Tag, to: Tag) -> Option<Tag> {
                self.queue.shift(from, to)
            }
            fn discard(&mut self) {
                self.queue.discard();
            }
            fn forget(&mut self) {
                self.queue.forget();
            }
        }
    };
}

action!(
    /// A logical action with room for `N` pending events.
    LogicalAction,
    LogicalActionQueue
);

action!(
    /// A physical action with room for `N` pending events.
    PhysicalAction,
    PhysicalActionQueue
);

impl<const N: usize> LogicalAction<N> {
    /// Returns an action without pending events.
    ///
    /// # Panics
    /// When C does not see this trigger.
    pub fn new(id: TriggerId) -> Self {
        Self { id: shown(id), queue: LogicalActionQueue::new(id) }
    }
}

impl<const N: usize> PhysicalAction<N> {
    /// Returns an action without pending events, and with the inbox that threads use.
    ///
    /// # Panics
    /// When C does not see this trigger.
    pub fn new(id: TriggerId, inbox: &'static dyn Inbox<Token>) -> Self {
        Self { id: shown(id), queue: PhysicalActionQueue::new(id, inbox) }
    }
}

/// A timer; offset and period are in the tables.
#[derive(Debug)]
pub struct Timer {
    id: TriggerId,
}

impl Timer {
    /// Returns the timer with this number.
    ///
    /// # Panics
    /// When C does not see this trigger.
    pub fn new(id: TriggerId) -> Self {
        Self { id: shown(id) }
    }
}

impl TriggerCell for Timer {
    fn activate(&mut self, _tag: Tag) -> Option<Tag> {
        show(self.id, None);
        None
    }
    fn clear(&mut self) {
        clear(self.id);
    }
}

/// A watchdog. It derefs to the model's.
#[derive(Debug)]
pub struct Watchdog {
    id: TriggerId,
    watchdog: model::Watchdog,
}

impl Watchdog {
    /// Returns a watchdog that does not run.
    ///
    /// # Panics
    /// When C does not see this trigger.
    pub fn new(id: TriggerId) -> Self {
        Self { id: shown(id), watchdog: model::Watchdog::new(id) }
    }
}

impl Deref for Watchdog {
    type Target = model::Watchdog;
    fn deref(&self) -> &model::Watchdog {
        &self.watchdog
    }
}

impl DerefMut for Watchdog {
    fn deref_mut(&mut self) -> &mut model::Watchdog {
        &mut self.watchdog
    }
}

impl TriggerCell for Watchdog {
    fn activate(&mut self, tag: Tag) -> Option<Tag> {
        show(self.id, None);
        self.watchdog.activate(tag)
    }
    fn clear(&mut self) {
        clear(self.id);
        self.watchdog.clear();
    }
    fn pending(&self) -> Option<Tag> {
        self.watchdog.pending()
    }
}

impl ModeCell for Watchdog {
    fn shift(&mut self, from: Tag, to: Tag) -> Option<Tag> {
        self.watchdog.shift(from, to)
    }
    fn discard(&mut self) {
        self.watchdog.discard();
    }
}
