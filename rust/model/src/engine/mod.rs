// SPDX-License-Identifier: Apache-2.0
//! The scheduler of one federate. An event loop drives it; the engine itself waits for nothing.
//!
//! Order of use: [`start`](Engine::start) once; then, while [`is_done`](Engine::is_done) is false,
//! [`drain_physical`](Engine::drain_physical), [`next_tag`](Engine::next_tag), wait until physical time (and the RTI)
//! allow it, [`begin`](Engine::begin), and [`advance`](Engine::advance) until it returns [`Progress::Complete`].
//! [`deliver`](Engine::deliver) and [`set_stop_tag`](Engine::set_stop_tag) may come at any time between these.
mod modes;
mod tag;
mod tardy;
#[cfg(feature = "workers")]
mod workers;

use crate::bits::Bits;
use crate::env::Env;
use crate::error::{DeliverError, ModelError};
use crate::events::Events;
use crate::modes::{ModeEvent, ModeState};
use crate::outside::Mailbox;
#[cfg(feature = "traces")]
use crate::payload::PayloadError;
use crate::program::Program;
use crate::state::{Last, Phase, Settings, State, Tardy};
use crate::storage::{EngineStorage, StorageParts};
use crate::tables::{InputId, OutputId, Tables, TriggerId, TriggerKind};
use crate::time::{Instant, Interval, Tag};
pub use tardy::Delivery;

/// The progress of [`Engine::advance`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The tag is complete, and its ports are clear.
    Complete,
    /// A value for another federate has no room. The tag is still open; call again when there is room.
    OutputFull {
        /// The connection without room.
        output: OutputId,
    },
    /// All reactions below a level that is not allowed yet have run. The tag is still open, even if no reaction is left
    /// to run, because a message may come; call again with a higher limit, or with none.
    LevelLimit {
        /// That level.
        level: u16,
    },
    /// The program cannot go on.
    Failed(ModelError),
}

/// Writes the value of an event as bytes, and returns their number; `None` if it has no value, or none that has a form
/// as bytes.
#[cfg(feature = "traces")]
pub type EncodeEvent<'a> = dyn Fn(&mut [u8]) -> Option<Result<usize, PayloadError>> + 'a;

/// The scheduler of one federate. It borrows its storage, and exists once however many federates there are.
#[derive(Debug)]
pub struct Engine<'s> {
    tables: &'static Tables,
    settings: Settings,
    state: State,
    events: Events<'s>,
    /// Timers and actions that have an event at this tag.
    active: Bits<'s>,
    /// Reactions that have been triggered at this tag, and have not run.
    ready: Bits<'s>,
    /// Ports that have been set at this tag.
    ports: Bits<'s>,
    /// The tardy values of this tag.
    tardy: Tardy<'s>,
    /// The last message of each input that was in time, if any input can be tardy.
    last: &'s mut [Last],
    /// The state of modes, in a program with modes.
    modes: &'s mut [ModeState],
    /// The next event of each trigger in a mode when the mode was left.
    held: &'s mut [Tag],
}

impl<'s> Engine<'s> {
    /// Returns an engine for the program with these tables, in storage of their size.
    pub fn new(tables: &'static Tables, storage: &'s mut impl EngineStorage, settings: Settings) -> Self {
        let StorageParts { next, winners, active, ready, ports, tardy, intended, last, modes, held } = storage.parts();
        let mut engine = Self {
            tables,
            settings,
            state: State {
                phase: Phase::NotStarted,
                start: Instant::NEVER,
                #[cfg(feature = "transients")]
                first: Tag::NEVER,
                current: Tag::NEVER,
                stop: Tag::FOREVER,
                sends_until: Tag::FOREVER,
                stop_request: None,
                error: None,
                network_input: false,
                untouched: 0,
                max_wait: None,
                #[cfg(feature = "traces")]
                records_steps: false,
            },
            events: Events { next, winners },
            active: Bits(active),
            ready: Bits(ready),
            ports: Bits(ports),
            tardy: Tardy { reactions: Bits(tardy), intended },
            last,
            modes,
            held,
        };
        engine.events.reset();
        engine.active.clear();
        engine.ready.clear();
        engine.ports.clear();
        engine.tardy.clear();
        engine.last.fill(Last::NONE);
        engine
    }

    // --- Getters ---

    /// Returns the settings of the program.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Returns the program's constant part.
    pub fn tables(&self) -> &'static Tables {
        self.tables
    }

    /// Returns the time at which the program started.
    pub fn start_time(&self) -> Instant {
        self.state.start
    }

    /// Returns the tag that is open, or the last that was complete; before the first, the one before the start.
    pub fn current_tag(&self) -> Tag {
        self.state.current
    }

    /// Returns whether a tag is open: [`begin`](Self::begin) was called, and [`advance`](Self::advance) has not
    /// completed it.
    pub fn is_in_tag(&self) -> bool {
        self.state.phase == Phase::InTag
    }

    /// Returns whether the open tag, or the last complete one, had messages from other federates.
    pub fn had_network_input(&self) -> bool {
        self.state.network_input
    }

    /// Returns whether the last tag of the program is complete.
    pub fn is_done(&self) -> bool {
        self.state.phase == Phase::Done
    }

    /// Returns the last tag of the program, FOREVER while none is set.
    pub fn stop_tag(&self) -> Tag {
        self.state.stop
    }

    /// Returns the next tag with an event: the earliest event, or the stop tag before it. `None` if there is no event.
    pub fn next_tag(&self) -> Option<Tag> {
        if self.is_done() {
            return None;
        }
        let event = self.events.earliest().map_or(Tag::FOREVER, |(tag, _)| tag);
        Some(event.min(self.state.stop)).filter(|tag| *tag != Tag::FOREVER)
    }

    /// Returns the stop that a reaction or a thread of a federate has asked for since the last call. The RTI has to
    /// grant it.
    pub fn take_stop_request(&mut self) -> Option<Tag> {
        self.state.stop_request.take()
    }

    /// Returns how long, after a tag's time, the tag waits for a message to an input before it: the time of the tables,
    /// or the one that a body has set. Zero for an input that does not exist.
    pub fn max_wait(&self, input: InputId) -> Interval {
        let input = self.tables.inputs.get(usize::from(input.0));
        input.map_or(Interval::ZERO, |input| self.state.max_wait.unwrap_or(input.max_wait))
    }

    /// Returns whether another message fits into the queue of an input; `false` for an input that does not exist.
    pub fn has_room(&self, program: &mut dyn Program, input: InputId) -> bool {
        let input = self.tables.inputs.get(usize::from(input.0));
        input.and_then(|input| program.trigger(input.trigger)).is_some_and(|cell| cell.has_room())
    }

    /// Calls `take` for all that comes from outside at the open tag, which has just begun: physical actions, and
    /// connections without the sender's tag within the program. What it is given writes the event's value as bytes.
    #[cfg(feature = "traces")]
    pub fn physical_events(&self, program: &mut dyn Program, take: &mut dyn FnMut(TriggerId, &EncodeEvent<'_>)) {
        for (id, trigger) in (0..).map(TriggerId).zip(self.tables.triggers) {
            let happens = match trigger.kind {
                TriggerKind::Physical(_) => self.active.contains(id.0),
                TriggerKind::PhysicalDelay { fills, .. } => self.ports.contains(fills.0),
                _ => false,
            };
            if let Some(cell) = program.trigger(id).filter(|_| happens) {
                take(id, &|bytes| cell.encode_event(bytes));
            }
        }
    }

    // --- Commands ---

    /// Sets whether [`Env::step`] receives the steps of reactions.
    #[cfg(feature = "traces")]
    pub fn record_steps(&mut self, record: bool) {
        self.state.records_steps = record;
    }

    /// Sets the time of the first tag, and with it that of timers and timeout.
    pub fn start(&mut self, start: Instant) {
        self.begin_at(start, Tag::at(start));
    }

    /// Starts a program that joins its federation later: at this tag. Elapsed times and the timeout count from the
    /// start of the federation, timers from the first tag. The first tag is the last one where the timeout is over.
    #[cfg(feature = "transients")]
    pub fn join(&mut self, start: Instant, first: Tag) {
        self.begin_at(start, first.max(Tag::at(start)));
    }

    fn begin_at(&mut self, start: Instant, first: Tag) {
        self.state.start = start;
        #[cfg(feature = "transients")]
        {
            self.state.first = first;
        }
        self.state.current = first.before();
        self.state.phase = Phase::BetweenTags;
        if let Some(timeout) = self.settings.timeout {
            self.state.stop_at(Tag::at(start + timeout).max(first));
        }
        for (id, trigger) in (0..).map(TriggerId).zip(self.tables.triggers) {
            match trigger.kind {
                TriggerKind::Startup => self.events.set(id, Some(first)),
                TriggerKind::Timer { offset, .. } => {
                    self.events.set(id, Some(Tag::at(first.time + offset).max(first)));
                }
                _ => {}
            }
        }
        self.modes_at(ModeEvent::Start(first));
    }

    /// Makes `tag` the last one of the program, or the next microstep when that has passed. A stop is never postponed.
    pub fn set_stop_tag(&mut self, tag: Tag) {
        if self.state.current < self.state.stop {
            self.state.stop_at(tag.max(self.state.current.next_microstep()));
        }
    }

    /// Makes the next microstep the last tag of this program alone, or `earliest` if that is later. What it sends
    /// before that arrives, whenever it is for.
    pub fn stop_alone(&mut self, earliest: Tag) {
        if self.state.current < self.state.stop {
            self.state.stop_alone(earliest);
        }
    }

    /// Returns whether a tag has begun after which nothing is sent.
    pub fn has_sent_all(&self) -> bool {
        self.state.current >= self.state.sends_until
    }

    /// Makes the next microstep the last tag, when nothing can happen any more: no event is pending, no stop is set, no
    /// physical thread has a link, and `keepalive` is not set. Returns whether it did. Not for federates, to which
    /// messages may come: for them the RTI grants FOREVER, and [`set_stop_tag`](Self::set_stop_tag) follows.
    pub fn stop_if_idle(&mut self, env: &dyn Env) -> bool {
        let links = env.outside().mailbox().links();
        let idle = self.next_tag().is_none() && !self.is_done() && !self.settings.keepalive && links == 0;
        if idle {
            self.set_stop_tag(Tag::NEVER);
        }
        idle
    }

    /// Schedules the events of other threads. Call it whenever the event loop was woken, before `next_tag`.
    pub fn drain_physical(&mut self, program: &mut dyn Program, env: &dyn Env) {
        let mailbox = env.outside().mailbox();
        if mailbox.take_news() {
            self.take_news(program, mailbox);
        }
    }

    fn take_news(&mut self, program: &mut dyn Program, mailbox: &Mailbox) {
        let bounds = self.state.bounds();
        for (id, trigger) in (0..).map(TriggerId).zip(self.tables.triggers) {
            let TriggerKind::Physical(timing) = &trigger.kind else { continue };
            if !self.is_active(id) {
                if let Some(cell) = program.modes().and_then(|cells| cells.in_mode(id)) {
                    cell.forget();
                }
                continue;
            }
            if let Some(cell) = program.trigger(id) {
                cell.drain(timing, &bounds);
                if !cell.has_room() {
                    // More events may be in the inbox.
                    mailbox.announce();
                }
                self.events.set(id, cell.pending());
            }
        }
        if let Some(time) = mailbox.take_stop() {
            let tag = Tag::at(time).max(self.state.current.next_microstep());
            self.state.request_stop(tag, self.settings.federated);
        }
    }

    /// Takes a message from another federate. A message after the stop tag is dropped.
    ///
    /// A message for the tag that is open takes effect at once: its value is present, and triggers reactions. It is
    /// late when a reaction has run that could have seen it, or one of a higher level.
    ///
    /// # Errors
    /// [`DeliverError::Full`] asks to wait, and to try again with the same message; the others are fatal.
    pub fn deliver(
        &mut self,
        program: &mut dyn Program,
        input: InputId,
        tag: Tag,
        bytes: &[u8],
    ) -> Result<(), DeliverError> {
        let info = self.tables.inputs.get(usize::from(input.0)).ok_or(DeliverError::NoSuchPort { port: input.0 })?;
        if tag > self.state.stop || tag.time == Instant::FOREVER {
            return Ok(());
        }
        let current = self.state.current;
        let in_time = tag > current || (tag == current && self.is_in_tag() && self.state.untouched <= info.level);
        if !in_time {
            return Err(DeliverError::Late { input: info.name, tag, current });
        }
        if tag == current && self.is_filled(info.trigger) {
            // As before the tag, a second message for one tag happens a microstep later.
            return self.deliver(program, input, tag.next_microstep(), bytes);
        }
        program.deliver(input, tag, bytes).map_err(|error| error.at(info.name, input.0))?;
        if tag == current {
            self.activate(program, info.trigger);
            return Ok(());
        }
        let pending = program.trigger(info.trigger).and_then(|cell| cell.pending());
        self.events.set(info.trigger, pending);
        Ok(())
    }

    /// Takes a message from another federate over a physical connection: it takes effect at physical time `now`, after
    /// the connection's delay, or at the next microstep if that has passed. A message after the stop tag is dropped.
    ///
    /// # Errors
    /// [`DeliverError::Full`] asks to wait, and to try again with the same message; the others are fatal.
    pub fn deliver_physical(
        &mut self,
        program: &mut dyn Program,
        input: InputId,
        now: Instant,
        bytes: &[u8],
    ) -> Result<(), DeliverError> {
        let info = self.tables.inputs.get(usize::from(input.0)).ok_or(DeliverError::NoSuchPort { port: input.0 })?;
        self.deliver(program, input, self.physical_tag(now, info.delay.unwrap_or_default()), bytes)
    }

    /// Returns the tag of an event from physical time: never one that has begun, nor before the start.
    fn physical_tag(&self, now: Instant, delay: Interval) -> Tag {
        Tag::at((now + delay).max(self.state.start)).max(self.state.current.next_microstep())
    }

    /// Returns whether the port that a trigger fills has a value at the open tag.
    fn is_filled(&self, trigger: TriggerId) -> bool {
        let kind = self.tables.triggers[usize::from(trigger.0)].kind;
        kind.fills().is_some_and(|port| self.ports.contains(port.0))
    }
}
