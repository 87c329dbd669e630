// SPDX-License-Identifier: Apache-2.0
//! Virtual time, the network in it, and whose turn is next.

mod cables;
mod platform;
mod side;

use std::cell::RefCell;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::rc::Rc;

pub(crate) use lf_testkit::network::address_of;
use lf_testkit::random::Random;

pub(crate) use cables::Cables;
pub(crate) use platform::Virtual;
pub(crate) use side::{Side, Thread};

use crate::scenario::{Conditions, FaultKind};

pub(crate) type Network = lf_testkit::network::Network<Cables>;

/// Whose turn comes when.
pub(crate) struct World {
    pub(crate) network: Rc<RefCell<Network>>,
    pub(crate) interrupted: Rc<RefCell<Vec<bool>>>,
    pub(crate) sides: Vec<&'static Side>,
    random: Random,
    conditions: Conditions,
    /// Time, a number that decides between equals, and the participant.
    queue: BinaryHeap<Reverse<(u64, u64, usize)>>,
    /// When each participant's next turn is; nothing when it waits for ever or has ended.
    next: Vec<Option<u64>>,
    ended: Vec<bool>,
    pub(crate) now: u64,
}

impl World {
    pub(crate) fn new(conditions: &Conditions, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let hosts = &conditions.hosts;
        let sides: Vec<_> = hosts.iter().map(|host| Side::keep(host.clock_offset, host.clock_drift_ppb)).collect();
        let network = Network::new(Cables::new(conditions, sides.clone(), random.number()));
        let mut world = Self {
            network: Rc::new(RefCell::new(network)),
            interrupted: Rc::new(RefCell::new(vec![false; hosts.len()])),
            sides,
            random,
            conditions: conditions.clone(),
            queue: BinaryHeap::new(),
            next: vec![None; hosts.len()],
            ended: vec![false; hosts.len()],
            now: 0,
        };
        for (participant, host) in hosts.iter().enumerate() {
            world.network.borrow_mut().join();
            world.schedule(participant, u64::try_from(host.begins).unwrap_or(0));
        }
        world
    }

    pub(crate) fn platform(&self, me: usize) -> Virtual {
        let (network, interrupted) = (Rc::clone(&self.network), Rc::clone(&self.interrupted));
        Virtual { network, me, side: self.sides[me], interrupted }
    }

    /// How many reactions have run, of all participants.
    pub(crate) fn reactions(&self) -> u64 {
        self.sides.iter().map(|side| side.reactions()).sum()
    }

    /// How many turns datagrams can account for.
    pub(crate) fn datagram_turns(&self) -> u64 {
        self.network.borrow().medium().datagram_turns
    }

    /// The participant has something to do at this time, or when it is through with what it does.
    pub(crate) fn schedule(&mut self, participant: usize, at: u64) {
        if self.ended[participant] {
            return;
        }
        let wake_ns = self.conditions.hosts[participant].wake_ns;
        let late = u64::try_from(self.random.time(0, wake_ns)).unwrap_or(0);
        let at = at.max(self.sides[participant].now()).max(self.now) + late;
        if self.next[participant].is_none_or(|next| at < next) {
            self.next[participant] = Some(at);
            self.queue.push(Reverse((at, self.random.number(), participant)));
        }
    }

    /// The participant whose turn is next, not after `limit`. Its time goes on to that.
    pub(crate) fn next_turn(&mut self, limit: Option<u64>) -> Option<usize> {
        loop {
            let Reverse((at, _, participant)) = *self.queue.peek()?;
            if self.next[participant] != Some(at) {
                self.queue.pop();
                continue;
            }
            if limit.is_some_and(|limit| limit < at) {
                return None;
            }
            self.queue.pop();
            self.next[participant] = None;
            self.now = at;
            let side = self.sides[participant];
            side.advance_to(at);
            let turn_ns = self.random.time(100, self.conditions.hosts[participant].turn_ns);
            side.compute(u64::try_from(turn_ns).unwrap_or(0));
            return Some(participant);
        }
    }

    /// A turn has ended, and the participant waits until this virtual time, for its sockets, and for its threads.
    pub(crate) fn after_turn(&mut self, participant: usize, until: Option<u64>) {
        let side = self.sides[participant];
        let woken = side.take_woken().then(|| side.now());
        let ready = self.network.borrow().next_ready(participant);
        if let Some(at) = [until, woken, ready, side.next_act()].into_iter().flatten().min() {
            self.schedule(participant, at);
        }
        self.pass_on();
    }

    /// Those to whom something was sent have something to do.
    pub(crate) fn pass_on(&mut self) {
        let wakes = std::mem::take(&mut self.network.borrow_mut().medium_mut().wakes);
        for (participant, at) in wakes {
            self.schedule(participant, at);
        }
    }

    /// The participant has ended, or is no more: its system closes its sockets.
    pub(crate) fn end(&mut self, participant: usize) {
        self.ended[participant] = true;
        self.next[participant] = None;
        self.sides[participant].end();
        let now = self.sides[participant].now();
        self.network.borrow_mut().switch_off(participant, now.max(self.now));
        self.pass_on();
    }

    pub(crate) fn has_ended(&self, participant: usize) -> bool {
        self.ended[participant]
    }

    /// Something goes wrong, at this virtual time.
    pub(crate) fn strike(&mut self, participant: usize, kind: FaultKind, at: u64) {
        self.now = self.now.max(at);
        match kind {
            FaultKind::Vanish => self.end(participant),
            FaultKind::Break => self.network.borrow_mut().break_all(participant, self.now),
            FaultKind::Interrupt => {
                self.interrupted.borrow_mut()[participant] = true;
                self.schedule(participant, self.now);
            }
        }
        self.pass_on();
    }
}
