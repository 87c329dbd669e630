// SPDX-License-Identifier: Apache-2.0
//! The struct that owns all parts of a federate: the purposes of its fields, their places, and the names of the inboxes
//! of physical actions.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::Ident;

use super::identifiers::{give, ident};
use super::places::{ArrayUses, Group, PlaceExpression};
use crate::emit::Job;
use crate::emit::names::{Names, snake_case};
use crate::plan::{Argument, ClassIndex, Federate, Plan, ReactionKind, TriggerKind};
use crate::tables::{Cell, Tables};

/// The struct that owns all state, ports and queues of a federate.
pub(in crate::emit) struct Owner<'p> {
    pub(in crate::emit) job: &'p Job<'p>,
    pub(in crate::emit) plan: &'p Plan,
    pub(in crate::emit) federate: &'p Federate,
    pub(in crate::emit) tables: Tables<'p>,
    pub(in crate::emit) symbols: Identifiers,
}

impl<'p> Owner<'p> {
    pub(in crate::emit) fn new(job: &'p Job<'p>, federate: &'p Federate) -> Self {
        let tables = Tables::of(job.plan(), federate);
        // Jobs of several threads each have fields of their own.
        let arrays = if job.workers() > 1 { Arrays::default() } else { Arrays::new(job.plan(), federate, &tables) };
        let symbols = Identifiers::new(federate, &tables, arrays);
        Self { job, plan: job.plan(), federate, tables, symbols }
    }

    /// Returns the place expression of a port.
    pub(in crate::emit) fn port_place(&self, port: usize) -> String {
        let queued = if self.tables.ports[port].filled_by.is_some() { ".port" } else { "" };
        format!("{}{queued}", self.symbols.ports[port])
    }

    /// Returns the place expression of an array of these ports, in this order, if there is one.
    pub(in crate::emit) fn array_of(&self, ports: &[usize]) -> Option<String> {
        let mut arrays = self.symbols.arrays.ports.iter();
        arrays.any(|group| group.is_whole(ports)).then(|| self.symbols.ports[ports[0]].around())
    }
}

/// The arrays of each kind of parts.
#[derive(Default)]
pub(in crate::emit) struct Arrays {
    pub(in crate::emit) instances: Vec<Group>,
    pub(in crate::emit) triggers: Vec<Group>,
    pub(in crate::emit) ports: Vec<Group>,
}

impl Arrays {
    fn new(plan: &Plan, federate: &Federate, tables: &Tables<'_>) -> Self {
        let (instances, triggers, ports) = (&federate.instances, &federate.triggers, &federate.ports);
        let kept = |at: usize| !plan.class(&instances[at]).reactions.is_empty();
        let of_instances = Group::of(instances.iter().map(|instance| &*instance.path), |one, other| {
            instances[one].class == instances[other].class && kept(one)
        });
        let of_triggers = Group::of(triggers.iter().map(|trigger| &*trigger.path), |one, other| {
            let [row, like] = [one, other].map(|at| &tables.triggers[at]);
            matches!(row.cell, Cell::Timer | Cell::Logical | Cell::Watchdog)
                && (row.cell, row.capacity) == (like.cell, like.capacity)
                && triggers[one].at.is_some()
                && value_type(&triggers[one].kind) == value_type(&triggers[other].kind)
        });
        let classes: BTreeMap<&str, ClassIndex> =
            instances.iter().map(|instance| (&*instance.path, instance.class)).collect();
        let owner_of = |port: usize| ports[port].path.rsplit_once('.').and_then(|(owner, _)| classes.get(owner));
        let mut of_ports = Group::of(ports.iter().map(|port| &*port.path), |one, other| {
            [one, other].iter().all(|at| tables.ports[*at].filled_by.is_none())
                && ports[one].ty.text == ports[other].ty.text
                && owner_of(one) == owner_of(other)
        });
        let refused = port_clashes(plan, federate, &of_ports);
        let mut at = 0..;
        of_ports.retain(|_| at.next().is_some_and(|at| !refused.contains(&at)));
        Self { instances: of_instances, triggers: of_triggers, ports: of_ports }
    }
}

/// Returns the type of an action's values.
fn value_type(kind: &TriggerKind) -> Option<&str> {
    match kind {
        TriggerKind::Action { ty, .. } => Some(&ty.text),
        _ => None,
    }
}

/// Returns the groups of ports that a reaction uses so that they cannot be arrays.
fn port_clashes(plan: &Plan, federate: &Federate, groups: &[Group]) -> BTreeSet<usize> {
    let of = groups.iter().enumerate().flat_map(|(at, group)| group.parts.iter().map(move |part| (*part, at)));
    let of: BTreeMap<usize, usize> = of.collect();
    let uses = |kind: &ReactionKind| {
        let mut uses = ArrayUses::default();
        match kind {
            ReactionKind::Body { instance, reaction, arguments } => {
                let declared = &plan.class(&federate.instances[instance.0]).reactions[reaction - 1];
                for (parameter, argument) in declared.parameters.iter().zip(arguments) {
                    uses.add(groups, &of, &numbers(argument), parameter.is_mutable());
                }
            }
            ReactionKind::Copy { from, to } => {
                uses.add(groups, &of, &[from.0], false);
                uses.add(groups, &of, &[to.0], true);
            }
            ReactionKind::Send(_) => {}
        }
        uses.clashes()
    };
    federate.reactions.iter().flat_map(|reaction| uses(&reaction.kind)).collect()
}

/// Returns the numbers of the ports behind an argument.
pub(in crate::emit) fn numbers(argument: &Argument) -> Vec<usize> {
    argument.ports().iter().map(|port| port.0).collect()
}

/// All names, each unique, and the places that they name.
pub(in crate::emit) struct Identifiers {
    /// The variable that holds the federated reactor during the construction of the instances.
    pub(in crate::emit) main: Ident,
    /// The variables that hold the instances meanwhile.
    pub(in crate::emit) locals: Vec<Ident>,
    pub(in crate::emit) instances: Vec<PlaceExpression>,
    /// A port that a trigger fills lies in the trigger's field, so the two share their place.
    pub(in crate::emit) ports: Vec<PlaceExpression>,
    pub(in crate::emit) triggers: Vec<PlaceExpression>,
    /// The names by trigger; unused for those that are no physical actions.
    pub(in crate::emit) inboxes: Vec<Ident>,
    pub(in crate::emit) arrays: Arrays,
}

impl Identifiers {
    fn new(federate: &Federate, tables: &Tables<'_>, arrays: Arrays) -> Self {
        let (mut fields, mut statics) = (Names::default(), Names::reserving(&["TABLES", "FEDERATION", "DESCRIPTION"]));
        let main = ident(&fields.give("main"));
        let mut field = |path: &str| give(&mut fields, &ident(&snake_case(path)));
        let locals: Vec<Ident> = federate.instances.iter().map(|instance| field(&instance.path)).collect();
        let instances =
            places(&arrays.instances, locals.len(), &mut field, |at, _| PlaceExpression::field(locals[at].clone()));
        let triggers = places(&arrays.triggers, tables.triggers.len(), &mut field, |at, field| {
            PlaceExpression::field(field(tables.triggers[at].name))
        });
        let ports =
            places(&arrays.ports, tables.ports.len(), &mut field, |at, field| match tables.ports[at].filled_by {
                Some(trigger) => triggers[usize::from(trigger.0)].clone(),
                None => PlaceExpression::field(field(tables.ports[at].name)),
            });
        let inbox = |path: &str| ident(&statics.give(&format!("{}_INBOX", snake_case(path).to_uppercase())));
        let inboxes = tables.triggers.iter().map(|trigger| trigger.name).map(inbox).collect();
        Self { main, locals, instances, ports, triggers, inboxes, arrays }
    }
}

/// Returns the places of parts: elements of the arrays, and for all others what `single` returns. `field` gives a field
/// a name.
fn places<F: FnMut(&str) -> Ident>(
    arrays: &[Group],
    count: usize,
    field: &mut F,
    mut single: impl FnMut(usize, &mut F) -> PlaceExpression,
) -> Vec<PlaceExpression> {
    let mut elements: BTreeMap<usize, PlaceExpression> = BTreeMap::new();
    for array in arrays {
        elements.extend(array.places(&field(&array.name())));
    }
    (0..count).map(|part| elements.remove(&part).unwrap_or_else(|| single(part, field))).collect()
}
