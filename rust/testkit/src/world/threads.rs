// SPDX-License-Identifier: Apache-2.0
//! Participants on threads of their own, of which one runs at a time: for event loops and testers that block.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use lf_model::time::Interval;
use lf_runtime::trace::Record;

use super::wires::{Conditions, Move, Wires};
use super::{Pace, Shared, Side, Virtual, World, lock};
use crate::network::Medium;
use crate::random::Random;

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
    world: Shared<M>,
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

    fn hand_over(&self) {
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

/// A world whose participants have threads, before or while it runs.
#[derive(Clone, Debug)]
pub struct Threads(Arc<Turns<Wires>>);

impl Threads {
    /// A world without participants.
    pub fn new(conditions: Conditions) -> Self {
        let mut world = World::new(Wires::new(conditions), Random::new(conditions.seed));
        (world.leaves_some, world.keeps_records) = (true, true);
        let state = State { turn: None, fates: Vec::new(), turns_left: TURNS_MAX, trouble: None, hopeless: false };
        let (state, handed_over) = (Mutex::new(state), Condvar::new());
        Self(Arc::new(Turns { world: Shared::new(world), state, handed_over }))
    }

    /// Adds a participant that begins at this virtual time, with a clock that is ahead of the others by `clock_offset`.
    ///
    /// # Panics
    /// If it begins before the world.
    pub fn join(&self, begins: Interval, clock_offset: Interval) -> Virtual {
        let side = Side::keep(clock_offset.as_nanos(), 0);
        let me = self.0.world.lock().join(side, nanos(begins), Pace::INSTANT);
        Virtual::new(self.0.world.clone(), me, Some(Arc::clone(&self.0)))
    }

    /// Something happens to a participant at this virtual time.
    ///
    /// # Panics
    /// If that is before the world.
    pub fn plan(&self, at: Interval, participant: usize, fate: Fate) {
        lock(&self.0.state).fates.push((nanos(at), participant, fate));
    }

    /// Gives the first turn. Each participant's thread begins with [`Virtual::begin`].
    pub fn start(&self) {
        self.0.hand_over();
    }

    /// A participant ends whose platform is not dropped.
    pub fn leave(&self, participant: usize) {
        self.0.leave(participant);
    }

    /// What went wrong, if something did.
    pub fn trouble(&self) -> Option<Trouble> {
        lock(&self.0.state).trouble
    }

    /// What those that accept connections have said and heard, in order.
    pub fn moves(&self) -> Vec<Move> {
        self.0.world.lock().network.medium().moves().to_vec()
    }

    /// What each participant has recorded, in the order in which they have joined.
    pub fn records(&self) -> Vec<Vec<Record>> {
        self.0.world.lock().members.iter().map(|member| member.records.clone()).collect()
    }

    /// Virtual time since the beginning.
    ///
    /// # Panics
    /// After centuries.
    pub fn now(&self) -> Interval {
        Interval::from_nanos(i64::try_from(self.0.world.lock().now()).expect("less than centuries"))
    }
}

fn nanos(interval: Interval) -> u64 {
    u64::try_from(interval.as_nanos()).expect("not before the world")
}
