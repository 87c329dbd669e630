// SPDX-License-Identifier: Apache-2.0
//! Random reactors: the contents of a federate, and of the reactors in it.

use lf_testkit::random::Random;

use super::{Action, Link, LinkEnd, MS, Nanos, Reaction, Reactor, Script, Timer, Ty, US, Variable};

/// The way in which a federation ends without a fault.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Ending {
    Timeout,
    /// A reaction requests a stop.
    Stop,
    /// No events are left.
    Idle,
}

/// The common properties of a scenario's reactors.
pub(super) struct Style {
    /// The period from which the periods of all timers derive.
    pub(super) period: Nanos,
    pub(super) ending: Ending,
    /// Whether some reactions take long.
    pub(super) slow: bool,
    /// Whether events cause many further ones.
    pub(super) busy: bool,
}

/// Returns a federate with these ports.
pub(super) fn federate(random: &mut Random, style: &Style, inputs: Vec<Ty>, outputs: Vec<Ty>) -> Reactor {
    let is_source = inputs.is_empty() || random.percent(40);
    let children = if random.percent(30) { random.count(1, 2) } else { 0 };
    let mut reactor = Reactor { inputs, outputs, ..Reactor::default() };
    for _ in 0..children {
        let child = Reactor {
            inputs: vec![Ty::Small; random.count(1, 2)],
            outputs: vec![Ty::Small; random.count(1, 2)],
            ..Reactor::default()
        };
        reactor.children.push(fill(random, style, child, 30, false));
    }
    fill(random, style, reactor, if is_source { 100 } else { 0 }, true)
}

/// Fills a reactor that has its ports and children.
fn fill(random: &mut Random, style: &Style, mut reactor: Reactor, timer_percent: u64, is_federate: bool) -> Reactor {
    if random.percent(timer_percent) {
        for _ in 0..random.count(1, 2) {
            reactor.timers.push(timer(random, style));
        }
    }
    for _ in 0..random.one_of(&[0, 0, 1, 2]) {
        reactor.actions.push(action(random, style, false));
    }
    if random.percent(12) {
        reactor.actions.push(action(random, style, true));
    }
    connect(random, style, &mut reactor);
    let effects = effects(&reactor);
    add_reactions(random, style, &mut reactor, &effects, is_federate);
    reactor
}

fn timer(random: &mut Random, style: &Style) -> Timer {
    let period = style.period;
    let offset = random.one_of(&[0, 0, period / 2, period, 3 * period, 1]);
    let repeated = random.one_of(&[period, period, 2 * period, 3 * period, period + 1]);
    Timer { offset, period: (style.ending != Ending::Idle).then_some(repeated), mode: None }
}

fn action(random: &mut Random, style: &Style, physical: bool) -> Action {
    let period = style.period;
    let min_spacing = random
        .percent(15)
        .then(|| (random.one_of(&[period / 3, period]), random.one_of(&["defer", "drop", "replace", "update"])));
    let outside = if physical {
        let mut at = 0;
        let times = (0..random.count(1, 8)).map(|_| {
            at += random.one_of(&[0, 10 * US, period / 2, period, 3 * period]);
            at
        });
        times.collect()
    } else {
        Vec::new()
    };
    let min_delay = random.one_of(&[0, 0, 1, period / 2, period]);
    Action { physical, min_delay, min_spacing, capacity: 64, mode: None, outside }
}

/// Connects inputs with children, children with each other, and children with outputs. Reactions handle the rest.
fn connect(random: &mut Random, style: &Style, reactor: &mut Reactor) {
    let mut links: Vec<Link> = Vec::new();
    let mut add = |random: &mut Random, from: LinkEnd, to: LinkEnd| {
        let after = random.percent(30).then(|| random.one_of(&[0, 1, style.period / 2, style.period]));
        links.push(Link { from, to, after, capacity: 128, mode: None });
    };
    let small: Vec<_> = (0..reactor.inputs.len()).filter(|input| reactor.inputs[*input] == Ty::Small).collect();
    for (child, contained) in reactor.children.iter().enumerate() {
        for port in 0..contained.inputs.len() {
            if child > 0 && random.percent(40) {
                let from = random.count(0, child - 1);
                let output = random.count(0, reactor.children[from].outputs.len() - 1);
                add(random, LinkEnd::Child(from, output), LinkEnd::Child(child, port));
            } else if !small.is_empty() && random.percent(50) {
                let from = LinkEnd::Own(random.one_of(&small));
                add(random, from, LinkEnd::Child(child, port));
            }
        }
    }
    for (port, ty) in reactor.outputs.iter().enumerate() {
        if *ty == Ty::Small && !reactor.children.is_empty() && random.percent(35) {
            let child = random.count(0, reactor.children.len() - 1);
            let output = random.count(0, reactor.children[child].outputs.len() - 1);
            add(random, LinkEnd::Child(child, output), LinkEnd::Own(port));
        } else if random.percent(8) {
            let same: Vec<_> = (0..reactor.inputs.len()).filter(|input| reactor.inputs[*input] == *ty).collect();
            if !same.is_empty() {
                let from = LinkEnd::Own(random.one_of(&same));
                add(random, from, LinkEnd::Own(port));
            }
        }
    }
    reactor.links = links;
}

/// The variables that the reactions of a reactor may write: its outputs and actions, and then inputs of contained
/// reactors.
struct Effects {
    own: Vec<Variable>,
    inner: Vec<Variable>,
}

fn effects(reactor: &Reactor) -> Effects {
    let free = |end: LinkEnd| reactor.links.iter().all(|link| link.to != end);
    let outputs = (0..reactor.outputs.len()).filter(|port| free(LinkEnd::Own(*port))).map(Variable::Output);
    let actions = (0..reactor.actions.len()).map(Variable::Action);
    let inner = reactor
        .children
        .iter()
        .enumerate()
        .flat_map(|(child, contained)| (0..contained.inputs.len()).map(move |port| (child, port)));
    Effects {
        own: outputs.chain(actions).collect(),
        inner: inner
            .filter(|(child, port)| free(LinkEnd::Child(*child, *port)))
            .map(|(child, port)| Variable::ChildInput(child, port))
            .collect(),
    }
}

fn add_reactions(random: &mut Random, style: &Style, reactor: &mut Reactor, effects: &Effects, is_federate: bool) {
    let physical: Vec<_> = (0..reactor.actions.len()).filter(|action| reactor.actions[*action].physical).collect();
    let mut reactions = Vec::new();
    if !physical.is_empty() || random.percent(25) {
        let mut startup = reaction(random, style, vec![Variable::Startup], effects, true);
        for action in physical {
            // This reaction starts the threads.
            if !startup.effects.contains(&Variable::Action(action)) {
                startup.effects.push(Variable::Action(action));
            }
        }
        reactions.push(startup);
    }
    let timers = (0..reactor.timers.len()).map(Variable::Timer);
    let actions = (0..reactor.actions.len()).map(Variable::Action);
    let mut sources: Vec<_> = timers.chain(actions).collect();
    let mut inputs: Vec<_> = (0..reactor.inputs.len()).map(Variable::Input).collect();
    while !inputs.is_empty() {
        let mut triggers = vec![inputs.remove(0)];
        while !inputs.is_empty() && random.percent(40) {
            triggers.push(inputs.remove(0));
        }
        let at = random.count(0, reactions.len());
        reactions.insert(at.max(usize::from(!reactions.is_empty())), reaction(random, style, triggers, effects, true));
    }
    for source in sources.drain(..) {
        let mut made = reaction(random, style, vec![source], effects, true);
        if !reactor.inputs.is_empty() && random.percent(30) {
            made.uses.push(Variable::Input(random.count(0, reactor.inputs.len() - 1)));
        }
        let at = random.count(usize::from(!reactions.is_empty()), reactions.len());
        reactions.insert(at, made);
    }
    // Each federate prints at its end.
    if is_federate || random.percent(40) {
        let mut end = reaction(random, style, vec![Variable::Shutdown], effects, true);
        if style.ending != Ending::Timeout {
            // Each federate ends at a time of its own, on which its last messages would depend.
            end.effects.clear();
        }
        reactions.push(end);
    }
    for (child, contained) in reactor.children.iter().enumerate() {
        for port in 0..contained.outputs.len() {
            if random.percent(40) {
                // Outputs of a child do not lead into a child again, which could be a loop.
                reactions.push(reaction(random, style, vec![Variable::ChildOutput(child, port)], effects, false));
            }
        }
    }
    reactor.reactions = reactions;
}

fn reaction(random: &mut Random, style: &Style, triggers: Vec<Variable>, effects: &Effects, inner: bool) -> Reaction {
    let likely = if style.busy { 75 } else { 50 };
    let candidates = effects.own.iter().chain(effects.inner.iter().filter(|_| inner));
    let effects = candidates.copied().filter(|_| random.percent(likely)).collect();
    let work_ns = match random.below(100) {
        0..=11 if style.slow => random.one_of(&[500 * US, MS, 3 * MS]),
        12..=30 => random.one_of(&[5 * US, 50 * US]),
        _ => 0,
    };
    let script = Script {
        percent: random.one_of(&[20, 50, 80, 100, 100]),
        energy: random.range(1, if style.busy { 6 } else { 3 }),
        work_ns,
        offset_ns: random.one_of(&[0, 0, 1, style.period / 2, 2 * style.period]),
        ..Script::default()
    };
    Reaction { triggers, uses: Vec::new(), effects, tardy: false, script, mode: None }
}
