// SPDX-License-Identifier: Apache-2.0
//! Participants on threads of their own, of which one runs at a time: for event loops and testers that block.

use std::sync::Arc;

use lf_model::time::Interval;
use lf_runtime::trace::Record;

use super::turns::{Fault, Trouble, Turns};
use super::wires::{Conditions, Move, Wires};
use super::{Pace, Side, Virtual, World};
use crate::random::Random;

/// A world whose participants have threads, before or while it runs.
#[derive(Clone, Debug)]
pub struct Threads(Arc<Turns<Wires>>);

impl Threads {
    /// Returns a world without participants.
    pub fn new(conditions: Conditions) -> Self {
        let mut world = World::new(Wires::new(conditions), Random::new(conditions.seed));
        world.leaves_some = true;
        Self(Arc::new(Turns::new(world)))
    }

    /// Adds a participant that begins at this virtual time, with a clock that is ahead of the others by `clock_offset`.
    ///
    /// # Panics
    /// If it would begin in the past.
    pub fn join(&self, begins: Interval, clock_offset: Interval) -> Virtual {
        let side = Side::keep(clock_offset.as_nanos(), 0);
        let me = self.0.world.lock().join(side, nanos(begins), Pace::INSTANT);
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

    /// Returns the failure of the world, if there is one.
    pub fn trouble(&self) -> Option<Trouble> {
        self.0.trouble()
    }

    /// Returns the writes and reads of the accepting sides, in order.
    pub fn moves(&self) -> Vec<Move> {
        self.0.world.lock().network.medium().moves().to_vec()
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
