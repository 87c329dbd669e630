// SPDX-License-Identifier: Apache-2.0
//! Timers and logical actions, and the rules by which an action's event gets its tag.
use core::fmt;

use heapless::vec::VecStorage;

use crate::cell::{
    Bounds, Readable, Schedulable, ScheduleContext, TriggerCell, cell_by_view, mode_by_view, schedule_by_view,
};
use crate::modes::ModeCell;
use crate::queue::{Event, Full, Owned, Queue, View};
use crate::tables::{ActionTiming, Policy, TriggerId};
use crate::time::{Instant, Tag};

/// A timer, as bodies see it: `ctx.is_present(t)`. Generated code makes one per trigger of this kind.
#[derive(Debug, Default)]
pub struct Timer {
    present: bool,
}

impl Timer {
    /// Returns a timer; offset and period are in the tables.
    pub const fn new() -> Self {
        Self { present: false }
    }
}

impl Readable for Timer {
    type Value = ();
    fn is_present(&self) -> bool {
        self.present
    }
    fn value(&self) -> Option<&()> {
        self.present.then_some(&())
    }
}

impl TriggerCell for Timer {
    fn activate(&mut self, _tag: Tag) -> Option<Tag> {
        self.present = true;
        None
    }
    fn clear(&mut self) {
        self.present = false;
    }
}

/// A logical action with room for `N` pending events. Generated code makes one per trigger of this kind, with the
/// capacity from the plan, and passes it to reactions as `&LogicalAction<T>`, or as effect `&mut LogicalAction<T>`.
pub type LogicalActionQueue<T, const N: usize> = LogicalAction<T, Owned<Option<T>, N>>;

/// A logical action, as bodies see it.
pub struct LogicalAction<T, S: VecStorage<Event<Option<T>>> + ?Sized = View<Option<T>>> {
    id: TriggerId,
    present: bool,
    value: Option<T>,
    /// The tag of the event that was scheduled last, and of the one before it. An event after the stop never happens
    /// but counts here: the spacing must not depend on when the stop becomes known.
    last: Option<Tag>,
    before: Option<Tag>,
    /// The tag of the event that happened last.
    happened: Option<Tag>,
    queue: Queue<Option<T>, S>,
}

impl<T, const N: usize> LogicalActionQueue<T, N> {
    /// Returns an action without pending events.
    pub const fn new(id: TriggerId) -> Self {
        Self { id, present: false, value: None, last: None, before: None, happened: None, queue: Queue::new() }
    }
}

impl<T> LogicalAction<T> {
    /// Schedules an event at `intended`, or at the tag that spacing and other events require.
    pub(crate) fn insert(
        &mut self,
        intended: Tag,
        value: Option<T>,
        timing: &ActionTiming,
        bounds: &Bounds,
    ) -> Result<(), Full> {
        let intended = intended.max(bounds.current.next_microstep());
        let tag = match self.place(intended, timing) {
            Placement::At(tag) => tag,
            Placement::Nowhere => return Ok(()),
            Placement::Into(tag) => {
                if let Some(pending) = self.queue.value_at(tag) {
                    *pending = value;
                }
                return Ok(());
            }
        };
        if tag.is_finite() {
            let tag = if tag <= bounds.stop { self.queue.insert(tag, value)? } else { tag };
            self.before = self.last.replace(tag);
        }
        Ok(())
    }

    /// Applies the rules of minimum spacing. Removes an event that [`Policy::Update`] replaces.
    fn place(&mut self, intended: Tag, timing: &ActionTiming) -> Placement {
        let Some(spacing) = timing.min_spacing else {
            return match timing.policy {
                Policy::Replace if self.queue.contains(intended) => Placement::Into(intended),
                Policy::Drop if self.queue.contains(intended) => Placement::Nowhere,
                _ => Placement::At(intended),
            };
        };
        let Some(last) = self.last else {
            return Placement::At(intended);
        };
        // With a spacing of zero, two events at one instant are still one too many, but microsteps separate them.
        let earliest_after =
            |tag: Tag| if spacing.as_nanos() == 0 { tag.next_microstep() } else { Tag::at(tag.time + spacing) };
        let early = |tag: Tag| {
            let earliest = tag.time + spacing;
            earliest > intended.time || (spacing.as_nanos() == 0 && earliest == intended.time)
        };
        if !early(last) {
            return Placement::At(intended);
        }
        match timing.policy {
            Policy::Drop => Placement::Nowhere,
            Policy::Replace if self.queue.contains(last) => Placement::Into(last),
            Policy::Defer | Policy::Replace => Placement::At(intended.max(earliest_after(last))),
            Policy::Update => {
                if self.happened < Some(last) {
                    self.queue.remove(last);
                    self.last = self.before;
                }
                match self.last {
                    Some(before) if early(before) => Placement::At(intended.max(earliest_after(before))),
                    _ => Placement::At(intended),
                }
            }
        }
    }
}

/// The tag of an event, if it happens.
enum Placement {
    At(Tag),
    Into(Tag),
    Nowhere,
}

impl<T: fmt::Debug, S: VecStorage<Event<Option<T>>> + ?Sized> fmt::Debug for LogicalAction<T, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LogicalAction")
            .field("present", &self.present)
            .field("value", &self.value)
            .finish_non_exhaustive()
    }
}

impl<T, S: VecStorage<Event<Option<T>>> + ?Sized> Readable for LogicalAction<T, S> {
    type Value = T;
    fn is_present(&self) -> bool {
        self.present
    }
    fn value(&self) -> Option<&T> {
        self.value.as_ref()
    }
}

impl<T> Schedulable for LogicalAction<T> {
    type Value = T;
    fn id(&self) -> TriggerId {
        self.id
    }
    fn schedule(&mut self, value: Option<T>, context: &ScheduleContext<'_>) -> Result<(), Full> {
        let delay = context.timing.min_delay.saturating_add(context.offset);
        self.insert(context.bounds.current.after(delay), value, context.timing, &context.bounds)
    }
    fn pending(&self) -> Option<Tag> {
        self.queue.first_tag()
    }
    fn capacity(&self) -> usize {
        self.queue.capacity()
    }
}

impl<T> TriggerCell for LogicalAction<T> {
    fn activate(&mut self, tag: Tag) -> Option<Tag> {
        self.present = true;
        self.happened = Some(tag);
        self.value = self.queue.pop_until(tag).flatten();
        self.queue.first_tag()
    }
    fn clear(&mut self) {
        self.present = false;
        self.value = None;
    }
    fn pending(&self) -> Option<Tag> {
        self.queue.first_tag()
    }
    fn has_room(&self) -> bool {
        self.queue.has_room()
    }
}

impl<T> ModeCell for LogicalAction<T> {
    fn shift(&mut self, from: Tag, to: Tag) -> Option<Tag> {
        // The spacing of events counts in the mode's own time.
        for tag in [&mut self.last, &mut self.before, &mut self.happened].into_iter().flatten() {
            *tag = tag.moved(from, to);
        }
        self.queue.shift(from, to);
        self.queue.first_tag()
    }
    fn discard(&mut self) {
        (self.last, self.before, self.happened) = (None, None, None);
        self.queue.clear();
    }
}

schedule_by_view!(LogicalActionQueue, LogicalAction, T);
cell_by_view!(LogicalActionQueue, LogicalAction, T);
mode_by_view!(LogicalActionQueue, LogicalAction, T);

/// Returns the intended tag of a physical event at `time`: never before the start.
pub(crate) fn physical_tag(time: Instant, timing: &ActionTiming, start: Instant) -> Tag {
    Tag::at((time + timing.min_delay).max(start))
}
