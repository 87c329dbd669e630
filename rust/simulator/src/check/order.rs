// SPDX-License-Identifier: Apache-2.0
//! Checks that reactions at one tag of which one writes state that the other reads run in the same order, federated or
//! not.
//!
//! A run shows an order only if chance triggers both reactions, so this check compares the plans.

use std::collections::{BTreeMap, BTreeSet};

use lf_compiler::plan::{Federate, ModeIndex, Plan, ReactionKind, ScheduledReaction, TriggerKind};

use super::Violation;

/// State that reactions share.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Shared {
    State(usize),
    Port(usize),
}

/// The state that a reaction shares with others, and whether it writes it.
type Accesses = BTreeMap<Shared, bool>;

/// Compares the order of reactions in the plan of a federation with that in the plan of the same program unfederated.
pub(crate) fn order(federated: &Plan, alone: &Plan) -> Option<Violation> {
    let alone = alone.federates.first()?;
    let places: BTreeMap<&str, usize> =
        alone.reactions.iter().enumerate().map(|(place, reaction)| (reaction.name.as_str(), place)).collect();
    federated.federates.iter().enumerate().find_map(|(number, federate)| {
        let accesses: Vec<_> = federate.reactions.iter().map(|it| accesses(it, federate, federated)).collect();
        let last = last_reactions(federate);
        for (place, first) in federate.reactions.iter().enumerate() {
            for (other, second) in federate.reactions.iter().enumerate().skip(place + 1) {
                let can_meet = last.contains(&place) || last.contains(&other) || !exclude(first, second, federate);
                let swapped = places.get(first.name.as_str()) > places.get(second.name.as_str());
                if swapped && can_meet && is_shared(&accesses[place], &accesses[other]) {
                    let (first, second) = (first.name.clone(), second.name.clone());
                    return Some(Violation::Unordered { federate: number, first, second });
                }
            }
        }
        None
    })
}

fn accesses(reaction: &ScheduledReaction, federate: &Federate, plan: &Plan) -> Accesses {
    let mut accesses = Accesses::new();
    match &reaction.kind {
        // Without federates, no reaction sends.
        ReactionKind::Send(_) => {}
        ReactionKind::Copy { from, to } => accesses.extend([(Shared::Port(from.0), false), (Shared::Port(to.0), true)]),
        ReactionKind::Body { instance, reaction, arguments } => {
            accesses.insert(Shared::State(instance.0), true);
            let declared = &plan.class(&federate.instances[instance.0]).reactions[*reaction - 1];
            for (parameter, argument) in declared.parameters.iter().zip(arguments) {
                for port in argument.ports() {
                    *accesses.entry(Shared::Port(port.0)).or_default() |= parameter.effect;
                }
            }
        }
    }
    accesses
}

fn is_shared(one: &Accesses, other: &Accesses) -> bool {
    one.iter().any(|(what, changes)| other.get(what).is_some_and(|too| *changes || *too))
}

/// Returns the reactions that run at the last tag, whether or not their mode is active.
fn last_reactions(federate: &Federate) -> BTreeSet<usize> {
    let shutdown = federate.triggers.iter().filter(|trigger| trigger.kind == TriggerKind::Shutdown);
    shutdown.flat_map(|trigger| &trigger.reactions).map(|reaction| reaction.0).collect()
}

/// Returns whether the modes of two reactions are never active at one tag.
fn exclude(one: &ScheduledReaction, other: &ScheduledReaction, federate: &Federate) -> bool {
    let mode = |mode: &ModeIndex| &federate.modes[mode.0];
    let around = |innermost| std::iter::successors(innermost, move |it: &ModeIndex| mode(it).parent);
    let apart = |one: ModeIndex, other: ModeIndex| one != other && mode(&one).instance == mode(&other).instance;
    around(one.mode).any(|one| around(other.mode).any(|other| apart(one, other)))
}
