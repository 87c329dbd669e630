// SPDX-License-Identifier: Apache-2.0
//! The API of a reaction's body, that of Lingua Franca's Rust target.
use core::time::Duration;

use crate::bits::{Bits, Walk};
use crate::cell::{Readable, Schedulable, ScheduleContext};
use crate::env::Env;
use crate::error::{ModelError, ScheduleError};
use crate::events::Events;
use crate::modes::Transition;
use crate::outside::Outside;
use crate::physical::{PhysicalActionRef, PhysicalLink};
use crate::port::Port;
use crate::queue::Full;
use crate::state::{Settings, State, intended_for};
use crate::tables::{PortId, ReactionId, Tables, TriggerKind};
use crate::time::{EventTag, Instant, Interval, Offset, Tag};
use crate::watchdog::Watchdog;

/// The `ctx` of a reaction's body.
#[allow(missing_debug_implementations)]
pub struct ReactionContext<'a> {
    pub(crate) tables: &'static Tables,
    pub(crate) settings: &'a Settings,
    pub(crate) state: &'a mut State,
    pub(crate) events: Events<'a>,
    pub(crate) ready: Bits<'a>,
    pub(crate) ports: Bits<'a>,
    /// The reactions that see a tardy value.
    pub(crate) tardy: Bits<'a>,
    /// The intended tag of each input's value.
    pub(crate) intended: &'a [Tag],
    /// Whether what this reaction triggers is tardy too.
    pub(crate) inherits_tardy: bool,
    /// Whether nothing has to happen between two reactions but that the second is looked for.
    pub(crate) runs_in_turn: bool,
    /// The mode that it has requested.
    pub(crate) mode: Option<Transition>,
    pub(crate) env: &'a mut (dyn Env + 'a),
}

impl ReactionContext<'_> {
    /// Calls `body` for reaction `first`, and for those up to `last` that are ready after it: what an engine does,
    /// without what these reactions do not need. They are bodies without deadlines, in a program without modes. On a
    /// board, whose flash is scarcer than the time that this saves, only the first one runs.
    #[doc(hidden)]
    #[inline]
    pub fn in_turn(&mut self, first: u16, last: u16, mut body: impl FnMut(&mut Self, ReactionId)) {
        let (mut id, mut walk) = (first, Walk::above(first));
        loop {
            body(self, ReactionId(id));
            if cfg!(target_os = "none") || !self.runs_in_turn || self.state.error.is_some() {
                return;
            }
            let Some(next) = self.ready.next(&mut walk, last) else { break };
            id = next;
        }
        self.state.untouched = self.tables.reactions[usize::from(id)].level.saturating_add(1);
    }

    /// Returns the value of a port or action at this tag, or `None` when it is absent, or present without a value.
    pub fn get<R>(&self, container: &R) -> Option<R::Value>
    where
        R: Readable + ?Sized,
        R::Value: Copy,
    {
        container.value().copied()
    }

    /// Returns a reference to the value, like [`get`](Self::get), without a copy.
    pub fn get_ref<'r, R: Readable + ?Sized>(&self, container: &'r R) -> Option<&'r R::Value> {
        container.value()
    }

    /// Calls `action` with the value, or with `None` when it is absent, and returns the result.
    pub fn use_ref<R: Readable + ?Sized, O>(&self, container: &R, action: impl FnOnce(Option<&R::Value>) -> O) -> O {
        action(container.value())
    }

    /// Calls `action` with the value if there is one, and returns the result.
    pub fn use_ref_opt<R: Readable + ?Sized, O>(
        &self,
        container: &R,
        action: impl FnOnce(&R::Value) -> O,
    ) -> Option<O> {
        container.value().map(action)
    }

    /// Returns whether a port, action or timer has an event at this tag.
    pub fn is_present<R: Readable + ?Sized>(&self, container: &R) -> bool {
        container.is_present()
    }

    /// Sets a port at this tag. The last value that is set at a tag counts.
    pub fn set<T>(&mut self, port: &mut Port<T>, value: T) {
        port.value = Some(value);
        self.mark_present(port.id);
    }

    /// Triggers the reactions of a port whose value the engine does not store: that of a body in C.
    #[doc(hidden)]
    pub fn mark_present(&mut self, port: PortId) {
        let reactions = self.tables.ports[usize::from(port.0)].reactions;
        if self.ports.insert(port.0) {
            self.ready.insert_reactions(reactions);
        }
        if self.inherits_tardy {
            self.tardy.insert_reactions(reactions);
        }
    }

    /// Sets a port to the value of another one, if that has one: a connection in a mode.
    #[doc(hidden)]
    pub fn copy<T: Clone>(&mut self, from: &Port<T>, to: &mut Port<T>) {
        self.set_opt(to, from.value.clone());
    }

    /// Sets a port if there is a value.
    pub fn set_opt<T>(&mut self, port: &mut Port<T>, value: Option<T>) {
        if let Some(value) = value {
            self.set(port, value);
        }
    }

    /// Schedules an action without a value, later by `offset` in addition to the action's minimum delay.
    ///
    /// A logical action counts from this tag, a physical action from physical time. If the action's queue is full, the
    /// program ends with an error after this reaction.
    pub fn schedule<A: Schedulable + ?Sized>(&mut self, action: &mut A, offset: Offset) {
        self.schedule_with_v(action, None, offset);
    }

    /// Schedules an action with a value, like [`schedule`](Self::schedule).
    pub fn schedule_with_v<A: Schedulable + ?Sized>(
        &mut self,
        action: &mut A,
        value: Option<A::Value>,
        offset: Offset,
    ) {
        let id = action.id();
        let info = &self.tables.triggers[usize::from(id.0)];
        let (TriggerKind::Logical(timing) | TriggerKind::Physical(timing)) = &info.kind else { return };
        let context = ScheduleContext {
            timing,
            offset: offset.to_interval(),
            bounds: self.state.bounds(),
            outside: self.env.outside(),
        };
        if let Err(Full { capacity }) = action.schedule(value, &context) {
            self.fail(ModelError::ActionFull { action: info.name, capacity });
        }
        self.events.set(id, action.pending());
    }

    /// Schedules a physical action the way other threads do.
    ///
    /// # Errors
    /// When the inbox is full; the event is then not scheduled.
    pub fn schedule_physical<T>(&self, action: &PhysicalActionRef<T>, offset: Offset) -> Result<(), ScheduleError> {
        action.post(self.env.outside(), None, offset)
    }

    /// Schedules a physical action with a value, like [`schedule_physical`](Self::schedule_physical).
    ///
    /// # Errors
    /// When the inbox is full; the event is then not scheduled, and the value is dropped.
    pub fn schedule_physical_with_v<T>(
        &self,
        action: &PhysicalActionRef<T>,
        value: Option<T>,
        offset: Offset,
    ) -> Result<(), ScheduleError> {
        action.post(self.env.outside(), value, offset)
    }

    /// Starts a watchdog: it expires when its timeout and `additional` have passed, counted from this tag, unless it is
    /// started again or stopped before.
    ///
    /// When it expires its handler runs, and then the reactions that it triggers.
    pub fn start_watchdog(&mut self, watchdog: &mut Watchdog, additional: Duration) {
        let TriggerKind::Logical(timing) = &self.tables.triggers[usize::from(watchdog.id.0)].kind else { return };
        let delay = timing.min_delay.saturating_add(Offset::After(additional).to_interval());
        watchdog.expires = Some(self.state.current.after(delay)).filter(|tag| tag.is_finite());
        self.events.set(watchdog.id, watchdog.expires);
    }

    /// Stops a watchdog: it does not expire any more until it is started again.
    pub fn stop_watchdog(&mut self, watchdog: &mut Watchdog) {
        watchdog.expires = None;
        self.events.set(watchdog.id, None);
    }

    /// Changes the mode of the reactor from the next microstep on. The last mode that is set at a tag counts.
    ///
    /// The bodies of reactions with a mode among their effects can name it: `-> Two` or `-> reset(Two)`, or `->
    /// history(Two)`.
    pub fn set_mode(&mut self, mode: Transition) {
        self.mode = Some(mode);
    }

    /// Asks the program to stop: at the next microstep, or later by `offset`. In a federation all federates stop at one
    /// tag, which is that or a later one.
    pub fn request_stop(&mut self, offset: Offset) {
        let tag = self.state.current.after(offset.to_interval());
        self.state.request_stop(tag, self.settings.federated);
    }

    /// Stops this program alone, at the next microstep: its shutdown reactions run there. The other federates of a
    /// federation go on without it, and it can come again if it is transient.
    pub fn stop(&mut self) {
        self.state.stop_alone(Tag::NEVER);
    }

    /// Returns the longest time that tags wait for messages: the largest [`NetworkInput::max_wait`], or the last value
    /// of [`set_max_wait`](Self::set_max_wait).
    ///
    /// [`NetworkInput::max_wait`]: crate::NetworkInput::max_wait
    pub fn max_wait(&self) -> Interval {
        let longest = || self.tables.inputs.iter().map(|input| input.max_wait).max();
        self.state.max_wait.or_else(longest).unwrap_or_default()
    }

    /// Sets how long tags wait for messages from now on, whichever input they may come to. It matters only where
    /// messages can be tardy: with decentralized coordination.
    pub fn set_max_wait(&mut self, max_wait: Interval) {
        self.state.max_wait = Some(max_wait);
    }

    /// Ends the program with an error after this reaction. Of several errors, the first is reported.
    ///
    /// For extensions of this context by platforms: a body that wants to end the program calls
    /// [`request_stop`](Self::request_stop).
    pub fn fail(&mut self, error: ModelError) {
        self.state.fail(error);
    }

    /// Returns whether this is the last tag.
    pub fn is_shutdown(&self) -> bool {
        self.state.is_last()
    }

    /// Returns the number of threads that run reactions, the event loop's among them.
    pub fn num_workers(&self) -> usize {
        #[cfg(feature = "workers")]
        let workers = self.tables.workers;
        #[cfg(not(feature = "workers"))]
        let workers = 1u16;
        usize::from(workers)
    }

    /// Returns the link for a physical thread. `spawn_physical_thread`, from the platform's prelude, is built on it.
    pub fn physical_link(&self) -> PhysicalLink {
        PhysicalLink::new(self.env.outside(), self.state.start)
    }

    /// Returns the parts of the participant that other threads may use, for platforms and other languages' bodies.
    #[doc(hidden)]
    pub fn outside(&self) -> &'static dyn Outside {
        self.env.outside()
    }

    /// Returns the program's constant part, for other languages' bodies.
    #[doc(hidden)]
    pub fn tables(&self) -> &'static Tables {
        self.tables
    }

    /// Returns the current tag, for other languages' bodies.
    #[doc(hidden)]
    pub fn current_tag(&self) -> Tag {
        self.state.current
    }

    /// Returns the current tag, relative to the start.
    pub fn get_tag(&self) -> EventTag {
        EventTag::relative(self.state.current, self.state.start)
    }

    /// Returns the tag that the value of an input was intended for: an earlier one than [`get_tag`](Self::get_tag) if
    /// its message has come too late (tardy), else the current one.
    pub fn get_intended_tag<T>(&self, port: &Port<T>) -> EventTag {
        let intended = intended_for(self.tables, self.intended, port.id);
        EventTag::relative(intended.unwrap_or(self.state.current), self.state.start)
    }

    /// Returns the time at which the program started, or its federation if it has joined that later.
    pub fn get_start_time(&self) -> Instant {
        self.state.start
    }

    /// Returns the first tag of this program, relative to the start: that of a transient federate may be later.
    pub fn get_effective_start(&self) -> EventTag {
        EventTag::relative(self.state.first(), self.state.start)
    }

    /// Returns the first tag of this program, for other languages' bodies.
    #[doc(hidden)]
    pub fn first_tag(&self) -> Tag {
        self.state.first()
    }

    /// Returns the id of the federation; empty where the program is not federated.
    #[cfg(feature = "transients")]
    pub fn get_federation_id(&self) -> &'static str {
        self.env.outside().federation_id().to_str().unwrap_or_default()
    }

    /// Returns the current logical time.
    pub fn get_logical_time(&self) -> Instant {
        self.state.current.time
    }

    /// Returns the physical time now.
    pub fn get_physical_time(&self) -> Instant {
        self.env.physical_time()
    }

    /// Returns the logical time since the start.
    pub fn get_elapsed_logical_time(&self) -> Duration {
        self.state.current.time - self.state.start
    }

    /// Returns the physical time since the start.
    pub fn get_elapsed_physical_time(&self) -> Duration {
        self.env.physical_time() - self.state.start
    }
}
