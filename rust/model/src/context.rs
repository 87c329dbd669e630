// SPDX-License-Identifier: Apache-2.0
//! What a reaction's body can do: the API of Lingua Franca's Rust target.
use core::time::Duration;

use crate::bits::Bits;
use crate::cell::{Moment, Readable, Schedulable};
use crate::env::Env;
use crate::error::{ModelError, ScheduleError};
use crate::events::Events;
use crate::modes::Transition;
use crate::outside::Outside;
use crate::physical::{PhysicalActionRef, PhysicalLink};
use crate::port::Port;
use crate::queue::Full;
use crate::state::{Settings, State, intended_for, mark_tardy};
use crate::tables::{PortId, Tables, TriggerKind};
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
    /// The reactions that see something tardy.
    pub(crate) tardy: Bits<'a>,
    /// By input: what its value was intended for.
    pub(crate) intended: &'a [Tag],
    /// What this reaction triggers is tardy too.
    pub(crate) inherits_tardy: bool,
    /// The mode that it has asked for.
    pub(crate) mode: Option<Transition>,
    pub(crate) env: &'a mut (dyn Env + 'a),
}

impl ReactionContext<'_> {
    /// The value of a port or action at this tag, or `None` when it is absent, or present without a value.
    pub fn get<R>(&self, container: &R) -> Option<R::Value>
    where
        R: Readable + ?Sized,
        R::Value: Copy,
    {
        container.value().copied()
    }

    /// Like [`get`](Self::get), for values that are not to be copied.
    pub fn get_ref<'r, R: Readable + ?Sized>(&self, container: &'r R) -> Option<&'r R::Value> {
        container.value()
    }

    /// Calls `action` with the value, or with `None` when it is absent, and gives what that gives.
    pub fn use_ref<R: Readable + ?Sized, O>(&self, container: &R, action: impl FnOnce(Option<&R::Value>) -> O) -> O {
        action(container.value())
    }

    /// Calls `action` with the value if there is one, and gives what that gives.
    pub fn use_ref_opt<R: Readable + ?Sized, O>(
        &self,
        container: &R,
        action: impl FnOnce(&R::Value) -> O,
    ) -> Option<O> {
        container.value().map(action)
    }

    /// Whether a port, action or timer has an event at this tag.
    pub fn is_present<R: Readable + ?Sized>(&self, container: &R) -> bool {
        container.is_present()
    }

    /// Sets a port at this tag. The last value that is set at a tag counts.
    pub fn set<T>(&mut self, port: &mut Port<T>, value: T) {
        port.value = Some(value);
        self.mark_present(port.id);
    }

    /// Triggers what sees a port, whose value lies where the engine does not know it: that of a body in C.
    #[doc(hidden)]
    pub fn mark_present(&mut self, port: PortId) {
        let reactions = self.tables.ports[usize::from(port.0)].reactions;
        if self.ports.insert(port.0) {
            for reaction in reactions {
                self.ready.insert(reaction.0);
            }
        }
        if self.inherits_tardy {
            mark_tardy(&mut self.tardy, reactions);
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

    /// Schedules an action without a value, later by `offset` on top of the action's minimum delay.
    ///
    /// A logical action counts from this tag, a physical action from physical time. Where the action's queue is full
    /// the program ends with an error after this reaction.
    pub fn schedule<A: Schedulable + ?Sized>(&mut self, action: &mut A, offset: Offset) {
        self.schedule_with_v(action, None, offset);
    }

    /// Like [`schedule`](Self::schedule), with a value.
    pub fn schedule_with_v<A: Schedulable + ?Sized>(
        &mut self,
        action: &mut A,
        value: Option<A::Value>,
        offset: Offset,
    ) {
        let id = action.id();
        let info = &self.tables.triggers[usize::from(id.0)];
        let (TriggerKind::Logical(timing) | TriggerKind::Physical(timing)) = &info.kind else { return };
        let moment =
            Moment { timing, offset: offset.to_interval(), bounds: self.state.bounds(), outside: self.env.outside() };
        if let Err(Full { capacity }) = action.schedule(value, &moment) {
            self.fail(ModelError::ActionFull { action: info.name, capacity });
        }
        self.events.set(id, action.pending());
    }

    /// Schedules a physical action the way other threads do.
    ///
    /// # Errors
    /// When as many events wait as there is room for; the event is then not scheduled.
    pub fn schedule_physical<T>(&self, action: &PhysicalActionRef<T>, offset: Offset) -> Result<(), ScheduleError> {
        action.post(self.env.outside(), None, offset)
    }

    /// Like [`schedule_physical`](Self::schedule_physical), with a value.
    ///
    /// # Errors
    /// When as many events wait as there is room for; the event is then not scheduled, and the value is dropped.
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
    /// A mode is known in the bodies of those reactions that have it among their effects: `-> Two` or `-> reset(Two)`,
    /// or `-> history(Two)`.
    pub fn set_mode(&mut self, mode: Transition) {
        self.mode = Some(mode);
    }

    /// Asks the program to stop: at the next microstep, or later by `offset`. In a federation all federates stop at
    /// one tag, which is that or a later one.
    pub fn request_stop(&mut self, offset: Offset) {
        let tag = self.state.current.after(offset.to_interval());
        self.state.request_stop(tag, self.settings.federated);
    }

    /// How long tags wait for messages, at the longest: the largest [`NetworkInput::max_wait`], or what was set last.
    ///
    /// [`NetworkInput::max_wait`]: crate::NetworkInput::max_wait
    pub fn max_wait(&self) -> Interval {
        let longest = || self.tables.inputs.iter().map(|input| input.max_wait).max();
        self.state.max_wait.or_else(longest).unwrap_or_default()
    }

    /// Sets how long tags wait for messages from now on, whichever input they may come to. It matters where messages
    /// can be tardy only: with decentralized coordination.
    pub fn set_max_wait(&mut self, max_wait: Interval) {
        self.state.max_wait = Some(max_wait);
    }

    /// Ends the program with an error after this reaction. Where several things fail, the first is reported.
    ///
    /// For what platforms add to this context: a body that wants to end the program calls
    /// [`request_stop`](Self::request_stop).
    pub fn fail(&mut self, error: ModelError) {
        self.state.fail(error);
    }

    /// Whether this is the last tag.
    pub fn is_shutdown(&self) -> bool {
        self.state.is_last()
    }

    /// How many threads run reactions: the event loop does, and the others that the program has asked for.
    pub fn num_workers(&self) -> usize {
        #[cfg(feature = "workers")]
        let workers = self.tables.workers;
        #[cfg(not(feature = "workers"))]
        let workers = 1u16;
        usize::from(workers)
    }

    /// What a physical thread is given. `spawn_physical_thread`, from the platform's prelude, is built on it.
    pub fn physical_link(&self) -> PhysicalLink {
        PhysicalLink::new(self.env.outside(), self.state.start)
    }

    /// What other threads may use of the participant, for platforms and other languages' bodies.
    #[doc(hidden)]
    pub fn outside(&self) -> &'static dyn Outside {
        self.env.outside()
    }

    /// The program's constant part, for other languages' bodies.
    #[doc(hidden)]
    pub fn tables(&self) -> &'static Tables {
        self.tables
    }

    /// The current tag, for other languages' bodies.
    #[doc(hidden)]
    pub fn current_tag(&self) -> Tag {
        self.state.current
    }

    /// The current tag, relative to the start.
    pub fn get_tag(&self) -> EventTag {
        EventTag::relative(self.state.current, self.state.start)
    }

    /// The tag that the value of an input was intended for: an earlier one than [`get_tag`](Self::get_tag) where its
    /// message has come too late (tardy), else the current one.
    pub fn get_intended_tag<T>(&self, port: &Port<T>) -> EventTag {
        let intended = intended_for(self.tables, self.intended, port.id);
        EventTag::relative(intended.unwrap_or(self.state.current), self.state.start)
    }

    /// The time at which the program started.
    pub fn get_start_time(&self) -> Instant {
        self.state.start
    }

    /// The current logical time.
    pub fn get_logical_time(&self) -> Instant {
        self.state.current.time
    }

    /// The physical time now.
    pub fn get_physical_time(&self) -> Instant {
        self.env.physical_time()
    }

    /// The logical time since the start.
    pub fn get_elapsed_logical_time(&self) -> Duration {
        self.state.current.time - self.state.start
    }

    /// The physical time since the start.
    pub fn get_elapsed_physical_time(&self) -> Duration {
        self.env.physical_time() - self.state.start
    }
}
