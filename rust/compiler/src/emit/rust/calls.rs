// SPDX-License-Identifier: Apache-2.0
//! The calls of the methods of reactions.

use std::fmt::Write as _;

use lf_model::{ReactionId, TriggerId};

use super::reactor::{handover_methods, reaction_method, reset_method};
use crate::emit::host::{Owner, ReactionPart, ids, numbers};
use crate::plan::{Argument, InstanceIndex, ReactionKind, ScheduledReaction, VariableKind};
use crate::tables::HandedOverRow;

/// Returns one arm per mode with `reset` state variables.
pub(super) fn modes(owner: &Owner<'_>) -> Vec<String> {
    let arm = |(id, resets): (usize, Vec<(InstanceIndex, Option<usize>)>)| {
        let mut calls = String::new();
        for (instance, of) in &resets {
            let (place, method) = (&owner.symbols.instances[instance.0], reset_method(*of));
            // Writing to a String cannot fail.
            let _ = write!(calls, "{place}.{method}(); ");
        }
        (!calls.is_empty()).then(|| format!("ModeId({id}) => {{ {calls}}}"))
    };
    owner.plan.resets(owner.federate).into_iter().enumerate().filter_map(arm).collect()
}

/// Returns one arm per state that is handed over: the calls that write its value, and those that set it.
pub(super) fn handovers(owner: &Owner<'_>) -> [Vec<String>; 2] {
    let call = |which: usize| {
        let arm = |(number, row): (usize, &HandedOverRow<'_>)| {
            let (place, methods) = (&owner.symbols.instances[row.instance.0], handover_methods(&row.state.name));
            format!("{number} => {place}.{}(bytes)", methods[which])
        };
        owner.tables.handed_over.iter().enumerate().map(arm).collect()
    };
    [call(0), call(1)]
}

/// Returns one call per reaction that has this part, and for bodies per connection that copies.
pub(super) fn of_reactions(owner: &Owner<'_>, part: ReactionPart) -> Vec<(usize, String)> {
    let numbered = |(id, reaction): (usize, &ScheduledReaction)| {
        let call = match &reaction.kind {
            ReactionKind::Copy { from, to } if part == ReactionPart::Body => {
                format!("ctx.copy(&{}, &mut {})", owner.port_place(from.0), owner.port_place(to.0))
            }
            _ => call(owner, reaction, part)?,
        };
        Some((id, call))
    };
    owner.federate.reactions.iter().enumerate().filter_map(numbered).collect()
}

/// Returns the call of the method that runs a part of a reaction, if there is one.
fn call(owner: &Owner<'_>, reaction: &ScheduledReaction, part: ReactionPart) -> Option<String> {
    let ReactionKind::Body { instance, reaction: number, arguments } = &reaction.kind else { return None };
    let declared = &owner.plan.class(&owner.federate.instances[instance.0]).reactions[number - 1];
    let method = reaction_method(*number, part.run(declared)?);
    let place = &owner.symbols.instances[instance.0];
    let arguments = declared.parameters.iter().zip(arguments).map(|(parameter, argument)| {
        let mutable = if parameter.is_mutable() { "mut " } else { "" };
        match argument {
            Argument::Port(place) => format!(", &{mutable}{}", owner.port_place(place.0)),
            Argument::Ports(ports) | Argument::Bank { ports, .. } => {
                let (name, each) =
                    if mutable.is_empty() { ("Multiport", "each_ref") } else { ("MultiportMut", "each_mut") };
                let places = || ports.iter().map(|port| format!("&{mutable}{}", owner.port_place(port.0)));
                let all = match owner.array_of(&numbers(argument)) {
                    Some(array) => format!("{array}.{each}()"),
                    None => format!("[{}]", places().collect::<Vec<_>>().join(", ")),
                };
                format!(", &{mutable}{name}::new(&{mutable}{all})")
            }
            Argument::Trigger(trigger) => format!(", &{mutable}{}", owner.symbols.triggers[trigger.0]),
            Argument::Mode(mode) => {
                let is_history = matches!(parameter.kind, VariableKind::Mode { history: true });
                format!(", Transition::{}(ModeId({mode}))", if is_history { "history" } else { "reset" })
            }
        }
    });
    Some(format!("{place}.{method}(ctx{})", arguments.collect::<String>()))
}

/// Returns one arm per level at which several instances have reactions, if there are threads for them.
pub(super) fn levels(owner: &Owner<'_>) -> Vec<String> {
    owner.levels(|_, reactions| job(owner, reactions))
}

/// Returns the reactions of one instance as a job.
fn job(owner: &Owner<'_>, reactions: &[ReactionId]) -> String {
    let (mut actions, mut calls) = (Vec::new(), Vec::new());
    for id in reactions {
        let reaction = &owner.federate.reactions[usize::from(id.0)];
        let ReactionKind::Body { instance, reaction: number, arguments } = &reaction.kind else { continue };
        let declared = &owner.plan.class(&owner.federate.instances[instance.0]).reactions[number - 1];
        actions.extend(declared.parameters.iter().zip(arguments).filter_map(|(parameter, argument)| match argument {
            Argument::Trigger(trigger) if parameter.effect => Some(TriggerId(u16::try_from(trigger.0).ok()?)),
            _ => None,
        }));
        let only = if reactions.len() == 1 { "_".to_owned() } else { format!("{id:?}") };
        calls.extend(
            call(owner, reaction, ReactionPart::MissedDeadline)
                .map(|call| format!("({only}, Part::MissedDeadline) => {call}")),
        );
        let handles = call(owner, reaction, ReactionPart::Tardy).filter(|_| owner.tables.has_tardy_inputs());
        calls.extend(handles.map(|call| format!("({only}, Part::Tardy) => {call}")));
        let body = call(owner, reaction, ReactionPart::Body);
        calls.extend(body.map(|call| format!("({only}, _) => {call}")));
    }
    let run = match &calls[..] {
        [only] => only.replacen("(_, _) => ", "|_, _, ctx| ", 1),
        _ if reactions.len() == 1 => format!("|id, part, ctx| match (id, part) {{ {} }}", calls.join(", ")),
        _ => format!("|id, part, ctx| match (id, part) {{ {}, _ => {{}} }}", calls.join(", ")),
    };
    format!("Job::new({}, {}, &mut {run})", ids(reactions), ids(&actions))
}
