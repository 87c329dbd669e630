// SPDX-License-Identifier: Apache-2.0
//! The plan of one federate.

use std::collections::{BTreeMap, BTreeSet};

use super::builder::{Context, FederateBuilder, Source};
use super::graph::Work;
use super::physical;
use crate::diagnostics::{Code, Diagnostic, Diagnostics};
use crate::instances::ModeInstanceId;
use crate::plan::{self, Argument, InstanceIndex, ModeIndex, OutputIndex, PortIndex, ReactionIndex, TriggerIndex};
use crate::resolve::Variable;

/// Plans one federate.
pub(super) fn plan(context: &Context<'_>, part: usize, diagnostics: &mut Diagnostics) -> plan::Federate {
    let (program, tree) = (context.program, &context.program.tree);
    let members = tree.instances.ids().filter(|instance| program.part(*instance) == Some(part));
    let members: Vec<_> = members.collect();
    let instances: BTreeMap<_, _> =
        members.iter().enumerate().map(|(index, member)| (*member, InstanceIndex(index))).collect();
    let modes = tree.modes.iter().filter(|(_, mode)| program.part(mode.instance) == Some(part));
    let modes = modes.enumerate().map(|(index, (mode, _))| (mode, ModeIndex(index))).collect();
    let ports = BTreeMap::new();
    let (triggers, sources, spacings) = (Vec::new(), BTreeMap::new(), Vec::new());
    let mut builder = FederateBuilder { context, part, members, instances, ports, modes, triggers, sources, spacings };
    builder.number_ports();
    builder.add_triggers(diagnostics);
    let reactions = builder.reactions(diagnostics);
    let ports = builder.join(&reactions);
    builder.finish(reactions, ports, diagnostics)
}

impl FederateBuilder<'_> {
    /// Numbers the ports that a reaction or a connection uses; others need no storage.
    fn number_ports(&mut self) {
        let graph = self.context.graph;
        let mut used = BTreeSet::new();
        for (node, root) in graph.root.iter().filter(|(node, _)| self.owns(graph.instance[*node])) {
            if !graph.writers[node].is_empty() || !graph.readers[node].is_empty() {
                used.insert(*root);
            }
        }
        for link in graph.links.values().filter(|link| link.network || link.copies || link.is_delayed()) {
            used.extend([graph.root[link.from], graph.root[link.to]].iter().filter(|n| self.owns(graph.instance[**n])));
        }
        self.ports = used.into_iter().enumerate().map(|(index, node)| (node, PortIndex(index))).collect();
    }

    /// Returns all reactions and sends, by level, then in the order of instances.
    fn reactions(&self, diagnostics: &mut Diagnostics) -> Vec<plan::ScheduledReaction> {
        let Context { graph, program, levels, .. } = *self.context;
        let mut reactions = Vec::new();
        for (position, step) in graph.steps.iter().filter(|(_, step)| self.owns(step.instance)) {
            let (name, level) = (graph.step_name(position), levels.steps[position]);
            let mode = self.mode_index(step.mode);
            let number = match step.work {
                Work::Reaction(number) => number,
                Work::Copy(link) => {
                    let link = &graph.links[link];
                    let kind = plan::ReactionKind::Copy { from: self.port(link.from), to: self.port(link.to) };
                    reactions.push(plan::ScheduledReaction { name, level, deadline_ns: None, mode, kind });
                    continue;
                }
            };
            let class = program.class(step.instance);
            let reaction = &class.reactions[number];
            let arguments = reaction.parameters.iter().filter_map(|parameter| {
                Some(match parameter.variable {
                    Variable::Startup | Variable::Shutdown | Variable::Reset => return None,
                    Variable::Mode(mode, _) => {
                        Argument::Mode(self.mode_index(program.tree.mode_of(step.instance, Some(mode)))?)
                    }
                    Variable::Port(port) => {
                        let members = graph.members(step.instance, port);
                        let widths = members.iter().map(Vec::len).collect();
                        let mut ports = members.into_iter().flatten().map(|node| self.port(node));
                        if class.is_of_bank(port) && class.port(port, program.classes)?.width.is_some() {
                            Argument::Bank { ports: ports.collect(), widths }
                        } else if class.is_wide(port, program.classes) {
                            Argument::Ports(ports.collect())
                        } else {
                            Argument::Port(ports.next()?)
                        }
                    }
                    Variable::Timer(timer) => Argument::Trigger(self.sources[&Source::Timer(step.instance, timer)]),
                    Variable::Action(action) => Argument::Trigger(self.sources[&Source::Action(step.instance, action)]),
                })
            });
            let kind = plan::ReactionKind::Body {
                instance: self.instance_index(step.instance),
                reaction: number + 1,
                arguments: arguments.collect(),
            };
            let deadline = reaction.ast.deadline.as_ref();
            let deadline = deadline.and_then(|it| program.time(step.instance, &it.value, diagnostics));
            reactions.push(plan::ScheduledReaction {
                name,
                level,
                deadline_ns: deadline.filter(|ns| *ns != i64::MAX),
                mode,
                kind,
            });
        }
        for (output, link) in self.context.network.outputs[self.part].iter().enumerate() {
            let level = levels.sends[*link];
            let kind = plan::ReactionKind::Send(OutputIndex(output));
            let name = self.link_name(*link);
            reactions.push(plan::ScheduledReaction { name, level, deadline_ns: None, mode: None, kind });
        }
        // The sort is stable, so instances and declarations stay in order within a level.
        reactions.sort_by_key(|reaction| reaction.level);
        reactions
    }

    /// Adds the reactions that ports and triggers trigger, now that the order of reactions is known.
    fn join(&mut self, reactions: &[plan::ScheduledReaction]) -> Vec<plan::Port> {
        let Context { graph, places, described, .. } = *self.context;
        let mut ports: Vec<plan::Port> = Vec::new();
        for node in self.ports.keys() {
            let port = graph.port(*node);
            ports.push(plan::Port {
                path: graph.path(*node),
                ty: places.ty(&port.ty, port.ty_span),
                reactions: Vec::new(),
                delays: Vec::new(),
                at: places.at(port.name.span),
            });
        }
        for (index, reaction) in reactions.iter().enumerate() {
            let index = ReactionIndex(index);
            match &reaction.kind {
                plan::ReactionKind::Send(output) => {
                    let link = self.context.network.outputs[self.part][output.0];
                    let port = self.port(graph.links[link].from);
                    ports[port.0].reactions.push(index);
                }
                plan::ReactionKind::Copy { from, .. } => ports[from.0].reactions.push(index),
                plan::ReactionKind::Body { instance, reaction, arguments } => {
                    let class = self.class_of(*instance);
                    let declared = &described.classes[described.index[&class].0].reactions[*reaction - 1];
                    for (parameter, argument) in declared.parameters.iter().zip(arguments) {
                        if !parameter.triggers {
                            continue;
                        }
                        let add = |list: &mut Vec<ReactionIndex>| {
                            if list.last() != Some(&index) {
                                list.push(index);
                            }
                        };
                        if let Argument::Trigger(trigger) = argument {
                            add(&mut self.triggers[trigger.0].reactions);
                        }
                        argument.ports().iter().for_each(|port| add(&mut ports[port.0].reactions));
                    }
                    self.join_ends(class, *reaction, index);
                }
            }
        }
        for (position, trigger) in self.triggers.iter().enumerate() {
            if let plan::TriggerKind::Delay { source, .. } = trigger.kind {
                ports[source.0].delays.push(TriggerIndex(position));
            }
        }
        ports
    }

    fn class_of(&self, instance: InstanceIndex) -> crate::resolve::ClassId {
        self.context.program.tree.instances[self.members[instance.0]].class
    }

    /// Adds startup and shutdown, which are triggers without a variable.
    fn join_ends(&mut self, class: crate::resolve::ClassId, reaction: usize, index: ReactionIndex) {
        for parameter in &self.context.program.classes[class.0].reactions[reaction - 1].parameters {
            let source = match parameter.variable {
                Variable::Startup => Source::Startup,
                Variable::Shutdown => Source::Shutdown,
                Variable::Reset => Source::Reset,
                _ => continue,
            };
            if let Some(trigger) = self.sources.get(&source) {
                self.triggers[trigger.0].reactions.push(index);
            }
        }
    }

    fn described_modes(&self) -> Vec<plan::Mode> {
        let Context { program, places, .. } = *self.context;
        let described = |mode: &ModeInstanceId| {
            let mode = &program.tree.modes[*mode];
            let instance = &program.tree.instances[mode.instance];
            let declared = &program.class(mode.instance).ast.body.modes[mode.declared];
            let name = declared.name.as_ref().map_or("mode", |name| name.text.as_str());
            plan::Mode {
                path: format!("{}.{name}", instance.path),
                instance: self.instance_index(mode.instance),
                declared: mode.declared,
                parent: self.mode_index(instance.mode),
                initial: mode.initial,
                at: places.at(declared.span),
            }
        };
        self.modes.keys().map(described).collect()
    }

    fn finish(
        self,
        reactions: Vec<plan::ScheduledReaction>,
        ports: Vec<plan::Port>,
        diagnostics: &mut Diagnostics,
    ) -> plan::Federate {
        let Context { program, places, described, .. } = *self.context;
        let (tree, part) = (&program.tree, &program.parts.list[self.part]);
        let mut instances = Vec::new();
        for position in self.instances.keys() {
            let instance = &tree.instances[*position];
            instances.push(plan::Instance {
                path: instance.path.clone(),
                class: described.index[&instance.class],
                parent: instance.parent.and_then(|parent| self.instances.get(&parent).copied()),
                child: instance.child,
                bank_index: instance.bank_index,
                mode: self.mode_index(instance.mode),
                at: places.at(instance.span),
            });
        }
        let longest = reactions.len().max(ports.len()).max(self.triggers.len());
        if longest > usize::from(u16::MAX) {
            let message = format!("`{}` has {longest} reactions, ports or triggers, and 65535 is the most", part.name);
            diagnostics.push(Diagnostic::new(Code::TooLarge, tree.instances[part.top].span, message));
        }
        plan::Federate {
            id: u16::try_from(self.part).unwrap_or(u16::MAX),
            name: part.name.clone(),
            at: places.at(tree.instances[part.top].span),
            host: part.host.clone(),
            transient: part.is_transient,
            outputs: self.outputs(),
            inputs: self.inputs(),
            own_ports: self.context.network.own_ports[self.part].clone(),
            upstream: self.upstream(),
            downstream: self.downstream(),
            physical_delay_ns: physical::least_delay(self.context, self.part).filter(|_| !self.context.decentralized),
            instances,
            ports,
            modes: self.described_modes(),
            triggers: self.triggers,
            reactions,
        }
    }
}
