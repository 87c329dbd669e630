// SPDX-License-Identifier: Apache-2.0
//! The model's tables of a federate, which generated code has as constants, from the compiler's own derivation.

use lf_compiler::tables::{self, HandedOverRow, InputRow, OutputRow};
use lf_model::{
    HandedOver, Job, ModeEvents, ModeInfo, Modes, NetworkInput, NetworkOutput, PortInfo, ReactionInfo, Tables,
    TriggerInfo, Worker, WorkerPool,
};
use lf_testkit::random::mix;

use super::value::Shape;

/// Keeps a list for the lifetime of the process, as tables require. Because runs are many, the process should be
/// short-lived.
pub(crate) fn keep<T>(list: Vec<T>) -> &'static [T] {
    list.leak()
}

fn keep_text(text: &str) -> &'static str {
    String::from(text).leak()
}

/// Returns the tables of a federate.
///
/// # Panics
/// If they contradict themselves; generated code would not compile then.
pub(crate) fn tables(planned: &tables::Tables<'_>, runs: Runs) -> &'static Tables {
    let reactions = planned.reactions.iter().map(|reaction| ReactionInfo {
        name: keep_text(reaction.name),
        level: reaction.level,
        deadline: reaction.deadline,
        tardy: reaction.tardy,
        kind: reaction.kind,
    });
    let triggers = planned.triggers.iter().map(|trigger| TriggerInfo {
        name: keep_text(trigger.name),
        kind: trigger.kind,
        reactions: keep(trigger.reactions.clone()),
    });
    let ports = planned.ports.iter().map(|port| PortInfo {
        name: keep_text(port.name),
        reactions: keep(port.reactions.clone()),
        delays: keep(port.delays.clone()),
    });
    let tables = Tables {
        reactions: keep(reactions.collect()),
        triggers: keep(triggers.collect()),
        ports: keep(ports.collect()),
        outputs: keep(planned.outputs.iter().map(output).collect()),
        inputs: keep(planned.inputs.iter().map(input).collect()),
        own_ports: keep(planned.own_ports.to_vec()),
        handed_over: keep(planned.handed_over.iter().map(handed_over).collect()),
        absence: keep(planned.absence.clone()),
        modes: (!planned.modes.is_empty()).then(|| modes(planned)),
        workers: if runs == Runs::OneByOne { 1 } else { 3 },
    };
    tables.check();
    Box::leak(Box::new(tables))
}

/// The way in which the reactions of a level run.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Runs {
    OneByOne,
    /// Sequentially, in an order that parallel execution could produce.
    Shuffled,
}

/// Runs jobs sequentially, but each by some worker and in a shuffled order. They are closures that share no mutable
/// state, so threads could not produce other results.
pub(super) struct Shuffled;

impl WorkerPool for Shuffled {
    fn run(&self, workers: &mut [Worker<'_>], jobs: &mut [Job<'_>]) {
        let count = jobs.len() as u64;
        let mut jobs: Vec<_> = (0..).map(|index| mix(index ^ mix(count))).zip(jobs).collect();
        jobs.sort_by_key(|(number, _)| *number);
        for (number, job) in jobs {
            let worker = (number >> 32) as usize % workers.len();
            workers[worker].run(job);
        }
    }
}

fn modes(planned: &tables::Tables<'_>) -> &'static Modes {
    let modes = planned.modes.iter().map(|mode| ModeInfo {
        name: keep_text(mode.name),
        instance: mode.instance,
        parent: mode.parent,
        initial: mode.initial,
    });
    let reactions = planned.reactions.iter().map(|reaction| reaction.mode);
    let (reactions, triggers) = (keep(reactions.collect()), keep(planned.mode_triggers()));
    let tables::ModeEvents { entry, startup, reset, shutdown } = planned.mode_events();
    let events = ModeEvents {
        entry,
        startup: keep(startup.to_vec()),
        reset: keep(reset.to_vec()),
        shutdown: keep(shutdown.to_vec()),
    };
    let modes = Modes::new(keep(modes.collect()), reactions, triggers, events);
    Box::leak(Box::new(modes))
}

fn handed_over(row: &HandedOverRow<'_>) -> HandedOver {
    HandedOver { name: keep_text(&row.name), id: row.id, max_len: size_of::<u64>() }
}

fn output(output: &OutputRow<'_>) -> NetworkOutput {
    NetworkOutput {
        name: keep_text(output.name),
        source: output.source,
        federate: output.federate,
        port: output.port,
        tells_absence: output.tells_absence,
        physical: output.physical,
        delay: output.delay,
        max_len: Shape::of(&output.ty.text).bytes_max(),
    }
}

fn input(input: &InputRow<'_>) -> NetworkInput {
    NetworkInput {
        name: keep_text(input.name),
        trigger: input.trigger,
        federate: input.federate,
        level: input.level,
        awaited: input.awaited,
        physical: input.physical,
        tardy: input.tardy,
        max_wait: input.max_wait,
        absent_after: input.absent_after,
        readers: keep(input.readers.clone()),
        delay: input.delay,
        max_len: Shape::of(&input.ty.text).bytes_max(),
    }
}
