// SPDX-License-Identifier: Apache-2.0
//! Physical actions: events from other threads and interrupts.
//!
//! A thread puts an event with its time-stamp into the action's [`PhysicalInbox`], a static of the generated crate, and
//! wakes the event loop, which moves it to the action's own queue. A critical section of a few instructions guards the
//! inbox, so interrupts can use it, it keeps the order, and it never spins. This module makes no threads:
//! `spawn_physical_thread` is an extension trait of the Linux and Zephyr crates over
//! [`ReactionContext::physical_link`](crate::ReactionContext::physical_link), which can be generic over the thread's
//! closure and so needs neither a heap nor type erasure; it is in their `prelude`, where bodies find it.
use core::cell::RefCell;
use core::fmt;
use core::marker::PhantomData;
use core::ops::Deref;
use core::sync::atomic::Ordering;
use core::time::Duration;

use critical_section::Mutex;
use heapless::Deque;
use heapless::vec::VecStorage;

use crate::action::{LogicalAction, LogicalActionQueue, physical_tag};
use crate::cell::{
    Bounds, Readable, Schedulable, ScheduleContext, TriggerCell, cell_by_view, mode_by_view, schedule_by_view,
};
use crate::error::ScheduleError;
use crate::modes::ModeCell;
use crate::outside::Outside;
#[cfg(feature = "traces")]
use crate::payload::Payload;
use crate::payload::PayloadError;
use crate::queue::{Event, Full, Owned, View};
use crate::tables::{ActionTiming, TriggerId};
use crate::time::{Instant, Interval, Offset, Tag};

/// An event in transit from a thread to the event loop.
#[derive(Debug)]
pub struct Posted<T> {
    time: Instant,
    value: Option<T>,
}

/// The interface of inboxes of all capacities. Only [`PhysicalInbox`] implements it.
pub trait Inbox<T>: Sync {
    /// Puts in an event that happens later than now by `offset`.
    ///
    /// The event gets its time-stamp while the event loop cannot take events out. So when all events have been taken
    /// out after the clock has been read, none comes with an earlier time.
    ///
    /// # Errors
    /// When there is no room.
    fn post(&self, outside: &dyn Outside, offset: Interval, value: Option<T>) -> Result<(), ScheduleError>;

    /// Takes the oldest event out.
    fn take(&self) -> Option<Posted<T>>;
}

/// Events of a physical action that the event loop has not seen yet, at most `N`.
///
/// Generated code makes a `static` per physical action, with the action's capacity from the plan.
pub struct PhysicalInbox<T, const N: usize>(Mutex<RefCell<Deque<Posted<T>, N>>>);

impl<T, const N: usize> PhysicalInbox<T, N> {
    /// Returns an empty inbox.
    pub const fn new() -> Self {
        Self(Mutex::new(RefCell::new(Deque::new())))
    }
}

impl<T, const N: usize> Default for PhysicalInbox<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T, const N: usize> fmt::Debug for PhysicalInbox<T, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PhysicalInbox<{N}>")
    }
}

impl<T: Send, const N: usize> Inbox<T> for PhysicalInbox<T, N> {
    fn post(&self, outside: &dyn Outside, offset: Interval, value: Option<T>) -> Result<(), ScheduleError> {
        // The value that did not fit is dropped outside the critical section, because its `drop` may be the user's
        // code.
        let rejected = critical_section::with(|cs| {
            // Before the clock is read: an event loop that reads a later time after this then looks into the inbox.
            outside.mailbox().announce();
            let time = outside.physical_time() + offset;
            self.0.borrow_ref_mut(cs).push_back(Posted { time, value }).err()
        });
        if rejected.is_some() { Err(ScheduleError { capacity: N }) } else { Ok(()) }
    }

    fn take(&self) -> Option<Posted<T>> {
        critical_section::with(|cs| self.0.borrow_ref_mut(cs).pop_front())
    }
}

/// A reference to a physical action for other threads: `let act = act.clone();`.
pub struct PhysicalActionRef<T: 'static> {
    inbox: &'static dyn Inbox<T>,
}

impl<T> Clone for PhysicalActionRef<T> {
    fn clone(&self) -> Self {
        Self { inbox: self.inbox }
    }
}

impl<T> fmt::Debug for PhysicalActionRef<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("PhysicalActionRef")
    }
}

impl<T> PhysicalActionRef<T> {
    /// Returns the action with this inbox, for bodies that know it by its number.
    #[doc(hidden)]
    pub const fn new(inbox: &'static dyn Inbox<T>) -> Self {
        Self { inbox }
    }

    pub(crate) fn post(&self, outside: &dyn Outside, value: Option<T>, offset: Offset) -> Result<(), ScheduleError> {
        self.inbox.post(outside, offset.to_interval(), value)?;
        outside.wake();
        Ok(())
    }
}

/// A physical action with room for `N` pending events. Generated code makes one per trigger of this kind, with the
/// capacity from the plan, and passes it to reactions as `&PhysicalAction<T>`, or as effect `&mut PhysicalAction<T>`.
pub type PhysicalActionQueue<T, const N: usize> = PhysicalAction<T, Owned<Option<T>, N>>;

/// A physical action, as bodies see it. It derefs to the [`PhysicalActionRef`] that other threads use.
pub struct PhysicalAction<T: 'static, S: VecStorage<Event<Option<T>>> + ?Sized = View<Option<T>>> {
    handle: PhysicalActionRef<T>,
    /// Writes a value as bytes, for who records what comes from outside.
    #[cfg(feature = "traces")]
    encode: Encode<T>,
    action: LogicalAction<T, S>,
}

impl<T, const N: usize> PhysicalActionQueue<T, N> {
    /// Returns an action without pending events, and with the inbox that threads use.
    pub const fn new(id: TriggerId, inbox: &'static dyn Inbox<T>) -> Self {
        Self {
            handle: PhysicalActionRef { inbox },
            #[cfg(feature = "traces")]
            encode: None,
            action: LogicalActionQueue::new(id),
        }
    }

    /// Sets how its values are written as bytes where they are recorded; see [`encoder!`](crate::encoder).
    #[must_use]
    #[cfg_attr(not(feature = "traces"), expect(unused_mut, unused_variables, reason = "nothing is recorded"))]
    pub const fn encoded_by(mut self, encode: Encode<T>) -> Self {
        #[cfg(feature = "traces")]
        {
            self.encode = encode;
        }
        self
    }
}

/// Writes a value as bytes, if its type has a form as bytes.
pub type Encode<T> = Option<fn(&T, &mut [u8]) -> Result<usize, PayloadError>>;

/// The encoding of a type's values, which [`encoder!`](crate::encoder) chooses.
#[doc(hidden)]
#[derive(Debug)]
pub struct Encoder<T>(PhantomData<T>);

#[cfg(feature = "traces")]
impl<T: Payload> Encoder<T> {
    /// The value has a form as bytes, so this hides [`Opaque::ENCODE`].
    pub const ENCODE: Encode<T> = Some(T::encode);
}

/// Types whose values have no known form as bytes.
#[doc(hidden)]
pub trait Opaque<T> {
    /// Nothing writes them.
    const ENCODE: Encode<T> = None;
}

impl<T> Opaque<T> for Encoder<T> {}

/// Returns how values of a type are written as bytes where they are recorded, or `None` if they have no form as bytes;
/// without the feature `traces` it is `None`.
#[macro_export]
macro_rules! encoder {
    ($type:ty) => {{
        #[allow(unused_imports)]
        use $crate::Opaque as _;
        $crate::Encoder::<$type>::ENCODE
    }};
}

impl<T: fmt::Debug, S: VecStorage<Event<Option<T>>> + ?Sized> fmt::Debug for PhysicalAction<T, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("PhysicalAction").field(&&self.action).finish()
    }
}

impl<T, S: VecStorage<Event<Option<T>>> + ?Sized> Deref for PhysicalAction<T, S> {
    type Target = PhysicalActionRef<T>;
    fn deref(&self) -> &PhysicalActionRef<T> {
        &self.handle
    }
}

impl<T, S: VecStorage<Event<Option<T>>> + ?Sized> Readable for PhysicalAction<T, S> {
    type Value = T;
    fn is_present(&self) -> bool {
        Readable::is_present(&self.action)
    }
    fn value(&self) -> Option<&T> {
        self.action.value()
    }
}

impl<T> Schedulable for PhysicalAction<T> {
    type Value = T;
    fn id(&self) -> TriggerId {
        self.action.id()
    }
    fn schedule(&mut self, value: Option<T>, context: &ScheduleContext<'_>) -> Result<(), Full> {
        let time = context.outside.physical_time() + context.offset;
        let tag = physical_tag(time, context.timing, context.bounds.start);
        self.action.insert(tag, value, context.timing, &context.bounds)
    }
    fn pending(&self) -> Option<Tag> {
        Schedulable::pending(&self.action)
    }
    fn capacity(&self) -> usize {
        self.action.capacity()
    }
}

impl<T> TriggerCell for PhysicalAction<T> {
    fn activate(&mut self, tag: Tag) -> Option<Tag> {
        self.action.activate(tag)
    }
    fn clear(&mut self) {
        self.action.clear();
    }
    fn pending(&self) -> Option<Tag> {
        TriggerCell::pending(&self.action)
    }
    fn has_room(&self) -> bool {
        self.action.has_room()
    }
    fn drain(&mut self, timing: &ActionTiming, bounds: &Bounds) {
        while self.action.has_room() {
            let Some(Posted { time, value }) = self.handle.inbox.take() else { return };
            let tag = physical_tag(time, timing, bounds.start);
            // There is room: the check above said so, and only this function fills the queue.
            let _ = self.action.insert(tag, value, timing, bounds);
        }
    }
    #[cfg(feature = "traces")]
    fn encode_event(&self, bytes: &mut [u8]) -> Option<Result<usize, PayloadError>> {
        Some((self.encode?)(self.action.value()?, bytes))
    }
}

impl<T> ModeCell for PhysicalAction<T> {
    fn shift(&mut self, from: Tag, to: Tag) -> Option<Tag> {
        self.action.shift(from, to)
    }
    fn discard(&mut self) {
        self.action.discard();
    }
    fn forget(&mut self) {
        while self.handle.inbox.take().is_some() {}
    }
}

schedule_by_view!(PhysicalActionQueue, PhysicalAction, T: 'static);
cell_by_view!(PhysicalActionQueue, PhysicalAction, T: 'static);
mode_by_view!(PhysicalActionQueue, PhysicalAction, T: 'static);

/// The link of a physical thread to the program that started it: it can schedule physical actions and ask to stop.
///
/// While a link lives, an unfederated program without events waits for it.
pub struct PhysicalLink {
    outside: &'static dyn Outside,
    start: Instant,
}

impl PhysicalLink {
    /// Returns the link of a thread that the platform has not started.
    #[doc(hidden)]
    pub fn new(outside: &'static dyn Outside, start: Instant) -> Self {
        outside.mailbox().links.fetch_add(1, Ordering::AcqRel);
        Self { outside, start }
    }

    /// Schedules an event of a physical action, now or later by `offset`, and later by the action's minimum delay.
    ///
    /// # Errors
    /// When the inbox is full; the event is then not scheduled.
    pub fn schedule_physical<T>(&self, action: &PhysicalActionRef<T>, offset: Offset) -> Result<(), ScheduleError> {
        action.post(self.outside, None, offset)
    }

    /// Schedules an event with a value, like [`schedule_physical`](Self::schedule_physical).
    ///
    /// # Errors
    /// When the inbox is full; the event is then not scheduled, and the value is dropped.
    pub fn schedule_physical_with_v<T>(
        &self,
        action: &PhysicalActionRef<T>,
        value: Option<T>,
        offset: Offset,
    ) -> Result<(), ScheduleError> {
        action.post(self.outside, value, offset)
    }

    /// Returns a handle that schedules this action while this link lives, and that an interrupt can copy.
    pub fn poster<T>(&self, action: &PhysicalActionRef<T>) -> Poster<T> {
        Poster { action: action.clone(), outside: self.outside }
    }

    /// Asks the program to stop, at the physical time now or later by `offset`.
    pub fn request_stop(&self, offset: Offset) {
        self.outside.mailbox().request_stop(self.get_physical_time() + offset.to_interval());
        self.outside.wake();
    }

    /// Returns the time at which the program started.
    pub fn get_start_time(&self) -> Instant {
        self.start
    }

    /// Returns the time now.
    pub fn get_physical_time(&self) -> Instant {
        self.outside.physical_time()
    }

    /// Returns the time since the program started.
    pub fn get_elapsed_physical_time(&self) -> Duration {
        self.get_physical_time() - self.start
    }
}

impl Clone for PhysicalLink {
    fn clone(&self) -> Self {
        Self::new(self.outside, self.start)
    }
}

impl Drop for PhysicalLink {
    fn drop(&mut self) {
        self.outside.mailbox().links.fetch_sub(1, Ordering::AcqRel);
        // The event loop may have been waiting for this thread alone.
        self.outside.wake();
    }
}

/// Schedules one physical action. The program does not wait for it, as it does for a [`PhysicalLink`]: the owner of a
/// poster also keeps the link that made it.
pub struct Poster<T: 'static> {
    action: PhysicalActionRef<T>,
    outside: &'static dyn Outside,
}

impl<T> Poster<T> {
    /// Schedules an event now, and later by the action's minimum delay. Callable from interrupts.
    ///
    /// # Errors
    /// When the inbox is full; the event is then not scheduled, and the value is dropped.
    pub fn post(&self, value: Option<T>) -> Result<(), ScheduleError> {
        self.action.post(self.outside, value, Offset::Asap)
    }

    /// Schedules an event at the time that this clock shows: that of an earlier interrupt. The clock must not show a
    /// time before one up to which the event loop may already have announced that nothing comes; see [`Inbox::post`].
    ///
    /// # Errors
    /// Those of [`post`](Self::post).
    pub fn post_by(&self, clock: &dyn Outside, value: Option<T>) -> Result<(), ScheduleError> {
        self.action.post(clock, value, Offset::Asap)
    }
}

impl<T> Clone for Poster<T> {
    fn clone(&self) -> Self {
        Self { action: self.action.clone(), outside: self.outside }
    }
}

impl<T> fmt::Debug for Poster<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Poster")
    }
}

impl fmt::Debug for PhysicalLink {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PhysicalLink").field("start", &self.start).finish_non_exhaustive()
    }
}
