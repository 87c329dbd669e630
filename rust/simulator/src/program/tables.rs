// SPDX-License-Identifier: Apache-2.0
//! The model's tables of a federate, from the compiler's plan: what generated code has as constants.

use lf_compiler::plan::{self, Federate, Plan, ReactionIndex, SpacingPolicy};
use lf_model::time::Interval;
use lf_model::{
    ActionTiming, NetworkInput, NetworkOutput, OutputId, Policy, PortId, PortInfo, ReactionId, ReactionInfo,
    ReactionKind, Tables, TriggerId, TriggerInfo, TriggerKind,
};

use super::value::Shape;

/// Keeps something for as long as the process lives, as tables want it. Runs are many, so the process is not to live
/// for long.
pub(crate) fn keep<T>(list: Vec<T>) -> &'static [T] {
    list.leak()
}

fn keep_text(text: &str) -> &'static str {
    String::from(text).leak()
}

fn number(index: usize) -> u16 {
    u16::try_from(index).unwrap_or(u16::MAX)
}

pub(crate) fn trigger_id(index: plan::TriggerIndex) -> TriggerId {
    TriggerId(number(index.0))
}

pub(crate) fn port_id(index: plan::PortIndex) -> PortId {
    PortId(number(index.0))
}

fn reaction_ids(list: &[ReactionIndex]) -> &'static [ReactionId] {
    keep(list.iter().map(|index| ReactionId(number(index.0))).collect())
}

fn interval(ns: Option<i64>) -> Option<Interval> {
    ns.map(Interval::from_nanos)
}

/// The tables of a federate.
///
/// # Panics
/// When they contradict themselves, as generated code would not compile then.
pub(crate) fn tables(plan: &Plan, federate: &Federate) -> &'static Tables {
    let reactions = federate.reactions.iter().map(|reaction| ReactionInfo {
        name: keep_text(&reaction.name),
        level: reaction.level,
        deadline: interval(reaction.deadline_ns),
        tardy: plan.tardy(federate, reaction).is_some(),
        kind: match &reaction.kind {
            plan::ReactionKind::Body { .. } => ReactionKind::Body,
            plan::ReactionKind::Send(output) => ReactionKind::Send(OutputId(number(output.0))),
        },
    });
    let triggers = federate.triggers.iter().map(|trigger| TriggerInfo {
        name: keep_text(&trigger.path),
        kind: trigger_kind(&trigger.kind),
        reactions: reaction_ids(&trigger.reactions),
    });
    let ports = federate.ports.iter().map(|port| PortInfo {
        name: keep_text(&port.path),
        reactions: reaction_ids(&port.reactions),
        delays: keep(port.delays.iter().map(|trigger| trigger_id(*trigger)).collect()),
    });
    let tables = Tables {
        reactions: keep(reactions.collect()),
        triggers: keep(triggers.collect()),
        ports: keep(ports.collect()),
        outputs: keep(federate.outputs.iter().map(output).collect()),
        inputs: keep(federate.inputs.iter().map(|one| input(plan, federate, one)).collect()),
        absence: reaction_ids(&federate.absence()),
    };
    tables.check();
    Box::leak(Box::new(tables))
}

fn output(output: &plan::NetworkOutput) -> NetworkOutput {
    NetworkOutput {
        name: keep_text(&output.name),
        source: port_id(output.source),
        federate: output.federate,
        port: output.port,
        tells_absence: output.tells_absence,
        physical: output.physical,
        delay: interval(output.delay_ns),
        max_len: Shape::of(&output.ty.text).bytes_max(),
    }
}

fn input(plan: &Plan, federate: &Federate, input: &plan::NetworkInput) -> NetworkInput {
    let tardy = plan.is_decentralized() && !input.physical;
    NetworkInput {
        name: keep_text(&input.name),
        trigger: trigger_id(input.trigger),
        federate: input.federate,
        level: input.level,
        awaited: input.awaited,
        physical: input.physical,
        tardy,
        max_wait: Interval::from_nanos(input.max_wait_ns),
        absent_after: Interval::from_nanos(input.absent_after_ns),
        readers: if tardy { readers(federate, input) } else { &[] },
        delay: interval(input.delay_ns),
        max_len: Shape::of(&input.ty.text).bytes_max(),
    }
}

/// The reactions that see what an input brings, and are not triggered by it.
fn readers(federate: &Federate, input: &plan::NetworkInput) -> &'static [ReactionId] {
    let plan::TriggerKind::NetworkInput { fills, .. } = federate.triggers[input.trigger.0].kind else { return &[] };
    let sees = |reaction: &plan::ScheduledReaction| match &reaction.kind {
        plan::ReactionKind::Body { arguments, .. } => arguments.contains(&plan::Argument::Port(fills)),
        plan::ReactionKind::Send(_) => false,
    };
    let triggered = &federate.ports[fills.0].reactions;
    let all = federate.reactions.iter().enumerate().filter(|(_, reaction)| sees(reaction));
    let readers = all.map(|(index, _)| ReactionIndex(index)).filter(|index| !triggered.contains(index));
    reaction_ids(&readers.collect::<Vec<_>>())
}

fn trigger_kind(kind: &plan::TriggerKind) -> TriggerKind {
    match kind {
        plan::TriggerKind::Startup => TriggerKind::Startup,
        plan::TriggerKind::Shutdown => TriggerKind::Shutdown,
        plan::TriggerKind::Timer { offset_ns, period_ns, .. } => TriggerKind::Timer {
            offset: Interval::from_nanos(*offset_ns),
            period: Interval::from_nanos(period_ns.unwrap_or(0)),
        },
        plan::TriggerKind::Action { physical, min_delay_ns, min_spacing_ns, policy, .. } => {
            let timing = ActionTiming {
                min_delay: Interval::from_nanos(*min_delay_ns),
                min_spacing: interval(*min_spacing_ns),
                policy: match policy {
                    SpacingPolicy::Defer => Policy::Defer,
                    SpacingPolicy::Drop => Policy::Drop,
                    SpacingPolicy::Replace => Policy::Replace,
                    SpacingPolicy::Update => Policy::Update,
                },
            };
            if *physical { TriggerKind::Physical(timing) } else { TriggerKind::Logical(timing) }
        }
        plan::TriggerKind::Delay { fills, delay_ns, .. } => {
            TriggerKind::Delay { fills: port_id(*fills), delay: Interval::from_nanos(*delay_ns) }
        }
        plan::TriggerKind::NetworkInput { fills, .. } => TriggerKind::NetworkInput { fills: port_id(*fills) },
    }
}
