// SPDX-License-Identifier: Apache-2.0
//! The queues of a program: the model's own, each with the exact capacity from the plan.
//!
//! Generated code has one type per capacity. The simulator learns the capacity only at run time, so it chooses the
//! smallest sufficient of a few types, and does not fill the queues of connections beyond their capacity.

use std::collections::VecDeque;

use lf_model::time::Tag;
use lf_model::{
    Full, Inbox, LogicalAction, LogicalActionQueue, ModeCell, PhysicalAction, PhysicalActionQueue, PhysicalInbox,
    Placed, Port, PortId, QueuedPort, Readable, TardyInput, Timer, TriggerCell, TriggerId, Undelivered, Watchdog,
};

use super::value::Value;
use lf_testkit::world::Side;

/// The maximum capacity of a queue.
pub(crate) const CAPACITY_MAX: usize = 16384;
/// The number of events of a physical action that can wait for the event loop.
const INBOX: usize = 64;

/// The memory of one trigger.
pub(crate) enum Cell {
    /// The absence of memory, for startup and shutdown.
    None,
    Timer(Timer),
    Watchdog(Watchdog),
    Logical(Box<dyn AnyLogical>),
    Physical(Box<dyn AnyPhysical>),
    /// A physical action whose events are known in advance.
    Replayed(Replayed),
    Queued(Queued),
}

/// A logical action of any capacity.
pub(crate) trait AnyLogical: TriggerCell + ModeCell + Send + Sync {
    fn action(&self) -> &LogicalAction<Value>;
    fn action_mut(&mut self) -> &mut LogicalAction<Value>;
}

impl<const N: usize> AnyLogical for LogicalActionQueue<Value, N> {
    fn action(&self) -> &LogicalAction<Value> {
        self
    }
    fn action_mut(&mut self) -> &mut LogicalAction<Value> {
        self
    }
}

/// A physical action of any capacity.
pub(crate) trait AnyPhysical: TriggerCell + Send + Sync {
    fn action(&self) -> &PhysicalAction<Value>;
    fn action_mut(&mut self) -> &mut PhysicalAction<Value>;
}

impl<const N: usize> AnyPhysical for PhysicalActionQueue<Value, N> {
    fn action(&self) -> &PhysicalAction<Value> {
        self
    }
    fn action_mut(&mut self) -> &mut PhysicalAction<Value> {
        self
    }
}

/// A port with its queue, of any capacity.
pub(crate) trait AnyQueue: TriggerCell + Send + Sync {
    fn as_mode(&mut self) -> Option<&mut dyn ModeCell>;
    fn port(&self) -> &Port<Value>;
    fn port_mut(&mut self) -> &mut Port<Value>;
    fn deliver(&mut self, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered>;
    fn capture(&mut self, tag: Tag, source: &Port<Value>) -> Result<(), Full>;
    fn deliver_tardy(&mut self, tag: Tag, intended: Tag, bytes: &[u8]) -> Result<Placed, Undelivered>;
}

impl<const N: usize> AnyQueue for QueuedPort<Value, N> {
    fn as_mode(&mut self) -> Option<&mut dyn ModeCell> {
        Some(self)
    }
    fn port(&self) -> &Port<Value> {
        &self.port
    }
    fn port_mut(&mut self) -> &mut Port<Value> {
        &mut self.port
    }
    fn deliver(&mut self, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
        QueuedPort::deliver(self, tag, bytes)
    }
    fn capture(&mut self, tag: Tag, source: &Port<Value>) -> Result<(), Full> {
        QueuedPort::capture(self, tag, source)
    }
    fn deliver_tardy(&mut self, _tag: Tag, _intended: Tag, _bytes: &[u8]) -> Result<Placed, Undelivered> {
        Err(Undelivered::NoSuchPort)
    }
}

impl<const N: usize> AnyQueue for TardyInput<Value, N> {
    /// Inputs from other federates are in no mode.
    fn as_mode(&mut self) -> Option<&mut dyn ModeCell> {
        None
    }
    fn port(&self) -> &Port<Value> {
        &self.port
    }
    fn port_mut(&mut self) -> &mut Port<Value> {
        &mut self.port
    }
    fn deliver(&mut self, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
        TardyInput::deliver(self, tag, bytes)
    }
    /// Messages come only from another federate.
    fn capture(&mut self, _tag: Tag, _source: &Port<Value>) -> Result<(), Full> {
        Err(Full { capacity: 0 })
    }
    fn deliver_tardy(&mut self, tag: Tag, intended: Tag, bytes: &[u8]) -> Result<Placed, Undelivered> {
        TardyInput::deliver_tardy(self, tag, intended, bytes)
    }
}

/// Chooses the smallest type that has at least this capacity; `None` if no type is large enough.
macro_rules! by_capacity {
    ($capacity:expr, $n:ident => $make:expr) => {
        by_capacity!(@ $capacity, $n => $make; 1 4 16 64 1024 4096 16384)
    };
    (@ $capacity:expr, $n:ident => $make:expr; $($number:literal)*) => {
        match $capacity {
            $(0..=$number => {
                const $n: usize = $number;
                // A separate function, so that the caller's stack has no room for all of them.
                let make = || $make;
                Some(make())
            })*
            _ => None,
        }
    };
}

pub(crate) fn logical(id: TriggerId, capacity: usize) -> Option<Cell> {
    let action: Option<Box<dyn AnyLogical>> =
        by_capacity!(capacity, N => Box::new(LogicalActionQueue::<Value, N>::new(id)));
    action.map(Cell::Logical)
}

pub(crate) fn physical(id: TriggerId, capacity: usize) -> Option<Cell> {
    let inbox: &'static dyn Inbox<Value> = Box::leak(Box::new(PhysicalInbox::<Value, INBOX>::new()));
    let action: Option<Box<dyn AnyPhysical>> = by_capacity!(capacity, N => {
        Box::new(PhysicalActionQueue::<Value, N>::new(id, inbox).encoded_by(lf_model::encoder!(Value)))
    });
    action.map(Cell::Physical)
}

pub(crate) fn queued(port: PortId, capacity: usize) -> Option<Cell> {
    let queue: Option<Box<dyn AnyQueue>> = by_capacity!(capacity, N => Box::new(QueuedPort::<Value, N>::new(port)));
    queue.map(|queue| Cell::Queued(Queued { queue, capacity, pending: 0, most: 0, kept: None }))
}

/// Returns an input whose messages can be tardy.
pub(crate) fn tardy(port: PortId, capacity: usize, side: &'static Side) -> Option<Cell> {
    let queue: Option<Box<dyn AnyQueue>> = by_capacity!(capacity, N => Box::new(TardyInput::<Value, N>::new(port)));
    let kept = Some(InputLog { side, handled: Vec::new() });
    queue.map(|queue| Cell::Queued(Queued { queue, capacity, pending: 0, most: 0, kept }))
}

impl Cell {
    /// Returns the presence of an action or a timer, with the value if it has one.
    #[expect(clippy::option_option, reason = "what is present has a value or none")]
    pub(crate) fn read(&self) -> Option<Option<Value>> {
        match self {
            Self::Timer(timer) => timer.is_present().then_some(None),
            Self::Watchdog(watchdog) => watchdog.is_present().then_some(None),
            Self::Logical(logical) => logical.action().is_present().then(|| logical.action().value().copied()),
            Self::Physical(physical) => physical.action().is_present().then(|| physical.action().value().copied()),
            Self::Replayed(replayed) => replayed.present,
            Self::None | Self::Queued(_) => None,
        }
    }

    pub(crate) fn as_trigger(&mut self) -> Option<&mut dyn TriggerCell> {
        match self {
            Self::None => None,
            Self::Timer(timer) => Some(timer),
            Self::Watchdog(watchdog) => Some(watchdog),
            Self::Logical(action) => Some(&mut **action),
            Self::Physical(action) => Some(&mut **action),
            Self::Replayed(replayed) => Some(replayed),
            Self::Queued(queued) => Some(queued),
        }
    }
}

impl Cell {
    /// Returns the same cell, which keeps a log if it is a queue.
    pub(crate) fn logged(mut self, side: &'static Side) -> Self {
        if let Self::Queued(queued) = &mut self {
            queued.kept.get_or_insert(InputLog { side, handled: Vec::new() });
        }
        self
    }

    /// Returns the queue of a trigger in a mode; physical actions are in no mode in the simulator.
    pub(crate) fn as_mode(&mut self) -> Option<&mut dyn ModeCell> {
        match self {
            Self::Watchdog(watchdog) => Some(watchdog),
            Self::Logical(action) => Some(&mut **action),
            Self::Queued(queued) => Some(queued),
            Self::None | Self::Timer(_) | Self::Physical(_) | Self::Replayed(_) => None,
        }
    }
}

impl ModeCell for Queued {
    fn shift(&mut self, from: Tag, to: Tag) -> Option<Tag> {
        self.queue.as_mode().and_then(|queue| queue.shift(from, to))
    }
    fn discard(&mut self) {
        self.pending = 0;
        if let Some(queue) = self.queue.as_mode() {
            queue.discard();
        }
    }
}

/// A queue that counts its messages.
pub(crate) struct Queued {
    pub(crate) queue: Box<dyn AnyQueue>,
    pub(crate) capacity: usize,
    pending: usize,
    /// The maximum number of messages that it held.
    pub(crate) most: usize,
    /// The log of a network input, where a check needs it.
    pub(crate) kept: Option<InputLog>,
}

/// The log of a network input.
pub(crate) struct InputLog {
    side: &'static Side,
    /// The handled messages.
    pub(crate) handled: Vec<Handled>,
}

/// A handled message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Handled {
    pub(crate) tag: Tag,
    pub(crate) value: Value,
    /// The intended tag according to the queue, if the message was tardy.
    pub(crate) intended: Option<Tag>,
    /// The virtual time at which the queue released it.
    pub(crate) at: u64,
}

impl Queued {
    pub(crate) fn deliver(&mut self, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
        if self.pending == self.capacity {
            return Err(Undelivered::Full(Full { capacity: self.capacity }));
        }
        self.queue.deliver(tag, bytes)?;
        self.count();
        Ok(())
    }

    pub(crate) fn deliver_tardy(&mut self, tag: Tag, intended: Tag, bytes: &[u8]) -> Result<Placed, Undelivered> {
        if self.pending == self.capacity {
            return Err(Undelivered::Full(Full { capacity: self.capacity }));
        }
        let placed = self.queue.deliver_tardy(tag, intended, bytes)?;
        self.count();
        Ok(placed)
    }

    pub(crate) fn capture(&mut self, tag: Tag, source: &Port<Value>) -> Result<(), Full> {
        if self.pending == self.capacity {
            return Err(Full { capacity: self.capacity });
        }
        self.queue.capture(tag, source)?;
        self.count();
        Ok(())
    }

    /// Returns whether the present message was tardy.
    pub(crate) fn is_tardy(&self) -> bool {
        self.queue.port().is_present() && self.queue.intended().is_some()
    }

    fn count(&mut self) {
        self.pending += 1;
        self.most = self.most.max(self.pending);
    }
}

impl TriggerCell for Queued {
    fn activate(&mut self, tag: Tag) -> Option<Tag> {
        let next = self.queue.activate(tag);
        if self.queue.port().is_present() {
            self.pending = self.pending.saturating_sub(1);
        }
        let intended = self.queue.intended();
        if let (Some(kept), Some(value)) = (&mut self.kept, self.queue.port().value()) {
            kept.handled.push(Handled { tag, value: *value, intended, at: kept.side.now() });
        }
        next
    }
    fn clear(&mut self) {
        self.queue.clear();
    }
    fn pending(&self) -> Option<Tag> {
        self.queue.pending()
    }
    fn has_room(&self) -> bool {
        self.pending < self.capacity
    }
    fn intended(&self) -> Option<Tag> {
        self.queue.intended()
    }
}

/// A physical action that replays events at their earlier times.
pub(crate) struct Replayed {
    pub(crate) events: VecDeque<(Tag, Option<Value>)>,
    #[expect(clippy::option_option, reason = "an event has a value or none")]
    pub(crate) present: Option<Option<Value>>,
}

impl TriggerCell for Replayed {
    fn activate(&mut self, tag: Tag) -> Option<Tag> {
        let is_due = self.events.front().is_some_and(|(at, _)| *at == tag);
        self.present = if is_due { self.events.pop_front().map(|(_, value)| value) } else { None };
        TriggerCell::pending(self)
    }
    fn clear(&mut self) {
        self.present = None;
    }
    fn pending(&self) -> Option<Tag> {
        self.events.front().map(|(tag, _)| *tag)
    }
}
