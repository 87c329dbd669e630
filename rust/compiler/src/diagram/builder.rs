// SPDX-License-Identifier: Apache-2.0
//! Builds the diagram of an instantiated program.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    BankView, Diagram, DiagramEdge, DiagramElement, DiagramMode, DiagramPort, DiagramReactor, EdgeEnd, EdgeKind,
    ElementKind,
};
use crate::arena::Arena;
use crate::diagnostics::Diagnostics;
use crate::elaborated::Elaborated;
use crate::instances::InstanceId;
use crate::plan::{Plan, Time};
use crate::resolve::{CheckedConnection, Class, ConnectionEnd, PortRef, Variable, signature};
use crate::syntax::ast::{ActionKind, Direction, Expression, ReactionKeyword, Transition};

/// Returns the diagram of a program that has a plan.
pub(crate) fn diagram_of(program: &Elaborated<'_>, plan: &Plan, banks: BankView) -> Diagram {
    let mut builder = Builder { program, shown: Arena::of(&program.tree.instances, None), reactors: Vec::new() };
    let tree = &program.tree;
    for (position, instance) in tree.instances.iter().filter(|(position, _)| !tree.is_share(*position)) {
        let parent = instance.parent.map(|parent| builder.shown[parent]);
        // The contents of a member that another one stands for are not shown.
        if matches!(parent, Some(None)) {
            continue;
        }
        let is_hidden = banks == BankView::Collapsed && instance.bank_index.is_some_and(|index| index > 0);
        if is_hidden {
            continue;
        }
        builder.shown[position] = Some(builder.reactors.len());
        let reactor = builder.reactor(position, parent.flatten(), banks);
        builder.reactors.push(reactor);
    }
    // Edges name reactors that come after their containers.
    for position in tree.instances.ids() {
        if let Some(shown) = builder.shown[position] {
            let edges = builder.edges(position, shown);
            builder.reactors[shown].edges = edges;
        }
    }
    if let (Some(rti), Some(main)) = (&plan.rti, builder.reactors.first_mut()) {
        main.host = Some(rti.host.clone()).filter(|host| host != "localhost");
    }
    let coordination = plan.is_federated().then_some(plan.target.coordination);
    Diagram { name: plan.name.clone(), coordination, reactors: builder.reactors }
}

struct Builder<'a> {
    program: &'a Elaborated<'a>,
    /// Per instance: the reactor that shows it.
    shown: Arena<InstanceId, Option<usize>>,
    reactors: Vec<DiagramReactor>,
}

impl Builder<'_> {
    /// Returns the reactor that shows an instance, without edges.
    fn reactor(&self, position: InstanceId, parent: Option<usize>, banks: BankView) -> DiagramReactor {
        let tree = &self.program.tree;
        let (instance, class) = (&tree.instances[position], self.program.class(position));
        let declared = instance.parent.zip(instance.child);
        let siblings = declared.map_or(&[][..], |(parent, child)| &tree.instances[parent].children[child]);
        let child = declared.map(|(parent, child)| &self.program.class(parent).children[child]);
        let is_bank = banks == BankView::Collapsed && instance.bank_index.is_some();
        let name = match child {
            Some(child) if is_bank => child.ast.name.text.clone(),
            _ => instance.path.rsplit('.').next().unwrap_or_default().to_owned(),
        };
        let tops: Vec<InstanceId> = if is_bank { siblings.to_vec() } else { vec![position] };
        let parts =
            self.program.parts.list.iter().filter(|part| self.program.parts.federated && tops.contains(&part.top));
        let parts: Vec<_> = parts.collect();
        DiagramReactor {
            parent,
            name,
            class: class.name.clone(),
            members: is_bank.then_some(siblings.len()),
            federates: parts.iter().map(|part| part.name.clone()).collect(),
            host: parts.first().and_then(|part| part.host.clone()),
            mode: child.and_then(|child| child.ast.mode),
            ports: class
                .ports
                .iter()
                .zip(&instance.widths)
                .map(|(port, width)| DiagramPort {
                    name: port.name.text.clone(),
                    is_input: port.direction == Direction::Input,
                    ty: port.ty.clone(),
                    width: *width,
                })
                .collect(),
            modes: class
                .ast
                .body
                .modes
                .iter()
                .map(|mode| DiagramMode {
                    name: mode.name.as_ref().map(|name| name.text.clone()).unwrap_or_default(),
                    is_initial: mode.initial,
                })
                .collect(),
            elements: self.elements(position, class),
            edges: Vec::new(),
        }
    }

    /// Returns a time in the scope of an instance, in words. The analysis has reported times that it does not know.
    fn time(&self, position: InstanceId, value: Option<&Expression>) -> Option<Time> {
        self.program.time(position, value?, &mut Diagnostics::default()).map(Time)
    }

    /// Returns the reactions of an instance, then its timers, its actions, and the events that reactions wait for.
    fn elements(&self, position: InstanceId, class: &Class<'_>) -> Vec<DiagramElement> {
        let mut elements = Vec::new();
        let mut number = 0;
        for reaction in &class.reactions {
            let declared = reaction.ast;
            // Handlers of watchdogs have names, and do not count.
            number += usize::from(declared.kind != ReactionKeyword::Watchdog);
            let deadline = declared.deadline.as_ref().and_then(|it| self.time(position, Some(&it.value)));
            elements.push(DiagramElement {
                kind: ElementKind::Reaction,
                mode: declared.mode,
                name: declared.name.as_ref().map_or_else(|| number.to_string(), |name| name.text.clone()),
                timing: deadline.map(|time| format!("deadline {time}")).unwrap_or_default(),
                declaration: signature(declared),
            });
        }
        for timer in &class.timers {
            let offset = self.time(position, timer.offset.as_ref()).filter(|time| time.0 != 0);
            let period = self.time(position, timer.period.as_ref()).filter(|time| (1..i64::MAX).contains(&time.0));
            let timing = match (offset, period) {
                (None, None) => "at the start".to_owned(),
                (Some(offset), None) => format!("after {offset}"),
                (None, Some(period)) => format!("every {period}"),
                (Some(offset), Some(period)) => format!("after {offset}, every {period}"),
            };
            let name = timer.name.text.clone();
            let declaration = format!("timer {name}");
            elements.push(DiagramElement { kind: ElementKind::Timer, mode: timer.mode, name, timing, declaration });
        }
        for action in class.actions.iter().map(|action| action.ast) {
            let delay = self.time(position, action.min_delay.as_ref()).filter(|time| time.0 != 0);
            let spacing = self.time(position, action.min_spacing.as_ref()).filter(|time| time.0 > 0);
            let (kind, word) = match action.kind {
                ActionKind::Logical => (ElementKind::LogicalAction, "logical action"),
                ActionKind::Physical => (ElementKind::PhysicalAction, "physical action"),
                ActionKind::Watchdog => (ElementKind::Watchdog, "watchdog"),
            };
            let delay = delay.map(|time| time.to_string());
            let parts = [delay, spacing.map(|time| format!("spacing {time}"))];
            let name = action.name.text.clone();
            elements.push(DiagramElement {
                kind,
                mode: action.mode,
                timing: parts.into_iter().flatten().collect::<Vec<_>>().join(", "),
                declaration: format!("{word} {name}"),
                name,
            });
        }
        for (kind, mode) in events(class).into_keys() {
            let name = event_name(kind).to_owned();
            let declaration = name.clone();
            elements.push(DiagramElement { kind, mode, name, timing: String::new(), declaration });
        }
        elements
    }

    fn edges(&self, position: InstanceId, shown: usize) -> Vec<DiagramEdge> {
        let class = self.program.class(position);
        let mut edges = EdgeList::default();
        for connection in &class.connections {
            let delay = self.time(position, connection.after).map(|time| time.to_string());
            let kind = EdgeKind::Connection { delay, physical: connection.physical };
            for (from, to) in self.pairs(position, connection) {
                edges.add(from, to, kind.clone());
            }
        }
        let (reactions, timers) = (class.reactions.len(), class.timers.len());
        let events = events(class);
        for (index, reaction) in class.reactions.iter().enumerate() {
            let own = EdgeEnd::Element(index);
            for parameter in &reaction.parameters {
                let event = |kind| events.get(&(kind, reaction.ast.mode)).copied().unwrap_or_default();
                let others = match parameter.variable {
                    Variable::Startup => vec![EdgeEnd::Element(event(ElementKind::Startup))],
                    Variable::Shutdown => vec![EdgeEnd::Element(event(ElementKind::Shutdown))],
                    Variable::Reset => vec![EdgeEnd::Element(event(ElementKind::Reset))],
                    Variable::Timer(timer) => vec![EdgeEnd::Element(reactions + timer)],
                    Variable::Action(action) => vec![EdgeEnd::Element(reactions + timers + action)],
                    Variable::Port(port) => self.members(position, port).into_iter().map(|(end, _)| end).collect(),
                    Variable::Mode(mode, transition) => {
                        let history = transition == Transition::History;
                        edges.add(own, EdgeEnd::Mode(mode), EdgeKind::Transition { history });
                        continue;
                    }
                };
                for other in others {
                    if parameter.triggers {
                        edges.add(other, own, EdgeKind::Trigger);
                    } else if parameter.uses {
                        edges.add(other, own, EdgeKind::Use);
                    }
                    if parameter.effect {
                        edges.add(own, other, EdgeKind::Effect);
                    }
                }
            }
        }
        debug_assert!(self.reactors[shown].elements.len() >= reactions + timers);
        edges.list
    }

    /// Returns a port as a reactor sees it, for each member of a bank, with the number of its channels.
    fn members(&self, position: InstanceId, port: PortRef) -> Vec<(EdgeEnd, usize)> {
        let instances = &self.program.tree.instances;
        let channels = |instance: InstanceId, port: usize| instances[instance].widths[port].unwrap_or(1);
        match port {
            PortRef::Own(port) => vec![(EdgeEnd::Own(port), channels(position, port))],
            PortRef::Child(child, port) => {
                let members = &instances[position].children[child];
                // A member that is not shown is one of the bank that its first member shows.
                let first = members.first().and_then(|first| self.shown[*first]);
                members
                    .iter()
                    .filter_map(|member| {
                        let reactor = self.shown[*member].or(first)?;
                        Some((EdgeEnd::Contained { reactor, port }, channels(*member, port)))
                    })
                    .collect()
            }
        }
    }

    /// Returns the ends that a connection connects, channel by channel.
    fn pairs(&self, position: InstanceId, connection: &CheckedConnection<'_>) -> Vec<(EdgeEnd, EdgeEnd)> {
        let side = |ends: &[ConnectionEnd<'_>]| -> Vec<EdgeEnd> {
            ends.iter().flat_map(|end| self.channels(position, end)).collect()
        };
        let (left, right) = (side(&connection.left), side(&connection.right));
        // The analysis has compared the numbers; the left side is repeated if the program says so.
        left.into_iter().cycle().zip(right).collect()
    }

    /// Returns the end of a connection once for each channel. If it is interleaved, the first channels come first.
    fn channels(&self, position: InstanceId, end: &ConnectionEnd<'_>) -> Vec<EdgeEnd> {
        let members = self.members(position, end.port);
        if !end.ast.interleaved {
            return members.into_iter().flat_map(|(end, channels)| core::iter::repeat_n(end, channels)).collect();
        }
        let widest = members.iter().map(|(_, channels)| *channels).max().unwrap_or_default();
        let with = |channel| members.iter().filter(move |(_, channels)| channel < *channels).map(|(end, _)| *end);
        (0..widest).flat_map(with).collect()
    }
}

/// Edges, each once.
#[derive(Default)]
struct EdgeList {
    list: Vec<DiagramEdge>,
    known: BTreeSet<(EdgeEnd, EdgeEnd, EdgeKind)>,
}

impl EdgeList {
    fn add(&mut self, from: EdgeEnd, to: EdgeEnd, kind: EdgeKind) {
        if self.known.insert((from, to, kind.clone())) {
            self.list.push(DiagramEdge { from, to, kind });
        }
    }
}

/// Returns the events that reactions of a reactor wait for, once for each mode, with their positions among the
/// elements.
fn events(class: &Class<'_>) -> BTreeMap<(ElementKind, Option<usize>), usize> {
    let mut events = BTreeSet::new();
    for reaction in &class.reactions {
        for parameter in &reaction.parameters {
            let kind = match parameter.variable {
                Variable::Startup => ElementKind::Startup,
                Variable::Shutdown => ElementKind::Shutdown,
                Variable::Reset => ElementKind::Reset,
                _ => continue,
            };
            events.insert((kind, reaction.ast.mode));
        }
    }
    let first = class.reactions.len() + class.timers.len() + class.actions.len();
    events.into_iter().enumerate().map(|(index, event)| (event, first + index)).collect()
}

fn event_name(kind: ElementKind) -> &'static str {
    match kind {
        ElementKind::Startup => "startup",
        ElementKind::Shutdown => "shutdown",
        _ => "reset",
    }
}
