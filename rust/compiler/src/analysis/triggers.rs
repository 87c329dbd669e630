// SPDX-License-Identifier: Apache-2.0
//! The triggers of a federate, with the capacities of their queues.
//!
//! | queue | capacity |
//! |---|---|
//! | timer, watchdog, startup, shutdown | 1 |
//! | action | what is on its way by its minimum delay, and [`ACTION_CAPACITY`], because bodies can delay more |
//! | connection with `after` in a federate | what is on its way by the delay; an error if that is not known |
//! | connection between federates | what is on its way by twice the delay, as far as known, and [`NETWORK_CAPACITY`] |
//! | the same, decentralized | what is on its way by the delay and the longest wait: [`direct_capacity`] |
//!
//! `@capacity(n)` before the action, the connection or the input replaces these numbers. What is on its way follows
//! from the periods of timers and the minimum spacings of actions.

use super::builder::{FederateBuilder, Source};
use super::graph::{LinkId, StepId};
use super::rate::{Rate, Rates, direct_capacity, in_flight};
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Span};
use crate::instances::InstanceId;
use crate::plan::{self, InputIndex, SpacingPolicy, TriggerIndex, TriggerKind};
use crate::resolve::{CAPACITY_MAX, Variable};
use crate::syntax::ast::ActionKind;

/// The number of pending events that an action holds in addition to those that its minimum delay keeps in transit.
const ACTION_CAPACITY: usize = 8;

/// The number of messages that the queue of a network input holds in addition to those that the connection's delay
/// keeps in transit.
///
/// The RTI forwards messages of up to 16 tags that the receiver has not reached when the sender is past them. Up to 16
/// more can arrive when the federation agrees on a stop tag, because the answer of a blocked sender lies behind its
/// earlier messages: a federate begins this number of tags with messages before the RTI has read them. Where all
/// federates agree on a larger window, their receive buffers have room for the rest. The messages that the delay keeps
/// in transit count twice, because a next event that the RTI did not ask for can be announced later by as much.
pub const NETWORK_CAPACITY: usize = 16 + 16;

impl FederateBuilder<'_> {
    /// Adds every trigger that a reaction names, every delayed connection and every network input.
    pub(super) fn add_triggers(&mut self, diagnostics: &mut Diagnostics) {
        let context = self.context;
        let mut rates = Rates::new(context.graph);
        self.add_ends();
        let named = self.named_sources();
        for source in named {
            match source {
                Source::Timer(instance, timer) => self.add_timer(instance, timer, diagnostics),
                Source::Action(instance, action) => self.add_action(instance, action, &mut rates, diagnostics),
                _ => {}
            }
        }
        for (position, link) in context.graph.links.iter() {
            if link.is_delayed() && self.owns(context.graph.instance[link.to]) {
                self.add_delay(position, &mut rates, diagnostics);
            }
        }
        for (input, position) in context.network.inputs[self.part].iter().enumerate() {
            self.add_network_input(InputIndex(input), *position, &mut rates, diagnostics);
        }
    }

    fn add(&mut self, source: Source, trigger: plan::Trigger) {
        self.sources.insert(source, TriggerIndex(self.triggers.len()));
        self.triggers.push(trigger);
    }

    /// Returns the variables of all reactions of this federate, with the instances.
    fn variables(&self) -> Vec<(InstanceId, Variable)> {
        let graph = self.context.graph;
        let mut variables = Vec::new();
        for (position, step) in graph.steps.iter().filter(|(_, step)| self.owns(step.instance)) {
            let reaction = graph.reaction(position);
            let parameters = reaction.into_iter().flat_map(|reaction| &reaction.parameters);
            variables.extend(parameters.map(|parameter| (step.instance, parameter.variable)));
        }
        variables
    }

    fn add_ends(&mut self) {
        let variables = self.variables();
        for (variable, source, path, kind) in [
            (Variable::Startup, Source::Startup, "startup", TriggerKind::Startup),
            (Variable::Shutdown, Source::Shutdown, "shutdown", TriggerKind::Shutdown),
            (Variable::Reset, Source::Reset, "reset", TriggerKind::Reset),
        ] {
            // A mode that is entered for the first time needs it, too.
            let is_entry = variable == Variable::Reset && !self.modes.is_empty();
            if is_entry || variables.iter().any(|(_, used)| *used == variable) {
                let (path, reactions) = (path.to_owned(), Vec::new());
                self.add(source, plan::Trigger { path, kind, capacity: 1, reactions, mode: None, at: None });
            }
        }
    }

    /// Returns the timers and actions that a reaction names, in the order of instances and declarations, timers first.
    fn named_sources(&self) -> Vec<Source> {
        let mut sources: Vec<_> = self
            .variables()
            .into_iter()
            .filter_map(|(instance, variable)| match variable {
                Variable::Timer(timer) => Some((instance, Source::Timer(instance, timer))),
                Variable::Action(action) => Some((instance, Source::Action(instance, action))),
                _ => None,
            })
            .collect();
        sources.sort_unstable();
        sources.dedup();
        sources.into_iter().map(|(_, source)| source).collect()
    }

    fn add_timer(&mut self, instance: InstanceId, timer: usize, diagnostics: &mut Diagnostics) {
        let program = self.context.program;
        let tree = &program.tree;
        let declared = program.class(instance).timers[timer];
        let mut time = |value: Option<&_>| value.and_then(|value| program.time(instance, value, diagnostics));
        let offset_ns = time(declared.offset.as_ref()).unwrap_or_default();
        let period = time(declared.period.as_ref());
        let kind = TriggerKind::Timer {
            instance: self.instance_index(instance),
            offset_ns,
            period_ns: period.filter(|ns| *ns > 0 && *ns != i64::MAX),
        };
        let path = format!("{}.{}", tree.instances[instance].path, declared.name.text);
        let at = Some(self.context.places.at(declared.name.span));
        let mode = self.mode_index(tree.mode_of(instance, declared.mode));
        let trigger = plan::Trigger { path, kind, capacity: 1, reactions: Vec::new(), mode, at };
        self.add(Source::Timer(instance, timer), trigger);
    }

    fn add_action(
        &mut self,
        instance: InstanceId,
        action: usize,
        rates: &mut Rates<'_>,
        diagnostics: &mut Diagnostics,
    ) {
        let program = self.context.program;
        let tree = &program.tree;
        let class = program.class(instance);
        let declared = &class.actions[action];
        let mut time = |value: Option<&_>| value.and_then(|value| program.time(instance, value, diagnostics));
        let (span, kind) = (declared.ast.name.span, declared.ast.kind);
        let min_delay_ns = time(declared.ast.min_delay.as_ref()).unwrap_or_default();
        let min_spacing_ns = time(declared.ast.min_spacing.as_ref()).filter(|ns| *ns > 0);
        let replaces = class.language.facts().replaces_events;
        let policy = match declared.ast.policy.as_ref().map(|policy| policy.text.as_str()) {
            Some("drop") => SpacingPolicy::Drop,
            Some("replace") => SpacingPolicy::Replace,
            Some("update") => SpacingPolicy::Update,
            None if replaces && kind == ActionKind::Logical && min_spacing_ns.is_none() => SpacingPolicy::Replace,
            _ => SpacingPolicy::Defer,
        };
        let capacity = declared.capacity.unwrap_or_else(|| {
            if kind == ActionKind::Watchdog {
                return 1;
            }
            let rate = rates.of_steps(&self.schedulers(instance, action));
            let derived = in_flight(&rate.streams, min_delay_ns);
            bounded(derived.saturating_add(ACTION_CAPACITY), span, diagnostics)
        });
        let index = self.instance_index(instance);
        let kind = match kind {
            ActionKind::Watchdog => TriggerKind::Watchdog { instance: index, timeout_ns: min_delay_ns },
            ActionKind::Logical | ActionKind::Physical => TriggerKind::Action {
                instance: index,
                physical: kind == ActionKind::Physical,
                ty: self.context.places.ty(&declared.ty, declared.ty_span),
                min_delay_ns,
                min_spacing_ns,
                policy,
            },
        };
        let path = format!("{}.{}", tree.instances[instance].path, declared.ast.name.text);
        let at = Some(self.context.places.at(span));
        let mode = self.mode_index(tree.mode_of(instance, declared.ast.mode));
        let trigger = plan::Trigger { path, kind, capacity, reactions: Vec::new(), mode, at };
        self.add(Source::Action(instance, action), trigger);
    }

    /// Returns the reactions that can schedule an action.
    fn schedulers(&self, instance: InstanceId, action: usize) -> Vec<StepId> {
        let graph = self.context.graph;
        let schedules = |step: &StepId| {
            let mut effects = graph.reaction(*step).into_iter().flat_map(|reaction| &reaction.parameters);
            effects.any(|it| it.effect && it.variable == Variable::Action(action))
        };
        graph.reactions_of(instance).filter(schedules).collect()
    }

    /// Returns the capacity that the program sets for a connection, at itself or at its destination.
    fn given_capacity(&self, link: LinkId) -> Option<usize> {
        let graph = self.context.graph;
        let link = &graph.links[link];
        link.capacity.or(graph.port(link.to).capacity)
    }

    fn add_delay(&mut self, position: LinkId, rates: &mut Rates<'_>, diagnostics: &mut Diagnostics) {
        let graph = self.context.graph;
        let link = &graph.links[position];
        let delay_ns = link.delay.unwrap_or_default();
        let rate = rates.of_port_in(graph.root[link.from], link.mode);
        // One value waits for the next microstep while the previous one is present.
        if link.physical {
            // As for a physical action, the lead of physical time over the tag is unknown.
            let derived = in_flight(&rate.streams, delay_ns).saturating_add(ACTION_CAPACITY);
            let capacity = self.given_capacity(position).unwrap_or_else(|| bounded(derived, link.span, diagnostics));
            let (source, fills) = (self.port(link.from), self.port(link.to));
            self.add_link(position, TriggerKind::Delay { source, fills, delay_ns, physical: true }, capacity);
            return;
        }
        let derived = if delay_ns == 0 { 2 } else { in_flight(&rate.streams, delay_ns) };
        let capacity = match self.given_capacity(position) {
            Some(capacity) => {
                if rate.complete && capacity < derived {
                    let message = format!("{derived} values can be on their way here, and the capacity is {capacity}");
                    let hint = "the program ends with an error when the queue is full; raise the capacity";
                    diagnostics.push_for_channel(Diagnostic::new(Code::SmallCapacity, link.span, message).hint(hint));
                }
                capacity
            }
            None if rate.complete || delay_ns == 0 => bounded(derived, link.span, diagnostics),
            None => {
                let name = self.link_name(position);
                let message = format!("how many values of `{name}` are on their way at the same time is not known");
                let hint = "its source can be written at any rate, and the program ends with an error when the queue \
                            is full: write `@capacity(n)` before the connection, or give the action that causes it a \
                            minimum spacing";
                diagnostics.push_for_channel(Diagnostic::new(Code::UnknownCapacity, link.span, message).hint(hint));
                bounded(derived.saturating_add(ACTION_CAPACITY), link.span, diagnostics)
            }
        };
        let kind =
            TriggerKind::Delay { source: self.port(link.from), fills: self.port(link.to), delay_ns, physical: false };
        self.add_link(position, kind, capacity);
    }

    fn add_network_input(
        &mut self,
        input: InputIndex,
        position: LinkId,
        rates: &mut Rates<'_>,
        diagnostics: &mut Diagnostics,
    ) {
        let graph = self.context.graph;
        let link = &graph.links[position];
        let rate = rates.of_port_in(graph.root[link.from], link.mode);
        let delay_ns = link.delay.unwrap_or_default();
        let is_direct = self.context.decentralized && !link.physical;
        let given = self.given_capacity(position);
        let capacity = given.unwrap_or_else(|| {
            if is_direct {
                let derived = direct_capacity(&rate.streams, delay_ns, self.wait_ns());
                return bounded(derived, link.span, diagnostics);
            }
            if !rate.complete && delay_ns > 0 && !link.physical && self.is_in_cycle(position) {
                let message =
                    format!("how many values of `{}` can be on their way is not known", self.link_name(position));
                let hint = "in a cycle of federates the queue has to hold them all, or the program ends with an error: \
                            write `@capacity(n)` before the connection, or give the action that causes it a minimum \
                            spacing";
                diagnostics.push_for_channel(Diagnostic::new(Code::UnknownCapacity, link.span, message).hint(hint));
            }
            let derived = in_flight(&rate.streams, delay_ns.saturating_mul(2));
            bounded(derived.saturating_add(NETWORK_CAPACITY), link.span, diagnostics)
        });
        if is_direct {
            self.report_overflow(position, &rate, capacity, diagnostics);
        }
        self.spacings.push(rate.complete.then_some(rate.streams));
        let kind = TriggerKind::NetworkInput { input, fills: self.port(link.to) };
        self.add_link(position, kind, capacity);
    }

    /// Reports a queue that receives more messages during a wait than it holds, if that is certain.
    fn report_overflow(&self, position: LinkId, rate: &Rate, capacity: usize, diagnostics: &mut Diagnostics) {
        let link = &self.context.graph.links[position];
        let coming = in_flight(&rate.streams, link.delay.unwrap_or_default().saturating_add(self.wait_ns()));
        if !rate.complete || coming <= capacity {
            return;
        }
        let name = self.link_name(position);
        let message =
            format!("{coming} values can come over `{name}` while its receiver waits, and its queue holds {capacity}");
        let hint = format!(
            "when the connection's buffers are full as well, the sender is held up, and late elsewhere: write \
             `@capacity({coming})` before the connection, or wait for a shorter time",
        );
        diagnostics.push_for_channel(Diagnostic::new(Code::SmallCapacity, link.span, message).hint(hint));
    }

    /// Returns the maximum time for which a wait of this federate elsewhere can block a message, without infinite
    /// waits, during which the number of messages is unknown.
    fn wait_ns(&self) -> i64 {
        let inputs = self.context.network.inputs[self.part].iter().map(|input| self.context.waits[*input]);
        let waits = inputs.map(|waits| waits.max_wait_ns.saturating_add(waits.absent_after_ns));
        waits.filter(|wait| *wait != i64::MAX).max().unwrap_or_default()
    }

    /// Returns whether a value on this connection can come back to the federate that sends it.
    fn is_in_cycle(&self, link: LinkId) -> bool {
        let graph = self.context.graph;
        let from = graph.part(graph.links[link].from);
        from.is_some_and(|from| self.context.cycles.is_common(from, self.part))
    }

    fn add_link(&mut self, position: LinkId, kind: TriggerKind, capacity: usize) {
        let graph = self.context.graph;
        let link = &graph.links[position];
        let path = graph.path(link.to);
        let at = Some(self.context.places.at(link.span));
        let mode = self.mode_index(link.mode);
        let trigger = plan::Trigger { path, kind, capacity, reactions: Vec::new(), mode, at };
        self.add(Source::Link(position), trigger);
    }
}

/// Reports a capacity that no queue can have.
fn bounded(capacity: usize, span: Span, diagnostics: &mut Diagnostics) -> usize {
    if capacity <= CAPACITY_MAX {
        return capacity;
    }
    let count = if capacity == usize::MAX { "too many".to_owned() } else { capacity.to_string() };
    let message = format!("{count} events can be on their way here at the same time, and {CAPACITY_MAX} is the most");
    let hint = "shorten the delay, lengthen the period of what causes it, or write `@capacity(n)`";
    diagnostics.push(Diagnostic::new(Code::UnboundedCapacity, span, message).hint(hint));
    1
}
