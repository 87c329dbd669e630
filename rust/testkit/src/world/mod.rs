// SPDX-License-Identifier: Apache-2.0
//! A virtual world: participants with clocks, the network between them, virtual time, and the order of turns.
//!
//! Virtual time stands still during a participant's turn, and then advances to the earliest time at which a participant
//! has a reason to run. A participant's own time runs ahead while it computes. So a run follows from its seed alone,
//! and takes no longer than its work.
//!
//! A driver asks [`World::next_turn`] and reports with [`World::after_turn`]: one loop that calls the participants'
//! event loops, or [`Threads`], where each participant blocks in `wait` of its platform.

mod blocking;
mod lock;
mod platform;
mod side;
mod threads;
mod turns;
mod wires;

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::{Arc, Mutex, MutexGuard};

use lf_runtime::trace::Record;

use crate::network::{Medium, Network};
use crate::random::Random;
use lock::lock;

pub use blocking::Blocking;
pub use platform::Virtual;
pub use side::{Side, Thread};
pub use threads::Threads;
pub use turns::{Fault, LivenessViolation};
pub use wires::{Conditions, Move, Wires};

/// The speed of a participant's computer, in nanoseconds.
#[derive(Clone, Copy, Debug)]
pub struct ComputerSpeed {
    /// The shortest and the longest duration of a turn of the event loop.
    pub turn_ns: (i64, i64),
    /// The longest delay of a wake-up.
    pub wake_ns: i64,
}

impl ComputerSpeed {
    /// A computer on which nothing takes time.
    pub const INSTANT: Self = Self { turn_ns: (0, 0), wake_ns: 0 };
}

/// One participant, as the world knows it.
#[derive(Debug)]
struct Member {
    side: &'static Side,
    speed: ComputerSpeed,
    /// The time of its next turn; `None` while it waits without end or after it has ended.
    next: Option<u64>,
    ended: bool,
    interrupted: bool,
    records: Vec<Record>,
}

/// Participants, their network, and virtual time.
#[derive(Debug)]
pub struct World<M> {
    /// The network between them.
    pub network: Network<M>,
    members: Vec<Member>,
    random: Random,
    /// Time, a number that breaks ties, and the participant.
    queue: BinaryHeap<Reverse<(u64, u64, usize)>>,
    now: u64,
    /// Whether a wait may leave some ready sockets for the next one.
    leaves_some: bool,
}

impl<M: Medium> World<M> {
    /// Returns a world without participants, in which `random` decides all open choices.
    pub fn new(medium: M, random: Random) -> Self {
        Self {
            network: Network::new(medium),
            members: Vec::new(),
            random,
            queue: BinaryHeap::new(),
            now: 0,
            leaves_some: false,
        }
    }

    /// Adds a participant that begins at this virtual time, and returns its number.
    pub fn join(&mut self, side: &'static Side, begins: u64, speed: ComputerSpeed) -> usize {
        let participant = self.add(side, speed);
        self.schedule(participant, begins);
        participant
    }

    /// Adds a participant that begins when it is [scheduled](Self::schedule), and returns its number.
    pub fn add(&mut self, side: &'static Side, speed: ComputerSpeed) -> usize {
        let participant = self.network.join();
        let (next, ended, interrupted) = (None, false, false);
        self.members.push(Member { side, speed, next, ended, interrupted, records: Vec::new() });
        participant
    }

    /// Returns the virtual time.
    pub fn now(&self) -> u64 {
        self.now
    }

    /// Returns the state that a participant shares with its threads.
    pub fn side(&self, participant: usize) -> &'static Side {
        self.members[participant].side
    }

    /// Returns the number of reactions that have run, of all participants.
    pub fn reactions(&self) -> u64 {
        self.members.iter().map(|member| member.side.reactions()).sum()
    }

    /// Schedules a turn of the participant at this time, or at the end of its current one.
    pub fn schedule(&mut self, participant: usize, at: u64) {
        let member = &mut self.members[participant];
        if member.ended {
            return;
        }
        let late = u64::try_from(self.random.time(0, member.speed.wake_ns)).unwrap_or(0);
        let at = at.max(member.side.now()).max(self.now) + late;
        if member.next.is_none_or(|next| at < next) {
            member.next = Some(at);
            self.queue.push(Reverse((at, self.random.number(), participant)));
        }
    }

    /// Returns the next participant to run, not after `limit`, and advances its time.
    pub fn next_turn(&mut self, limit: Option<u64>) -> Option<usize> {
        loop {
            let Reverse((at, _, participant)) = *self.queue.peek()?;
            let member = &mut self.members[participant];
            if member.next != Some(at) {
                self.queue.pop();
                continue;
            }
            if limit.is_some_and(|limit| limit < at) {
                return None;
            }
            self.queue.pop();
            member.next = None;
            self.now = at;
            member.side.advance_to(at);
            let (least, most) = member.speed.turn_ns;
            member.side.compute(u64::try_from(self.random.time(least, most)).unwrap_or(0));
            return Some(participant);
        }
    }

    /// Ends a turn: the participant waits until this virtual time, for its sockets, and for its threads.
    pub fn after_turn(&mut self, participant: usize, until: Option<u64>) {
        let side = self.side(participant);
        let woken = side.take_woken().then(|| side.now());
        let ready = self.network.next_ready(participant);
        if let Some(at) = [until, woken, ready, side.next_act()].into_iter().flatten().min() {
            self.schedule(participant, at);
        }
        self.pass_on();
    }

    /// Schedules the participants for which input has been sent.
    fn pass_on(&mut self) {
        for (participant, at) in self.network.take_wakes() {
            self.schedule(participant, at);
        }
    }

    /// Ends a participant: its system closes its sockets.
    pub fn end(&mut self, participant: usize) {
        self.members[participant].ended = true;
        self.members[participant].next = None;
        self.side(participant).end();
        self.switch_off(participant);
    }

    /// Returns whether a participant has ended.
    pub fn has_ended(&self, participant: usize) -> bool {
        self.members[participant].ended
    }

    /// Returns the number of participants that have not ended.
    pub fn left(&self) -> usize {
        self.members.iter().filter(|member| !member.ended).count()
    }

    fn switch_off(&mut self, participant: usize) {
        let now = self.side(participant).now().max(self.now);
        self.network.switch_off(participant, now);
        self.pass_on();
    }

    /// Advances virtual time to this time, if it is later, for an event outside all turns.
    pub fn advance_to(&mut self, at: u64) {
        self.now = self.now.max(at);
    }

    /// Breaks all connections of a participant.
    pub fn break_connections(&mut self, participant: usize) {
        self.network.break_all(participant, self.now);
        self.pass_on();
    }

    /// Asks a participant to end.
    pub fn interrupt(&mut self, participant: usize) {
        self.members[participant].interrupted = true;
        self.schedule(participant, self.now);
    }
}

/// A world that its participants share with their driver.
#[derive(Debug)]
pub struct Shared<M>(Arc<Mutex<World<M>>>);

impl<M> Clone for Shared<M> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<M: Medium> Shared<M> {
    /// Shares a world.
    pub fn new(world: World<M>) -> Self {
        Self(Arc::new(Mutex::new(world)))
    }

    /// Locks the world.
    pub fn lock(&self) -> MutexGuard<'_, World<M>> {
        lock(&self.0)
    }
}
