// SPDX-License-Identifier: Apache-2.0
//! The reference model, and what it shares with the program that the engine runs.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "small numbers"
)]

pub(crate) mod program;

use std::collections::{BTreeMap, BTreeSet};

use lf_testkit::random::{Random, combine};

pub(crate) const TIMERS: usize = 3;
pub(crate) const ACTIONS: usize = 4;
/// Each port has a delayed connection to a port of its own.
pub(crate) const PORTS: usize = 3;
pub(crate) const INPUTS: usize = 4;
pub(crate) const ACTION_CAPACITY: usize = 6;
pub(crate) const QUEUE_CAPACITY: usize = 3;
pub(crate) const START: i64 = 1_000_000;

/// Time after the start and microstep.
pub(crate) type TagPair = (i64, u32);

#[derive(Clone, Debug)]
pub(crate) struct ActionPlan {
    pub min_delay: i64,
    pub spacing: Option<i64>,
    /// Defer, drop, replace, update.
    pub policy: usize,
}

#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub seed: u64,
    /// Offset and period.
    pub timers: Vec<(i64, i64)>,
    pub actions: Vec<ActionPlan>,
    /// By port, the delay of its connection.
    pub delays: Vec<i64>,
    /// Input, tag, value; delivered before the start.
    pub messages: Vec<(usize, TagPair, u32)>,
    pub timeout: Option<i64>,
}

/// A reaction that ran: at this tag, with this number, seeing this value.
pub(crate) type Step = (TagPair, usize, Option<u32>);

/// A message to other federates at this tag, of this port: a value, or its absence.
pub(crate) type NetworkMessage = (TagPair, usize, Option<u32>);

#[derive(Debug, PartialEq)]
pub(crate) struct Outcome {
    pub trace: Vec<Step>,
    pub told: Vec<NetworkMessage>,
    /// By message, whether the queue was full.
    pub full: Vec<bool>,
    pub failed: bool,
    pub done: bool,
}

pub(crate) enum Effect {
    Schedule { action: usize, offset: i64, value: Option<u32> },
    Set { port: usize, value: u32 },
    Stop,
}

/// Reactions in order of execution: startup, timers, actions, inputs, ports' delayed ends, ports, shutdown; then each
/// port is sent to another federate.
pub(crate) const AT_TIMERS: usize = 1;
pub(crate) const AT_ACTIONS: usize = AT_TIMERS + TIMERS;
pub(crate) const AT_INPUTS: usize = AT_ACTIONS + ACTIONS;
pub(crate) const AT_DELAYED: usize = AT_INPUTS + INPUTS;
pub(crate) const AT_PORTS: usize = AT_DELAYED + PORTS;
pub(crate) const SHUTDOWN: usize = AT_PORTS + PORTS;
pub(crate) const AT_SENDS: usize = SHUTDOWN + 1;

/// Returns the effects of a reaction at a tag, chosen by the seed.
pub(crate) fn effects(seed: u64, tag: TagPair, reaction: usize) -> Vec<Effect> {
    let place = combine(tag.0 as u64, combine(tag.1.into(), reaction as u64));
    let mut random = Random::new(combine(seed, place));
    let mut pick = move |below: u64| random.below(below);
    let mut effects = Vec::new();
    for _ in 0..pick(3) {
        if pick(2) == 0 {
            let value = (pick(3) > 0).then(|| pick(1000) as u32);
            effects.push(Effect::Schedule { action: pick(ACTIONS as u64) as usize, offset: pick(5) as i64, value });
        } else {
            // Ports feed later ports only, so that there is no cycle.
            let first = reaction.saturating_sub(AT_PORTS - 1);
            if first < PORTS {
                let port = first + pick((PORTS - first) as u64) as usize;
                effects.push(Effect::Set { port, value: pick(1000) as u32 });
            }
        }
    }
    if pick(150) == 0 {
        effects.push(Effect::Stop);
    }
    effects
}

#[derive(Default)]
struct Action {
    pending: BTreeMap<TagPair, Option<u32>>,
    /// The tags after the stop, which will not happen.
    beyond: BTreeSet<TagPair>,
    last: Option<TagPair>,
    happened: Option<TagPair>,
}

struct Reference<'a> {
    plan: &'a Plan,
    now: TagPair,
    stop: TagPair,
    timers: Vec<Option<TagPair>>,
    actions: Vec<Action>,
    inputs: Vec<BTreeMap<TagPair, u32>>,
    delayed: Vec<BTreeMap<TagPair, u32>>,
    outcome: Outcome,
}

const FOREVER: TagPair = (i64::MAX, u32::MAX);

pub(crate) fn run(plan: &Plan, tags_max: usize) -> Outcome {
    let mut reference = Reference {
        plan,
        now: (-1, u32::MAX),
        stop: plan.timeout.map_or(FOREVER, |timeout| (timeout, 0)),
        timers: plan.timers.iter().map(|&(offset, _)| Some((offset, 0))).collect(),
        actions: (0..ACTIONS).map(|_| Action::default()).collect(),
        inputs: vec![BTreeMap::new(); INPUTS],
        delayed: vec![BTreeMap::new(); PORTS],
        outcome: Outcome { trace: Vec::new(), told: Vec::new(), full: Vec::new(), failed: false, done: false },
    };
    for &(input, tag, value) in &plan.messages {
        let full = tag <= reference.stop && !insert(&mut reference.inputs[input], tag, value, QUEUE_CAPACITY);
        reference.outcome.full.push(full);
    }
    for _ in 0..tags_max {
        // Nothing happens any more, and no stop is set.
        if reference.outcome.done || reference.next_tag().0 == i64::MAX {
            break;
        }
        reference.step();
    }
    reference.outcome
}

/// Puts a value at the first free microstep from `tag` on, unless the queue is full.
fn insert<T>(queue: &mut BTreeMap<TagPair, T>, mut tag: TagPair, value: T, capacity: usize) -> bool {
    while queue.contains_key(&tag) {
        tag.1 += 1;
    }
    let room = queue.len() < capacity;
    if room {
        queue.insert(tag, value);
    }
    room
}

impl Reference<'_> {
    fn next_tag(&self) -> TagPair {
        let startup = (self.now < (0, 0)).then_some((0, 0));
        let timers = self.timers.iter().flatten().copied();
        let actions = self.actions.iter().filter_map(|action| Some(*action.pending.first_key_value()?.0));
        let queues = self.inputs.iter().chain(&self.delayed).filter_map(|queue| Some(*queue.first_key_value()?.0));
        startup.into_iter().chain(timers).chain(actions).chain(queues).chain([self.stop]).min().unwrap()
    }

    fn step(&mut self) {
        self.now = self.next_tag();
        let now = self.now;
        let mut ready: BTreeMap<usize, Option<u32>> = BTreeMap::new();
        let mut ports = [None; PORTS];
        if now == (0, 0) {
            ready.insert(0, None);
        }
        for (index, timer) in self.timers.iter_mut().enumerate() {
            if *timer == Some(now) {
                ready.insert(AT_TIMERS + index, Some(1));
                let period = self.plan.timers[index].1;
                *timer = (period > 0).then_some((now.0 + period, 0));
            }
        }
        for (index, action) in self.actions.iter_mut().enumerate() {
            if let Some(value) = action.pending.remove(&now) {
                ready.insert(AT_ACTIONS + index, value);
                action.happened = Some(now);
            }
        }
        for (index, queue) in self.inputs.iter_mut().enumerate() {
            ready.extend(queue.remove(&now).map(|value| (AT_INPUTS + index, Some(value))));
        }
        for (index, queue) in self.delayed.iter_mut().enumerate() {
            ready.extend(queue.remove(&now).map(|value| (AT_DELAYED + index, Some(value))));
        }
        if now == self.stop {
            ready.insert(SHUTDOWN, None);
        }
        while let Some((reaction, value)) = ready.pop_first() {
            self.outcome.trace.push((now, reaction, value));
            for effect in effects(self.plan.seed, now, reaction) {
                match effect {
                    Effect::Schedule { action, offset, value } => self.schedule(action, offset, value),
                    Effect::Set { port, value } => {
                        ports[port] = Some(value);
                        ready.insert(AT_PORTS + port, Some(value));
                    }
                    Effect::Stop => self.stop = self.stop.min((now.0, now.1 + 1)),
                }
            }
            if self.outcome.failed {
                break;
            }
        }
        if !self.outcome.failed {
            self.outcome.told.extend(ports.iter().enumerate().map(|(index, value)| (now, index, *value)));
        }
        for (index, value) in ports.into_iter().enumerate() {
            let tag = self.delay(self.plan.delays[index]);
            if let Some(value) = value
                && tag <= self.stop
                && !insert(&mut self.delayed[index], tag, value, QUEUE_CAPACITY)
            {
                self.outcome.failed = true;
            }
        }
        self.outcome.done = self.outcome.failed || now == self.stop;
    }

    fn delay(&self, delay: i64) -> TagPair {
        // Before the start the microstep is the last one there is.
        if delay == 0 { (self.now.0, self.now.1.wrapping_add(1)) } else { (self.now.0.saturating_add(delay), 0) }
    }

    fn schedule(&mut self, index: usize, offset: i64, value: Option<u32>) {
        let plan = &self.plan.actions[index];
        let mut tag = self.delay(plan.min_delay + offset);
        let action = &mut self.actions[index];
        if let (Some(spacing), Some(last)) = (plan.spacing, action.last) {
            // The first tag that keeps the spacing to an event at `before`.
            let spaced =
                |before: TagPair| if spacing == 0 { (before.0, before.1 + 1) } else { (before.0 + spacing, 0) };
            let close = |before: TagPair| {
                if spacing == 0 { before.0 >= tag.0 } else { before.0 + spacing > tag.0 }
            };
            if close(last) {
                match plan.policy {
                    1 => return,
                    2 if action.pending.contains_key(&last) => {
                        action.pending.insert(last, value);
                        return;
                    }
                    3 => {
                        action.pending.remove(&last);
                        action.beyond.remove(&last);
                        let latest = action.pending.keys().chain(&action.beyond).max().copied();
                        if let Some(before) = latest.max(action.happened)
                            && close(before)
                        {
                            tag = tag.max(spaced(before));
                        }
                    }
                    _ => tag = tag.max(spaced(last)),
                }
            }
        }
        if plan.spacing.is_none()
            && let Some(pending) = action.pending.get_mut(&tag)
        {
            match plan.policy {
                1 => return,
                2 => {
                    *pending = value;
                    return;
                }
                _ => {}
            }
        }
        if tag > self.stop {
            action.beyond.insert(tag);
            action.last = Some(tag);
            return;
        }
        if action.pending.len() == ACTION_CAPACITY {
            self.outcome.failed = true;
            return;
        }
        while action.pending.contains_key(&tag) {
            tag.1 += 1;
        }
        action.pending.insert(tag, value);
        action.last = Some(tag);
    }
}
