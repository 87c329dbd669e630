// SPDX-License-Identifier: Apache-2.0
//! The additional features of rich scenarios: banks, multiports, modes and watchdogs. They are added to a complete
//! scenario, so that the others do not change.

use lf_testkit::random::{Random, combine};

use super::{Connection, Link, LinkEnd, MS, Nanos, Reaction, Reactor, Scenario, Script, Variable, Watchdog, has_cycle};

/// The scenarios of seeds from here on are rich.
pub const RICH: u64 = 1 << 32;

impl Scenario {
    /// Adds banks, multiports, modes and watchdogs.
    pub(crate) fn enrich(&mut self) {
        let random = &mut Random::new(combine(self.seed, 31));
        let is_safe = self.decentralized.is_some_and(|it| it.is_safe);
        for federate in 0..self.federates.len() {
            // Sufficient waits are computed for each connection, and all connections to one multiport share theirs.
            if random.percent(60) && !is_safe {
                self.federates[federate].wide = true;
                self.align(federate);
                self.widen(random, federate);
            }
            // Without another end, the program ends when no events are left.
            let has_end = self.target.timeout.is_some();
            let reactor = &mut self.federates[federate];
            for child in 0..reactor.children.len() {
                if random.percent(35) {
                    reactor.make_bank(random, child);
                }
                reactor.children[child].wide = random.percent(60);
                if has_end {
                    reactor.children[child].enrich(random);
                }
            }
            if has_end {
                reactor.enrich(random);
            }
        }
    }

    /// Makes connections to neighboring inputs of a federate equal, where that makes no cycle without delay.
    fn align(&mut self, federate: usize) {
        for input in 1..self.federates[federate].inputs.len() {
            let find = |input: usize| self.connections.iter().position(|one| one.to == (federate, input));
            let (Some(before), Some(this)) = (find(input - 1), find(input)) else { continue };
            let (before, old) = (self.connections[before].clone(), self.connections[this].clone());
            let this = &mut self.connections[this];
            (this.after, this.capacity) = (before.after, before.capacity);
            if old.after.is_some() && has_cycle(self.federates.len(), &self.connections, true) {
                self.connections.iter_mut().filter(|one| one.to == old.to).for_each(|one| one.clone_from(&old));
            }
        }
    }

    /// Adds a channel to a connection from the last output of a federate to the last input of another one.
    fn widen(&mut self, random: &mut Random, to: usize) {
        let last = |one: &&Connection| {
            let ends = (self.federates[one.from.0].outputs.len(), self.federates[to].inputs.len());
            one.to.0 == to && (one.from.1 + 1, one.to.1 + 1) == ends && one.from.0 != to
        };
        let Some(found) = self.connections.iter().find(last).cloned() else { return };
        let (from, output, input) = (found.from.0, found.from.1 + 1, found.to.1 + 1);
        if self.connections.iter().filter(|one| one.from == found.from).count() > 1 || input > 6 {
            return;
        }
        let source = &mut self.federates[from];
        source.wide = true;
        source.outputs.push(source.outputs[output - 1]);
        let writers = source.reactions.iter_mut().filter(|it| it.effects.contains(&Variable::Output(output - 1)));
        writers.filter(|_| random.percent(60)).for_each(|it| it.effects.push(Variable::Output(output)));
        let destination = &mut self.federates[to];
        destination.inputs.push(destination.inputs[input - 1]);
        let made = destination.reaction(random, vec![Variable::Input(input)], None);
        destination.reactions.push(made);
        self.connections.push(Connection { from: (from, output), to: (to, input), ..found });
    }

    /// Makes all connections to one multiport of a federate wait as long as the first one.
    pub(crate) fn align_waits(&mut self) {
        for federate in (0..self.federates.len()).filter(|federate| self.federates[*federate].wide) {
            let mut first = None;
            for one in self.connections.iter_mut().filter(|one| one.to.0 == federate) {
                (one.max_wait, one.absent_after) = *first.get_or_insert((one.max_wait, one.absent_after));
            }
        }
    }
}

impl Reactor {
    /// Turns a contained reactor into a bank. Reactions read its outputs.
    fn make_bank(&mut self, random: &mut Random, child: usize) {
        self.children[child].bank = Some(random.count(2, 3));
        self.links.retain(|link| !matches!(link.from, LinkEnd::Child(from, _) if from == child));
        for output in 0..self.children[child].outputs.len() {
            let from = Variable::ChildOutput(child, output);
            let mut made = self.reaction(random, vec![from], None);
            made.effects.retain(|effect| !matches!(effect, Variable::ChildInput(..)));
            self.reactions.push(made);
        }
    }

    fn enrich(&mut self, random: &mut Random) {
        if random.percent(35) {
            self.add_modes(random);
        }
        if random.percent(40) {
            for _ in 0..random.count(1, 2) {
                self.add_watchdog(random);
            }
        }
    }

    /// Returns the shortest period in the scenario.
    fn period(&self) -> Nanos {
        self.timers.iter().filter_map(|timer| timer.period).min().unwrap_or(MS)
    }

    /// Returns a reaction in a mode or outside of all, to variables that are visible there, with effects that are free.
    fn reaction(&self, random: &mut Random, triggers: Vec<Variable>, mode: Option<usize>) -> Reaction {
        // Different modes may write one port.
        let is_other = |link: &Link| mode.is_some() && link.mode.is_some() && link.mode != mode;
        let is_free = |end: LinkEnd| self.links.iter().all(|link| link.to != end || is_other(link));
        let outputs = (0..self.outputs.len()).filter(|port| is_free(LinkEnd::Own(*port))).map(Variable::Output);
        let is_known = |declared: Option<usize>| declared.is_none() || declared == mode;
        let logical = |action: &usize| !self.actions[*action].physical && is_known(self.actions[*action].mode);
        let actions = (0..self.actions.len()).filter(logical).map(Variable::Action);
        let children = (0..self.children.len()).filter(|child| is_known(self.children[*child].mode));
        let inputs = children.flat_map(|child| (0..self.children[child].inputs.len()).map(move |port| (child, port)));
        let inputs = inputs.filter(|(child, port)| is_free(LinkEnd::Child(*child, *port)));
        let inputs = inputs.map(|(child, port)| Variable::ChildInput(child, port));
        let effects = outputs.chain(actions).chain(inputs).filter(|_| random.percent(50)).collect();
        let script = Script {
            percent: random.one_of(&[50, 80, 100]),
            energy: random.range(1, 3),
            offset_ns: random.one_of(&[0, 0, 1, self.period()]),
            ..Script::default()
        };
        Reaction { triggers, uses: Vec::new(), effects, tardy: false, script, mode }
    }

    /// Puts reactions, and the variables that only they use, into modes.
    fn add_modes(&mut self, random: &mut Random) {
        self.modes = random.count(2, 3);
        for child in 0..self.children.len() {
            if random.percent(50) {
                self.put_into_mode(random, child);
            }
        }
        for index in 0..self.reactions.len() {
            if self.reactions[index].mode.is_none() && self.can_be_in_mode(index) && random.percent(65) {
                self.reactions[index].mode = Some(random.index(self.modes));
            }
        }
        let inside: Vec<bool> = self.children.iter().map(|child| child.mode.is_some()).collect();
        let is_outside = |end| !matches!(end, LinkEnd::Child(child, _) if inside[child]);
        for link in self.links.iter_mut().filter(|link| is_outside(link.from) && is_outside(link.to)) {
            if random.percent(30) {
                link.mode = Some(random.index(self.modes));
            }
        }
        for timer in 0..self.timers.len() {
            self.timers[timer].mode = self.mode_of(Variable::Timer(timer)).filter(|_| random.percent(70));
            if self.timers[timer].mode.is_some() {
                // Modes that restart with an event at once could change without end at one time.
                let least = self.period() / 4;
                self.timers[timer].offset = self.timers[timer].offset.max(least);
            }
        }
        for action in (0..self.actions.len()).filter(|action| !self.actions[*action].physical).collect::<Vec<_>>() {
            self.actions[action].mode = self.mode_of(Variable::Action(action)).filter(|_| random.percent(70));
        }
        for mode in 0..self.modes {
            if random.percent(50) {
                let made = self.reaction(random, vec![Variable::Reset], Some(mode));
                self.reactions.push(made);
            }
            if random.percent(25) {
                let made = self.reaction(random, vec![Variable::Startup], Some(mode));
                self.reactions.push(made);
            }
        }
        self.reactions.iter_mut().for_each(|reaction| change_mode(random, reaction, self.modes));
    }

    /// Returns the mode that contains all reactions to a variable.
    fn mode_of(&self, variable: Variable) -> Option<usize> {
        let knows = |it: &&Reaction| [&it.triggers, &it.uses, &it.effects].iter().any(|list| list.contains(&variable));
        let mut modes = self.reactions.iter().filter(knows).map(|reaction| reaction.mode);
        let first = modes.next()??;
        modes.all(|mode| mode == Some(first)).then_some(first)
    }

    /// Returns whether a reaction may be inactive: it neither ends the program nor starts threads.
    fn can_be_in_mode(&self, reaction: usize) -> bool {
        let reaction = &self.reactions[reaction];
        let is_physical = |it: &Variable| matches!(it, Variable::Action(action) if self.actions[*action].physical);
        reaction.script.stop_at.is_none() && !reaction.effects.iter().any(is_physical)
    }

    /// Puts a contained reactor into a mode, with its connections and the reactions to it; reactions that cannot be
    /// there drop it.
    fn put_into_mode(&mut self, random: &mut Random, child: usize) {
        let belongs = |end: LinkEnd| matches!(end, LinkEnd::Child(one, _) if one == child);
        let is_other = |end: LinkEnd| matches!(end, LinkEnd::Child(one, _) if one != child);
        let is_joined = |it: &Link| (belongs(it.from) && is_other(it.to)) || (belongs(it.to) && is_other(it.from));
        if self.children[child].actions.iter().any(|action| action.physical) || self.links.iter().any(is_joined) {
            return;
        }
        let mode = Some(random.index(self.modes));
        self.children[child].mode = mode;
        for timer in &mut self.children[child].timers {
            timer.offset = timer.offset.max(timer.period.unwrap_or(MS) / 4);
        }
        for link in self.links.iter_mut().filter(|link| belongs(link.from) || belongs(link.to)) {
            link.mode = mode;
        }
        let knows =
            |it: &Variable| matches!(it, Variable::ChildInput(one, _) | Variable::ChildOutput(one, _) if *one == child);
        for index in 0..self.reactions.len() {
            let can_be = self.can_be_in_mode(index) && self.reactions[index].mode.is_none_or(|it| Some(it) == mode);
            let reaction = &mut self.reactions[index];
            let mut lists = [&mut reaction.triggers, &mut reaction.uses, &mut reaction.effects];
            if !lists.iter().any(|list| list.iter().any(knows)) {
                continue;
            }
            if can_be {
                reaction.mode = mode;
            } else {
                for list in &mut lists {
                    list.retain(|it| !knows(it));
                }
            }
        }
        self.reactions.retain(|reaction| !reaction.triggers.is_empty());
    }

    /// Adds a watchdog that some reactions start, and to which some react.
    fn add_watchdog(&mut self, random: &mut Random) {
        let mode = if self.modes > 0 && random.percent(50) { Some(random.index(self.modes)) } else { None };
        let period = self.period();
        let watchdog = Variable::Watchdog(self.watchdogs.len());
        let mut handler = self.reaction(random, Vec::new(), mode);
        change_mode(random, &mut handler, self.modes);
        for reaction in self.reactions.iter_mut().filter(|it| mode.is_none() || it.mode == mode) {
            if random.percent(50) {
                reaction.effects.push(watchdog);
            }
        }
        self.watchdogs.push(Watchdog { timeout: random.one_of(&[period / 2, period, 3 * period]), handler });
        if random.percent(60) {
            let mut behind = self.reaction(random, vec![watchdog], mode);
            change_mode(random, &mut behind, self.modes);
            self.reactions.push(behind);
        }
    }
}

/// Lets a reaction in a mode change to another one, or restart its own.
fn change_mode(random: &mut Random, reaction: &mut Reaction, modes: usize) {
    if reaction.mode.is_some() && reaction.triggers != [Variable::Reset] && random.percent(50) {
        reaction.effects.push(Variable::Mode { mode: random.index(modes), history: random.percent(50) });
    }
}
