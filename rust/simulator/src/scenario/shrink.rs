// SPDX-License-Identifier: Apache-2.0
//! Smaller scenarios: each lacks one element, or simplifies it.

use lf_coordination::WINDOW;

use super::{Connection, Host, LinkEnd, Reaction, Reactor, Scenario, Script, US, Variable, Wire};

/// Returns all scenarios that are smaller by one element, the greatest reductions first. Their order follows from the
/// scenario alone.
pub(crate) fn reductions(scenario: &Scenario) -> Vec<Scenario> {
    let mut smaller = Vec::new();
    let mut add = |change: &dyn Fn(&mut Scenario)| {
        let mut changed = scenario.clone();
        change(&mut changed);
        if changed != *scenario {
            smaller.push(changed);
        }
    };
    if scenario.federates.len() > 1 {
        for federate in 0..scenario.federates.len() {
            add(&|it| it.remove_federate(federate));
        }
    }
    for connection in 0..scenario.connections.len() {
        add(&|it| it.remove_connection(connection));
    }
    for fault in 0..scenario.faults.len() {
        add(&|it| it.faults.retain(|other| *other != scenario.faults[fault]));
    }
    for instance in scenario.federates.len()..scenario.instances.len() {
        add(&|it| it.remove_instance(instance));
    }
    conditions(scenario, &mut add);
    for federate in 0..scenario.federates.len() {
        reactor(&scenario.federates[federate], &mut |change| add(&|it| change(&mut it.federates[federate])));
        for child in 0..scenario.federates[federate].children.len() {
            let contained = &scenario.federates[federate].children[child];
            reactor(contained, &mut |change| add(&|it| change(&mut it.federates[federate].children[child])));
        }
    }
    for connection in 0..scenario.connections.len() {
        add(&|it| it.connections[connection].capacity = None);
    }
    if scenario.decentralized.is_some() {
        for connection in 0..scenario.connections.len() {
            add(&|it| it.connections[connection].absent_after = None);
        }
    }
    smaller
}

/// Changes to a scenario as a whole, one at a time.
type Add<'a> = dyn FnMut(&dyn Fn(&mut Scenario)) + 'a;

fn conditions(scenario: &Scenario, add: &mut Add<'_>) {
    let is_bounded = scenario.decentralized.is_some();
    add(&|it| {
        for host in &mut it.conditions.hosts {
            calm(host, is_bounded);
        }
    });
    for host in 0..scenario.conditions.hosts.len() {
        add(&|it| calm(&mut it.conditions.hosts[host], is_bounded));
    }
    add(&|it| it.conditions.pieces = false);
    add(&|it| it.target.fast = false);
    add(&|it| it.target.keepalive = false);
    add(&|it| it.target.auth = false);
    add(&|it| it.target.advance = None);
    add(&|it| it.target.rounds = None);
    add(&|it| it.target.clock_sync = None);
    add(&|it| it.target.timeout = it.target.timeout.map(|ns| ns / 2));
    add(&|it| it.target.timeout = it.target.timeout.map(|ns| ns - ns / 10));
    add(&|it| it.conditions.rti.dnet = false);
    add(&|it| it.conditions.rti.start_time_multiple = None);
    add(&|it| it.conditions.rti.in_transit = 64);
    add(&|it| it.conditions.rti.window = WINDOW);
    add(&|it| it.conditions.rti.spare = 4096);
    add(&|it| it.conditions.receive_spare = 1 << 16);
    add(&|it| it.conditions.send_spare = 4096);
}

fn calm(host: &mut Host, is_bounded: bool) {
    *host = Host {
        begins: 0,
        clock_offset: 0,
        clock_drift_ppb: 0,
        turn_ns: 200,
        wake_ns: 0,
        // Not slower than before, because the waits may depend on it.
        link: Wire {
            latency: if is_bounded { host.link.latency.min(20 * US) } else { 20 * US },
            jitter: 0,
            slow_percent: 0,
            ns_per_byte: 0,
            socket_bytes: 1 << 16,
        },
    };
}

/// Changes to one reactor, one at a time.
type AddToReactor<'a> = dyn FnMut(&dyn Fn(&mut Reactor)) + 'a;

fn reactor(reactor: &Reactor, add: &mut AddToReactor<'_>) {
    for child in 0..reactor.children.len() {
        add(&|it| it.remove_child(child));
    }
    for reaction in 0..reactor.reactions.len() {
        add(&|it| drop(it.reactions.remove(reaction)));
    }
    for timer in 0..reactor.timers.len() {
        add(&|it| it.remove_trigger(Variable::Timer(timer)));
        add(&|it| it.timers[timer].offset = 0);
    }
    for action in 0..reactor.actions.len() {
        add(&|it| it.remove_trigger(Variable::Action(action)));
        add(&|it| it.actions[action].min_spacing = None);
        add(&|it| {
            let outside = &mut it.actions[action].outside;
            outside.truncate(outside.len().saturating_sub(1));
        });
    }
    for watchdog in 0..reactor.watchdogs.len() {
        add(&|it| it.remove_trigger(Variable::Watchdog(watchdog)));
        add(&|it| it.watchdogs[watchdog].handler.effects.clear());
    }
    add(&Reactor::remove_modes);
    add(&|it| it.bank = None);
    add(&|it| it.wide = false);
    for link in 0..reactor.links.len() {
        add(&|it| it.links.retain(|other| *other != reactor.links[link]));
        add(&|it| it.links[link].after = None);
    }
    for (index, reaction) in reactor.reactions.iter().enumerate() {
        for effect in 0..reaction.effects.len() {
            add(&|it| remove(&mut it.reactions[index].effects, effect));
        }
        for used in 0..reaction.uses.len() {
            add(&|it| remove(&mut it.reactions[index].uses, used));
        }
        add(&|it| it.reactions[index].tardy = false);
        let scripts: [fn(&mut Script); 7] = [
            |script| script.work_ns = 0,
            |script| script.offset_ns = 0,
            |script| script.stop_at = None,
            |script| script.leave_at = None,
            |script| script.stop_offset_ns = 0,
            |script| script.energy = script.energy.min(1),
            |script| script.percent = 100,
        ];
        for change in scripts {
            add(&|it| change(&mut it.reactions[index].script));
        }
    }
}

fn remove(list: &mut Vec<Variable>, index: usize) {
    list.remove(index);
}

impl Scenario {
    fn remove_federate(&mut self, federate: usize) {
        while let Some(connection) =
            self.connections.iter().position(|one| one.from.0 == federate || one.to.0 == federate)
        {
            self.remove_connection(connection);
        }
        while let Some(instance) = self.instances.iter().rposition(|of| *of == federate) {
            self.remove_instance(instance);
        }
        self.federates.remove(federate);
        for of in &mut self.instances {
            *of -= usize::from(*of > federate);
        }
        for Connection { from, to, .. } in &mut self.connections {
            from.0 -= usize::from(from.0 > federate);
            to.0 -= usize::from(to.0 > federate);
        }
    }

    fn remove_instance(&mut self, instance: usize) {
        self.instances.remove(instance);
        self.conditions.hosts.remove(instance + 1);
        self.faults.retain(|fault| fault.participant != instance + 1);
        for fault in &mut self.faults {
            fault.participant -= usize::from(fault.participant > instance + 1);
        }
    }

    pub(super) fn remove_connection(&mut self, connection: usize) {
        let Connection { to: (federate, input), .. } = self.connections.remove(connection);
        self.federates[federate].remove_input(input);
        for other in self.connections.iter_mut().filter(|other| other.to.0 == federate) {
            other.to.1 -= usize::from(other.to.1 > input);
        }
    }
}

impl Reactor {
    fn remove_input(&mut self, input: usize) {
        self.inputs.remove(input);
        self.links.retain(|link| link.from != LinkEnd::Own(input));
        for link in &mut self.links {
            if let LinkEnd::Own(port) = &mut link.from {
                *port -= usize::from(*port > input);
            }
        }
        self.rename(&|variable| match variable {
            Variable::Input(port) if port == input => None,
            Variable::Input(port) => Some(Variable::Input(port - usize::from(port > input))),
            other => Some(other),
        });
    }

    fn remove_child(&mut self, child: usize) {
        self.children.remove(child);
        let belongs = |end: LinkEnd| matches!(end, LinkEnd::Child(one, _) if one == child);
        self.links.retain(|link| !belongs(link.from) && !belongs(link.to));
        for link in &mut self.links {
            for end in [&mut link.from, &mut link.to] {
                if let LinkEnd::Child(one, _) = end {
                    *one -= usize::from(*one > child);
                }
            }
        }
        self.rename(&|variable| match variable {
            Variable::ChildInput(one, _) | Variable::ChildOutput(one, _) if one == child => None,
            Variable::ChildInput(one, port) => Some(Variable::ChildInput(one - usize::from(one > child), port)),
            Variable::ChildOutput(one, port) => Some(Variable::ChildOutput(one - usize::from(one > child), port)),
            other => Some(other),
        });
    }

    /// Restores the state of a reactor without modes.
    fn remove_modes(&mut self) {
        self.modes = 0;
        self.timers.iter_mut().for_each(|it| it.mode = None);
        self.actions.iter_mut().for_each(|it| it.mode = None);
        self.children.iter_mut().for_each(|it| it.mode = None);
        self.links.iter_mut().for_each(|it| it.mode = None);
        let handlers = self.watchdogs.iter_mut().map(|it| &mut it.handler);
        self.reactions.iter_mut().chain(handlers).for_each(|it| it.mode = None);
        self.rename(&|variable| Some(variable).filter(|it| !matches!(it, Variable::Mode { .. } | Variable::Reset)));
    }

    /// Removes a timer, an action or a watchdog.
    fn remove_trigger(&mut self, removed: Variable) {
        match removed {
            Variable::Timer(timer) => drop(self.timers.remove(timer)),
            Variable::Action(action) => drop(self.actions.remove(action)),
            Variable::Watchdog(watchdog) => drop(self.watchdogs.remove(watchdog)),
            _ => {}
        }
        self.rename(&|variable| match (variable, removed) {
            (one, other) if one == other => None,
            (Variable::Timer(one), Variable::Timer(other)) => Some(Variable::Timer(one - usize::from(one > other))),
            (Variable::Action(one), Variable::Action(other)) => Some(Variable::Action(one - usize::from(one > other))),
            (Variable::Watchdog(one), Variable::Watchdog(other)) => {
                Some(Variable::Watchdog(one - usize::from(one > other)))
            }
            (other, _) => Some(other),
        });
    }

    /// Renames variables, and removes those without a new name, with the reactions that are then never triggered.
    fn rename(&mut self, name: &dyn Fn(Variable) -> Option<Variable>) {
        let handlers = self.watchdogs.iter_mut().map(|watchdog| &mut watchdog.handler);
        for Reaction { triggers, uses, effects, .. } in self.reactions.iter_mut().chain(handlers) {
            for list in [triggers, uses, effects] {
                *list = list.iter().filter_map(|variable| name(*variable)).collect();
            }
        }
        self.reactions.retain(|reaction| !reaction.triggers.is_empty());
    }
}
