// SPDX-License-Identifier: Apache-2.0
//! Whose turn it is among participants on threads of their own.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use super::{Shared, World, lock};
use crate::network::Medium;

/// How many turns no run of a test needs, and how many it gets to end after that.
const TURNS_MAX: u64 = 60_000;
const TURNS_TO_END: u64 = 20_000;

/// What goes wrong with a world as a whole, which then interrupts everybody.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Trouble {
    /// All wait for something that will never come.
    Stuck,
    /// They have run far more often than they can have had reason to.
    Busy,
}

/// Something that happens to a participant from outside.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Fate {
    /// Somebody asks it to end (^C).
    Interrupt,
    /// It is no more: its system closes its sockets.
    Kill,
}

/// Whose turn it is.
#[derive(Debug)]
pub(super) struct Turns<M: Medium> {
    pub(super) world: Shared<M>,
    state: Mutex<State>,
    handed_over: Condvar,
}

#[derive(Debug)]
struct State {
    turn: Option<usize>,
    fates: Vec<(u64, usize, Fate)>,
    turns_left: u64,
    trouble: Option<Trouble>,
    /// It did not even end after it was interrupted.
    hopeless: bool,
}

impl<M: Medium> Turns<M> {
    /// It is nobody's turn yet.
    pub(super) fn new(world: World<M>) -> Self {
        let state = State { turn: None, fates: Vec::new(), turns_left: TURNS_MAX, trouble: None, hopeless: false };
        Self { world: Shared::new(world), state: Mutex::new(state), handed_over: Condvar::new() }
    }

    /// Something happens to a participant at this virtual time.
    pub(super) fn plan(&self, at: u64, participant: usize, fate: Fate) {
        lock(&self.state).fates.push((at, participant, fate));
    }

    /// What went wrong, if something did.
    pub(super) fn trouble(&self) -> Option<Trouble> {
        lock(&self.state).trouble
    }

    /// Hands the turn on, and returns with the next one.
    pub(super) fn pass(&self, me: usize, until: Option<u64>) {
        self.world.lock().after_turn(me, until);
        self.hand_over();
        self.wait_for(me);
    }

    /// Waits for the turn of this participant.
    pub(super) fn wait_for(&self, me: usize) {
        let waiting = |state: &mut State| state.turn != Some(me) && !state.hopeless;
        let state: MutexGuard<'_, State> =
            self.handed_over.wait_while(lock(&self.state), waiting).unwrap_or_else(PoisonError::into_inner);
        assert!(!state.hopeless, "participant {me} does not end though it is interrupted: {:?}", state.trouble);
    }

    /// The participant ends: its system closes its sockets, and it gets no further turn.
    pub(super) fn leave(&self, me: usize) {
        if !self.world.lock().has_ended(me) {
            self.world.lock().end(me);
            self.hand_over();
        }
    }

    /// Lets the next participant go on.
    pub(super) fn hand_over(&self) {
        lock(&self.state).hand_over(&mut self.world.lock());
        self.handed_over.notify_all();
    }
}

impl State {
    /// Says whose turn is next.
    fn hand_over<M: Medium>(&mut self, world: &mut World<M>) {
        self.turns_left = self.turns_left.saturating_sub(1);
        if self.turns_left == 0 {
            self.give_up(world, Trouble::Busy);
        }
        loop {
            let next_fate = self.fates.iter().map(|(at, ..)| *at).min();
            self.turn = world.next_turn(next_fate);
            if self.turn.is_some() || world.left() == 0 || self.hopeless {
                return;
            }
            match next_fate {
                Some(at) => self.apply_fates(world, at),
                None => self.give_up(world, Trouble::Stuck),
            }
        }
    }

    fn give_up<M: Medium>(&mut self, world: &mut World<M>, trouble: Trouble) {
        self.hopeless = self.trouble.is_some();
        self.trouble.get_or_insert(trouble);
        self.turns_left = TURNS_TO_END;
        (0..world.members.len()).for_each(|participant| world.interrupt(participant));
    }

    fn apply_fates<M: Medium>(&mut self, world: &mut World<M>, now: u64) {
        world.advance_to(now);
        for (_, participant, fate) in self.fates.extract_if(.., |(at, ..)| *at <= now) {
            if fate == Fate::Kill {
                world.switch_off(participant);
            }
            world.interrupt(participant);
        }
    }
}
