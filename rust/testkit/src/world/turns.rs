// SPDX-License-Identifier: Apache-2.0
//! The order of turns among participants on threads of their own.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use super::lock::lock;
use super::{Shared, World};
use crate::network::Medium;

/// The number of further turns that participants have to end.
const TURNS_TO_END: u64 = 20_000;

/// A violation of liveness. The world then interrupts all participants.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum LivenessViolation {
    /// All participants wait for events that will never happen.
    Deadlock,
    /// They have run far more often than they can have had reason to.
    Livelock,
}

/// An event that affects a participant from outside.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Fault {
    /// A request to end (^C).
    Interrupt,
    /// The end of the process: its system closes its sockets.
    Kill,
}

/// The order of turns.
#[derive(Debug)]
pub(super) struct Turns<M: Medium> {
    pub(super) world: Shared<M>,
    state: Mutex<State>,
    handed_over: Condvar,
}

#[derive(Debug)]
struct State {
    turn: Option<usize>,
    faults: Vec<(u64, usize, Fault)>,
    turns_left: u64,
    violation: Option<LivenessViolation>,
    /// Whether it did not end even after it was interrupted.
    stuck: bool,
}

impl<M: Medium> Turns<M> {
    /// Returns the state before the first turn, of at most `turns_left`.
    pub(super) fn new(world: World<M>, turns_left: u64) -> Self {
        let state = State { turn: None, faults: Vec::new(), turns_left, violation: None, stuck: false };
        Self { world: Shared::new(world), state: Mutex::new(state), handed_over: Condvar::new() }
    }

    /// Schedules a fault of a participant at this virtual time.
    pub(super) fn plan(&self, at: u64, participant: usize, fault: Fault) {
        lock(&self.state).faults.push((at, participant, fault));
    }

    /// Returns the violation of liveness, if there is one.
    pub(super) fn violation(&self) -> Option<LivenessViolation> {
        lock(&self.state).violation
    }

    /// Ends this turn, and returns at the beginning of the next one.
    pub(super) fn pass(&self, me: usize, until: Option<u64>) {
        self.world.lock().after_turn(me, until);
        self.hand_over();
        self.wait_for(me);
    }

    /// Waits for the turn of this participant.
    pub(super) fn wait_for(&self, me: usize) {
        let waiting = |state: &mut State| state.turn != Some(me) && !state.stuck;
        let state: MutexGuard<'_, State> =
            self.handed_over.wait_while(lock(&self.state), waiting).unwrap_or_else(PoisonError::into_inner);
        assert!(!state.stuck, "participant {me} does not end though it is interrupted: {:?}", state.violation);
    }

    /// Ends the participant: its system closes its sockets, and it gets no further turn.
    pub(super) fn leave(&self, me: usize) {
        if !self.world.lock().has_ended(me) {
            self.world.lock().end(me);
            self.hand_over();
        }
    }

    /// Lets the next participant run.
    pub(super) fn hand_over(&self) {
        lock(&self.state).hand_over(&mut self.world.lock());
        self.handed_over.notify_all();
    }
}

impl State {
    /// Selects the participant with the next turn.
    fn hand_over<M: Medium>(&mut self, world: &mut World<M>) {
        self.turns_left = self.turns_left.saturating_sub(1);
        if self.turns_left == 0 {
            self.give_up(world, LivenessViolation::Livelock);
        }
        loop {
            let next_fault = self.faults.iter().map(|(at, ..)| *at).min();
            self.turn = world.next_turn(next_fault);
            if self.turn.is_some() || world.left() == 0 || self.stuck {
                return;
            }
            match next_fault {
                Some(at) => self.apply_faults(world, at),
                None => self.give_up(world, LivenessViolation::Deadlock),
            }
        }
    }

    fn give_up<M: Medium>(&mut self, world: &mut World<M>, violation: LivenessViolation) {
        self.stuck = self.violation.is_some();
        self.violation.get_or_insert(violation);
        self.turns_left = TURNS_TO_END;
        (0..world.members.len()).for_each(|participant| world.interrupt(participant));
    }

    fn apply_faults<M: Medium>(&mut self, world: &mut World<M>, now: u64) {
        world.advance_to(now);
        for (_, participant, fault) in self.faults.extract_if(.., |(at, ..)| *at <= now) {
            if fault == Fault::Kill {
                world.switch_off(participant);
            }
            world.interrupt(participant);
        }
    }
}
