// SPDX-License-Identifier: Apache-2.0
//! Participants on threads of their own, of which one runs at a time: for event loops and testers that block.

use std::sync::Arc;

use lf_model::time::Interval;
use lf_runtime::trace::Record;

use super::turns::{Fault, LivenessViolation, Turns};
use super::wires::{Conditions, Move, Wires};
use super::{ComputerSpeed, Side, Virtual, World};
use crate::network::Medium;
use crate::random::Random;

/// The number of turns above that of any test.
const TURNS_MAX: u64 = 60_000;

/// A world whose participants have threads, before or while it runs.
#[derive(Debug)]
pub struct Threads<M: Medium = Wires>(Arc<Turns<M>>);

impl<M: Medium> Clone for Threads<M> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl Threads {
    /// Returns a world without participants, for a test.
    pub fn new(conditions: Conditions) -> Self {
        Self::of(Wires::new(conditions), Random::new(conditions.seed), TURNS_MAX)
    }

    /// Adds a participant that begins at this virtual time, with a clock that is ahead of the others by `clock_offset`.
    ///
    /// # Panics
    /// If it would begin in the past.
    pub fn join(&self, begins: Interval, clock_offset: Interval) -> Virtual {
        self.add(begins, Side::keep(clock_offset.as_nanos(), 0), ComputerSpeed::INSTANT)
    }

    /// Returns the writes and reads of the accepting sides, in order.
    pub fn moves(&self) -> Vec<Move> {
        self.0.world.lock().network.medium().moves().to_vec()
    }
}

impl<M: Medium> Threads<M> {
    /// Returns a world without participants, in which `random` decides all open choices, and which reports a livelock
    /// after that number of turns.
    pub fn of(medium: M, random: Random, turns_max: u64) -> Self {
        let mut world = World::new(medium, random);
        world.leaves_some = true;
        Self(Arc::new(Turns::new(world, turns_max)))
    }

    /// Adds a participant that begins at this virtual time.
    ///
    /// # Panics
    /// If it would begin in the past.
    pub fn add(&self, begins: Interval, side: &'static Side, speed: ComputerSpeed) -> Virtual<M> {
        let me = self.0.world.lock().join(side, nanos(begins), speed);
        Virtual::new(self.0.world.clone(), me, Some(Arc::clone(&self.0)))
    }

    /// Schedules a fault of a participant at this virtual time.
    ///
    /// # Panics
    /// If that time is past.
    pub fn plan(&self, at: Interval, participant: usize, fault: Fault) {
        self.0.plan(nanos(at), participant, fault);
    }

    /// Starts the first turn. Each participant's thread begins with [`Virtual::begin`].
    pub fn start(&self) {
        self.0.hand_over();
    }

    /// Ends a participant whose platform is not dropped.
    pub fn leave(&self, participant: usize) {
        self.0.leave(participant);
    }

    /// Returns the violation of liveness, if there is one.
    pub fn violation(&self) -> Option<LivenessViolation> {
        self.0.violation()
    }

    /// Returns the records of each participant, in the order in which they have joined.
    pub fn records(&self) -> Vec<Vec<Record>> {
        self.0.world.lock().members.iter().map(|member| member.records.clone()).collect()
    }

    /// Returns the virtual time since the beginning.
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
