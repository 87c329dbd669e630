// SPDX-License-Identifier: Apache-2.0
//! Modes: their tables, how a body changes them, and the effect of a change.
//!
//! The events of a mode that is not active stay in their queues, and only the event queue does not know them. When the
//! mode is active again, they move by the time for which it was not.
//!
//! A program without modes carries none of this: the engine reaches it only through [`Modes`], which only the tables of
//! a program with modes have.
use core::fmt;

use crate::bits::Bits;
use crate::events::Events;
use crate::ids::{ModeId, ReactionId, TriggerId};
use crate::time::{Interval, Tag};

/// The modes of a program, and their parts.
#[derive(Clone, Copy)]
pub struct Modes {
    /// The modes, those of a container before those of what it contains.
    pub modes: &'static [ModeInfo],
    /// The innermost mode of each reaction.
    pub reactions: &'static [Option<ModeId>],
    /// The triggers in modes.
    pub triggers: &'static [ModeTrigger],
    /// The reactions that a change of modes triggers.
    pub events: ModeEvents,
    pub(crate) hooks: &'static Hooks,
}

/// A mode of an instance.
#[derive(Clone, Copy, Debug)]
pub struct ModeInfo {
    /// For people: `unit_a.sensor.Calibrating`.
    pub name: &'static str,
    /// The modal instance: modes with the same number exclude each other.
    pub instance: u16,
    /// The innermost mode that the instance is in.
    pub parent: Option<ModeId>,
    /// Whether the instance begins in it.
    pub initial: bool,
}

/// A trigger in a mode.
#[derive(Clone, Copy, Debug)]
pub struct ModeTrigger {
    /// The trigger.
    pub trigger: TriggerId,
    /// The innermost mode that it is in.
    pub mode: ModeId,
    /// The offset of a timer; others have none.
    pub offset: Option<Interval>,
}

/// The reactions that a change of modes triggers, in modes and elsewhere.
#[derive(Clone, Copy, Debug)]
pub struct ModeEvents {
    /// The trigger of kind `Reset`, which has an event when a mode is entered.
    pub entry: TriggerId,
    /// The reactions to `startup`.
    pub startup: &'static [ReactionId],
    /// The reactions to `reset`.
    pub reset: &'static [ReactionId],
    /// The reactions to `shutdown`.
    pub shutdown: &'static [ReactionId],
}

impl Modes {
    /// Returns these modes; the engine of a program whose tables have them carries the code for them.
    pub const fn new(
        modes: &'static [ModeInfo],
        reactions: &'static [Option<ModeId>],
        triggers: &'static [ModeTrigger],
        events: ModeEvents,
    ) -> Self {
        Self { modes, reactions, triggers, events, hooks: &Hooks::ALL }
    }

    fn of_reaction(&self, reaction: ReactionId) -> Option<ModeId> {
        self.reactions[usize::from(reaction.0)]
    }

    pub(crate) const fn check(&self, reactions: usize, triggers: usize) {
        assert!(self.modes.len() <= u16::MAX as usize, "more modes than a ModeId can number");
        assert!(self.reactions.len() == reactions, "not every reaction says in which mode it is");
        assert!((self.events.entry.0 as usize) < triggers, "modes are entered by a trigger that does not exist");
        let mut i = 0;
        while i < self.modes.len() {
            if let Some(parent) = self.modes[i].parent {
                assert!((parent.0 as usize) < i, "a mode comes before the one that contains it");
            }
            i += 1;
        }
        let mut i = 0;
        while i < reactions {
            if let Some(mode) = self.reactions[i] {
                assert!((mode.0 as usize) < self.modes.len(), "a reaction is in a mode that does not exist");
            }
            i += 1;
        }
        let mut i = 0;
        while i < self.triggers.len() {
            let ModeTrigger { trigger, mode, .. } = self.triggers[i];
            assert!((mode.0 as usize) < self.modes.len(), "a trigger is in a mode that does not exist");
            assert!((trigger.0 as usize) < triggers, "a trigger that does not exist is in a mode");
            i += 1;
        }
    }
}

impl fmt::Debug for Modes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.modes).finish()
    }
}

/// A mode as the effect of a reaction, with the way in which it is entered: `ctx.set_mode(Two)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transition {
    mode: ModeId,
    history: bool,
}

impl Transition {
    /// Enters the mode as if for the first time: `-> reset(Two)`.
    pub const fn reset(mode: ModeId) -> Self {
        Self { mode, history: false }
    }

    /// Enters the mode as it was left: `-> history(Two)`.
    pub const fn history(mode: ModeId) -> Self {
        Self { mode, history: true }
    }
}

/// The program's parts in its modes.
pub trait ModeCells {
    /// Returns the queue of a trigger in a mode. Timers have none.
    fn in_mode(&mut self, _trigger: TriggerId) -> Option<&mut dyn ModeCell> {
        None
    }

    /// Resets the `reset` state variables in a mode to their initial values.
    fn reset_mode(&mut self, _mode: ModeId) {}
}

/// The engine's interface of the queue of a trigger in a mode.
pub trait ModeCell {
    /// Moves all events: their distance from `to` becomes that from `from`. Returns the tag of the next one.
    fn shift(&mut self, from: Tag, to: Tag) -> Option<Tag>;

    /// Drops all events.
    fn discard(&mut self);

    /// Drops events of other threads that are not in the queue yet.
    fn forget(&mut self) {}
}

/// The engine's state of a mode.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ModeState {
    flags: u8,
    /// The tag at which it became inactive, while it is inactive.
    left: Tag,
}

impl ModeState {
    /// The instance is in this mode, whether or not the instance itself is active.
    const CURRENT: u8 = 1;
    /// It is current, and so are all that contain it.
    const ACTIVE: u8 = 1 << 1;
    /// It has been active, so that its shutdown reactions run.
    const STARTED: u8 = 1 << 2;
    /// Its startup reactions have to run.
    const STARTS: u8 = 1 << 3;
    /// Its reset reactions have to run.
    const RESETS: u8 = 1 << 4;
    /// It is requested by reset.
    const TO_RESET: u8 = 1 << 5;
    /// It is requested by history.
    const TO_HISTORY: u8 = 1 << 6;
    /// It is requested.
    const REQUESTED: u8 = Self::TO_RESET | Self::TO_HISTORY;

    pub(crate) const NONE: Self = Self { flags: 0, left: Tag::NEVER };

    fn has(&self, flag: u8) -> bool {
        self.flags & flag != 0
    }
}

/// Requests a mode from the next microstep on; the last request at a tag counts.
fn request(modes: &[ModeInfo], states: &mut [ModeState], transition: Transition) {
    let wanted = usize::from(transition.mode.0);
    let Some(instance) = modes.get(wanted).map(|mode| mode.instance) else { return };
    for (_, state) in modes.iter().zip(&mut *states).filter(|(mode, _)| mode.instance == instance) {
        state.flags &= !ModeState::REQUESTED;
    }
    states[wanted].flags |= if transition.history { ModeState::TO_HISTORY } else { ModeState::TO_RESET };
}

/// The engine's functions for modes. Only the tables refer to them, so that a program without modes does not carry
/// them.
pub(crate) struct Hooks {
    /// Handles an event of the modes.
    pub(crate) at: fn(&mut Change<'_>, ModeEvent<'_>),
    /// Handles a reaction's request.
    pub(crate) request: fn(&Modes, &mut [ModeState], Transition),
    /// Returns whether a reaction is in no mode, or in an active one; the last tag has its own rule.
    pub(crate) runs: fn(&Modes, &[ModeState], ReactionId, bool) -> bool,
    /// Returns whether a trigger is in no mode, or in an active one.
    pub(crate) is_active: fn(&Modes, &[ModeState], TriggerId) -> bool,
}

/// An event of the modes.
pub(crate) enum ModeEvent<'a> {
    /// The start: the initial modes are active, and the timers of all others wait.
    Start(Tag),
    /// A tag is complete: the requests of its reactions take effect.
    Complete(&'a mut dyn ModeCells),
    /// The next microstep: startup and reset reactions of entered modes are triggered.
    Entry,
}

impl Hooks {
    const ALL: Self = Self {
        at: |change, event| change.at(event),
        request: |modes, states, transition| request(modes.modes, states, transition),
        runs,
        is_active,
    };
}

/// Shutdown reactions also run in modes that are not active any more.
fn runs(modes: &Modes, states: &[ModeState], reaction: ReactionId, is_last: bool) -> bool {
    modes.of_reaction(reaction).is_none_or(|mode| {
        let state = states[usize::from(mode.0)];
        let ends = || is_last && modes.events.shutdown.contains(&reaction);
        state.has(ModeState::ACTIVE) || (state.has(ModeState::STARTED) && ends())
    })
}

fn is_active(modes: &Modes, states: &[ModeState], trigger: TriggerId) -> bool {
    let mut found = modes.triggers.iter().filter(|found| found.trigger == trigger);
    found.all(|found| states[usize::from(found.mode.0)].has(ModeState::ACTIVE))
}

/// A change of modes between tags, and all that it concerns.
pub(crate) struct Change<'a> {
    pub(crate) modes: &'static Modes,
    pub(crate) current: Tag,
    pub(crate) states: &'a mut [ModeState],
    /// The next event of each trigger in a mode when its mode was left. Timers have no other memory for it.
    pub(crate) held: &'a mut [Tag],
    pub(crate) events: Events<'a>,
    pub(crate) ready: Bits<'a>,
}

impl Change<'_> {
    fn has(&self, mode: ModeId, flag: u8) -> bool {
        self.states[usize::from(mode.0)].has(flag)
    }

    fn is_within(&self, parent: Option<ModeId>) -> bool {
        parent.is_none_or(|parent| self.has(parent, ModeState::ACTIVE))
    }

    fn at(&mut self, event: ModeEvent<'_>) {
        match event {
            ModeEvent::Start(first) => self.start(first),
            ModeEvent::Complete(cells) => self.change(cells),
            ModeEvent::Entry => self.enter(),
        }
    }

    fn start(&mut self, first: Tag) {
        for (id, mode) in ids().zip(self.modes.modes) {
            let flags = match (mode.initial, self.is_within(mode.parent)) {
                (false, _) => 0,
                (true, false) => ModeState::CURRENT,
                (true, true) => ModeState::CURRENT | ModeState::ACTIVE | ModeState::STARTED,
            };
            self.states[usize::from(id.0)] = ModeState { flags, left: first };
            if flags & ModeState::ACTIVE == 0 {
                self.leave(id);
            }
        }
    }

    fn change(&mut self, cells: &mut dyn ModeCells) {
        let modes = self.modes.modes;
        if !self.states.iter().any(|state| state.has(ModeState::REQUESTED)) {
            return;
        }
        // Containers come first, so their resets are known here.
        for (id, mode) in ids().zip(modes) {
            if mode.initial && mode.parent.is_some_and(|parent| self.has(parent, ModeState::TO_RESET)) {
                request(modes, self.states, Transition::reset(id));
            }
        }
        for (id, mode) in ids().zip(modes) {
            self.change_one(id, mode, cells);
        }
        for state in &mut *self.states {
            state.flags &= !ModeState::REQUESTED;
        }
        if self.entries().any(|(_, mode, flag)| self.has(mode, flag) && self.has(mode, ModeState::ACTIVE)) {
            self.events.set(self.modes.events.entry, Some(self.current.next_microstep()));
        }
    }

    /// Applies the requests, as far as they concern one mode; the modes that contain it come before.
    fn change_one(&mut self, id: ModeId, mode: &ModeInfo, cells: &mut dyn ModeCells) {
        let mut siblings = self.modes.modes.iter().zip(&*self.states).filter(|(it, _)| it.instance == mode.instance);
        let changes = siblings.any(|(_, state)| state.has(ModeState::REQUESTED));
        let state = self.states[usize::from(id.0)];
        let is_current = state.has(if changes { ModeState::REQUESTED } else { ModeState::CURRENT });
        let is_active = is_current && self.is_within(mode.parent);
        let (was_active, resets) = (state.has(ModeState::ACTIVE), state.has(ModeState::TO_RESET));
        if was_active && (!is_active || resets) {
            self.leave(id);
        }
        if resets {
            self.restart(id, cells);
            cells.reset_mode(id);
        }
        let left = if was_active || resets { self.current } else { state.left };
        if is_active && (!was_active || resets) {
            self.resume(id, left, cells);
        }
        let mut flags = state.flags & !(ModeState::CURRENT | ModeState::ACTIVE);
        let mut set = |flag: u8, is_set: bool| flags = if is_set { flags | flag } else { flags & !flag };
        set(ModeState::CURRENT, is_current);
        set(ModeState::ACTIVE, is_active);
        set(ModeState::RESETS, resets || (state.has(ModeState::RESETS) && !state.has(ModeState::TO_HISTORY)));
        if is_active && !state.has(ModeState::STARTED) {
            set(ModeState::STARTED | ModeState::STARTS, true);
        }
        self.states[usize::from(id.0)] = ModeState { flags, left };
    }

    /// Removes the events of a mode from the event queue.
    fn leave(&mut self, mode: ModeId) {
        for (index, ModeTrigger { trigger, .. }) in self.triggers_of(mode) {
            self.held[index] = self.events.next[usize::from(trigger.0)];
            self.events.set(trigger, None);
        }
    }

    /// Drops the events of a mode, and restarts its timers at this tag.
    fn restart(&mut self, mode: ModeId, cells: &mut dyn ModeCells) {
        for (index, ModeTrigger { trigger, offset, .. }) in self.triggers_of(mode) {
            if let Some(offset) = offset {
                self.held[index] = Tag::at(self.current.time + offset);
            } else if let Some(cell) = cells.in_mode(trigger) {
                cell.discard();
            }
        }
    }

    /// Puts the events of a mode into the event queue: as far from now as they were from the tag at which it was left.
    fn resume(&mut self, mode: ModeId, left: Tag, cells: &mut dyn ModeCells) {
        let now = self.current;
        for (index, ModeTrigger { trigger, offset, .. }) in self.triggers_of(mode) {
            let pending = match offset {
                Some(_) => Some(self.held[index].moved(left, now).max(now.next_microstep())),
                None => cells.in_mode(trigger).and_then(|cell| cell.shift(left, now)),
            };
            self.events.set(trigger, pending);
        }
    }

    fn enter(&mut self) {
        for (reaction, mode, flag) in self.entries() {
            if self.has(mode, flag) && self.has(mode, ModeState::ACTIVE) {
                self.ready.insert(reaction.0);
            }
        }
        for state in self.states.iter_mut().filter(|state| state.has(ModeState::ACTIVE)) {
            state.flags &= !(ModeState::STARTS | ModeState::RESETS);
        }
    }

    /// Returns the startup and reset reactions in modes, each with its mode and with the flag that makes it run.
    fn entries(&self) -> impl Iterator<Item = (ReactionId, ModeId, u8)> + use<> {
        let modes = self.modes;
        let startup = modes.events.startup.iter().map(|reaction| (reaction, ModeState::STARTS));
        let reset = modes.events.reset.iter().map(|reaction| (reaction, ModeState::RESETS));
        startup.chain(reset).filter_map(|(reaction, flag)| Some((*reaction, modes.of_reaction(*reaction)?, flag)))
    }

    fn triggers_of(&self, mode: ModeId) -> impl Iterator<Item = (usize, ModeTrigger)> + use<> {
        self.modes.triggers.iter().copied().enumerate().filter(move |(_, trigger)| trigger.mode == mode)
    }
}

fn ids() -> impl Iterator<Item = ModeId> {
    (0..).map(ModeId)
}
