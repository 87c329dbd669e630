// SPDX-License-Identifier: Apache-2.0
//! Federates that come and go: the scenario of a seed, in which some federates are transient, and instances of them
//! begin, stop, vanish and lose their connections at any moment, also while an earlier instance runs.
//!
//! All of it is drawn by a generator of its own, after everything else.

use lf_testkit::random::{Random, combine};

use super::{Fault, FaultKind, MS, Nanos, Reactor, SEC, Scenario};

/// The maximum number of events from outside per federate.
const MOMENTS_MAX: usize = 6;

impl Scenario {
    /// Returns whether federates come and go.
    pub(crate) fn has_transients(&self) -> bool {
        self.federates.iter().any(|federate| federate.transient)
    }

    /// Returns whether an instance is one of a transient federate.
    pub(crate) fn is_transient(&self, instance: usize) -> bool {
        self.federates[self.instances[instance]].transient
    }

    /// Returns the instances of a federate, in the order in which they begin.
    pub(crate) fn instances_of(&self, federate: usize) -> impl Iterator<Item = usize> {
        self.instances.iter().enumerate().filter(move |(_, of)| **of == federate).map(|(instance, _)| instance)
    }

    /// Returns whether an instance begins at a moment of its own, not with the world.
    pub(crate) fn begins_later(&self, instance: usize) -> bool {
        self.faults.iter().any(|fault| fault.kind == FaultKind::Begin && fault.participant == instance + 1)
    }

    /// Lets some federates come and go.
    pub(crate) fn come_and_go(&mut self) {
        let random = &mut Random::new(combine(self.seed, 31));
        let count = self.federates.len();
        let persistent = random.index(count);
        let wanted = random.one_of(&[20, 50, 100]);
        for (index, federate) in self.federates.iter_mut().enumerate() {
            federate.transient = index != persistent && random.percent(wanted);
        }
        if !self.has_transients() {
            self.federates[(persistent + 1) % count].transient = true;
        }
        self.last_long(random);
        for federate in 0..count {
            if self.federates[federate].transient {
                self.plan_incarnations(federate, random);
            }
        }
        let random = &mut Random::new(combine(self.seed, 37));
        for federate in self.federates.iter_mut().filter(|federate| federate.transient) {
            federate.hands_over = random.percent(50);
        }
    }

    /// Ends the federation by a timeout, and makes it long enough for some to come while it runs: with decentralized
    /// coordination, one with inputs begins a second after it has come.
    fn last_long(&mut self, random: &mut Random) {
        let timeout = self.target.timeout.unwrap_or(20 * MS).max(1);
        let wanted = match self.decentralized {
            Some(_) => random.one_of(&[SEC, 2 * SEC, 3 * SEC]),
            None => random.one_of(&[0, 50 * MS, 400 * MS, 2 * SEC]),
        };
        let factor = (wanted / timeout).max(1);
        self.target.timeout = Some(timeout * factor);
        for federate in &mut self.federates {
            federate.scale(factor);
        }
    }

    /// Draws the moments at which instances of a federate begin and end.
    fn plan_incarnations(&mut self, federate: usize, random: &mut Random) {
        let length = self.target.timeout.unwrap_or(0);
        let mut moments: Vec<_> = (0..random.count(1, MOMENTS_MAX)).map(|_| moment(random, length)).collect();
        moments.sort_by_key(|(at, early)| (!early, *at));
        // The participant of the last instance, and whether it runs as far as is known.
        let (mut last, mut runs) = (federate + 1, random.percent(50));
        let mut has_begun = runs;
        for (at, early) in moments {
            let kind = if runs && random.percent(60) {
                random.one_of(&[FaultKind::Vanish, FaultKind::Vanish, FaultKind::Break, FaultKind::Interrupt])
            } else {
                FaultKind::Begin
            };
            runs = kind == FaultKind::Begin;
            if runs && has_begun {
                last = self.conditions.hosts.len();
                self.instances.push(federate);
                self.conditions.hosts.push(self.conditions.hosts[federate + 1].clone());
            }
            has_begun = true;
            self.faults.push(Fault { at, early, participant: last, kind });
        }
        let reactions = &mut self.federates[federate].reactions;
        if random.percent(35) && !reactions.is_empty() {
            let chosen = random.index(reactions.len());
            reactions[chosen].script.leave_at = Some(random.range(1, 20));
        }
    }
}

/// Returns a moment of a federation that runs for this long: a time, and whether it counts from the beginning of the
/// world.
fn moment(random: &mut Random, length: Nanos) -> (Nanos, bool) {
    match random.below(10) {
        0 => (random.time(0, 300 * MS), true),
        1 => (random.time(0, SEC), false),
        _ => (SEC + random.time(-5 * MS, length + MS), false),
    }
}

impl Reactor {
    /// Makes what happens by itself happen less often.
    fn scale(&mut self, factor: i64) {
        for timer in &mut self.timers {
            timer.offset *= factor;
            timer.period = timer.period.map(|period| period * factor);
        }
        for time in self.actions.iter_mut().flat_map(|action| &mut action.outside) {
            *time *= factor;
        }
        for child in &mut self.children {
            child.scale(factor);
        }
    }
}
