// SPDX-License-Identifier: Apache-2.0
//! A trial: compiles a scenario, runs it, runs it unfederated, and judges the results.

use std::path::Path;
use std::{fs, io};

use lf_compiler::plan::Plan;
use lf_compiler::trace_names::{self, TraceNames};
use lf_model::time::Tag;
use lf_runtime::Coordination;

use crate::check::{self, Expected, Violation};
use crate::compile::compile_text;
use crate::coverage::Coverage;
use crate::program::{Played, Record, Runs};
use crate::run::{Decided, Joined, OutputOptions, Report, run, run_alone};
use crate::scenario::{Decentralized, Form, RICH, Scenario, player, source};
use crate::{Kind, waits};

/// The results of a trial.
#[derive(Debug)]
pub(crate) struct Trial {
    pub(crate) violation: Option<Violation>,
    pub(crate) coverage: Coverage,
    /// The number of reactions that ran, in all federates.
    pub(crate) events: u64,
    /// The number of messages on all connections.
    pub(crate) messages: u64,
    /// A hash of the whole run.
    pub(crate) digest: u64,
}

/// Runs the scenario of a seed.
pub(crate) fn try_seed(kind: Kind, seed: u64) -> (Scenario, Trial) {
    let mut scenario = made(kind, seed);
    let mut plan = compiled(&mut scenario);
    if scenario.decentralized.is_some() {
        waits::assign(&mut scenario);
        plan = compiled(&mut scenario);
    }
    let trial = judge(&scenario, plan);
    (scenario, trial)
}

/// Returns the scenario of a seed, before it gets its waits.
pub(crate) fn made(kind: Kind, seed: u64) -> Scenario {
    let mut scenario = match kind.coordination {
        Coordination::Centralized => Scenario::from_seed(seed),
        Coordination::Decentralized => Scenario::decentralized(seed),
    };
    if seed >= RICH {
        scenario.enrich();
    }
    if kind.comings {
        scenario.come_and_go();
    }
    scenario
}

/// Runs a scenario as it is.
pub(crate) fn try_scenario(scenario: &Scenario) -> Trial {
    judge(scenario, compile_text(&source(scenario, Form::Federated)).map_err(|error| error.1))
}

/// Runs a scenario once more, and prints all messages, the log events of the RTI, and all ends.
pub(crate) fn print_messages(scenario: &Scenario) {
    let Ok(plan) = compile_text(&source(scenario, Form::Federated)) else { return };
    let Ok(report) = run(scenario, &plan, OutputOptions { prints: true, ..OutputOptions::default() }) else { return };
    for (federate, end) in report.ends.iter().enumerate() {
        println!("f{federate}: {end:?}");
    }
}

/// Runs a scenario once more, and writes the recordings of all participants into a folder, for `lfz trace`.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write_traces(scenario: &Scenario, folder: &Path) -> io::Result<()> {
    let plan = compile_text(&source(scenario, Form::Federated)).map_err(|(_, error)| io::Error::other(error))?;
    let options = OutputOptions { records: true, ..OutputOptions::default() };
    let report = run(scenario, &plan, options).map_err(|error| io::Error::other(error.to_string()))?;
    fs::create_dir_all(folder)?;
    let names = TraceNames::of(&plan);
    fs::write(folder.join(trace_names::FILE), serde_json::to_string_pretty(&names)?)?;
    let participants = ["RTI"].into_iter().chain(plan.federates.iter().map(|federate| &federate.name[..]));
    for (participant, records) in participants.zip(report.records.iter().flatten()) {
        fs::write(folder.join(format!("{participant}.lftrace")), records.to_bytes())?;
    }
    Ok(())
}

/// Compiles a scenario. If its reactions make a loop without delay, adds delays to connections that lead back, one by
/// one, until there is none.
fn compiled(scenario: &mut Scenario) -> Result<Plan, String> {
    loop {
        match compile_text(&source(scenario, Form::Federated)) {
            Ok(plan) => return Ok(plan),
            Err((true, error)) => {
                let direct = scenario.connections.iter_mut().rev().find(|connection| connection.after.is_none());
                match direct {
                    Some(connection) => connection.after = Some(0),
                    None => return Err(error),
                }
            }
            Err((false, error)) => return Err(error),
        }
    }
}

fn judge(scenario: &Scenario, plan: Result<Plan, String>) -> Trial {
    let mut trial =
        Trial { violation: None, coverage: Coverage::default(), events: 0, messages: 0, digest: scenario.seed };
    let report = plan.and_then(|plan| match run(scenario, &plan, OutputOptions::default()) {
        Ok(report) => Ok((plan, report)),
        Err(error) => Err(error.to_string()),
    });
    let (plan, report) = match report {
        Ok(both) => both,
        Err(error) => {
            trial.violation = Some(Violation::Program(error));
            return trial;
        }
    };
    let mut scenario = scenario.clone();
    if scenario.work_depends_on_the_run() && scenario.decentralized.is_some_and(|it| it.is_safe) {
        let is_safe = waits::suffice(&scenario, &report) && check::comings_are_in_time(&scenario, &report);
        scenario.decentralized = scenario.decentralized.map(|it| Decentralized { is_safe, ..it });
    }
    let scenario = &scenario;
    trial.coverage.count(scenario, &report);
    trial.coverage.count_incarnations(scenario, &report);
    trial.events = report.traces.iter().map(|trace| trace.len() as u64).sum();
    trial.messages = report.counts.messages;
    trial.digest = report.digest;
    let violation = report.violation.clone().filter(|found| !check::is_endless(scenario, &report, found));
    trial.violation = violation.or_else(|| check::ends(scenario, &report).filter(|_| !report.cut_short));
    if trial.violation.is_some() || check::own_fault(&report) {
        return trial;
    }
    if scenario.decentralized.is_some() {
        trial.violation = judge_waits(scenario, &plan, &report, &mut trial.coverage);
    }
    let is_whole = !report.cut_short && report.struck_persistent(scenario).is_none();
    if trial.violation.is_none() && scenario.has_transients() && scenario.decentralized.is_none() && is_whole {
        trial.violation = check::passed(scenario, &report);
    }
    if trial.violation.is_none() {
        trial.violation = check::handed_over(scenario, &report);
    }
    if trial.violation.is_none() && is_whole {
        trial.violation = check::reasons(scenario, &report);
    }
    if trial.violation.is_none() {
        trial.violation = incarnations_as_alone(scenario, &plan, &report);
    }
    if trial.violation.is_none() && scenario.decentralized.is_none_or(|it| it.is_safe) {
        trial.violation = same_as_alone(scenario, &plan, &report);
    }
    trial
}

/// Checks the invariants of decentralized coordination, whatever the waits.
fn judge_waits(scenario: &Scenario, plan: &Plan, report: &Report, coverage: &mut Coverage) -> Option<Violation> {
    if report.counts.centralized > 0 {
        return Some(Violation::Centralized { messages: report.counts.centralized });
    }
    if report.cut_short {
        return None;
    }
    let (counts, violation) = check::late(scenario, plan, report);
    coverage.count_late(scenario, report, &counts);
    violation.or_else(|| check::in_order(&report.traces))
}

/// Compares with the same program run unfederated.
fn same_as_alone(scenario: &Scenario, federated: &Plan, report: &Report) -> Option<Violation> {
    let start = report.started()?;
    let plan = match compile_text(&source(scenario, Form::Persistent)) {
        Ok(plan) => plan,
        Err((_, error)) => return Some(Violation::Program(format!("unfederated: {error}"))),
    };
    if let Some(violation) = check::order(federated, &plan) {
        return Some(violation);
    }
    let expected = expectations(scenario, report);
    let until = expected.iter().flatten().map(|it| it.before).max().unwrap_or(Tag::FOREVER);
    let is_transient = |federate: &usize| scenario.federates[*federate].transient;
    let persistent = (0..scenario.federates.len()).filter(|federate| !is_transient(federate));
    let mut played: Played = persistent.clone().flat_map(|federate| report.played[federate].clone()).collect();
    for to in persistent {
        add_received(&mut played, scenario, federated, report, to, |from| is_transient(&from));
    }
    let decided = Decided { start, joined: None, stop: report.granted_stop(), played: &played, until };
    let run = |runs| run_alone(scenario, &plan, &decided, runs);
    let unfederated = |error| Some(Violation::Program(format!("unfederated: {error}")));
    let alone = match run(Runs::OneByOne) {
        Ok(alone) => alone?,
        Err(error) => return unfederated(error),
    };
    if scenario.seed.is_multiple_of(4) {
        match run(Runs::Shuffled) {
            Ok(Some(shuffled)) if by_instance(&shuffled) == by_instance(&alone) => {}
            Ok(_) => return unfederated("side by side, reactions do something else".to_owned()),
            Err(error) => return unfederated(format!("side by side: {error}")),
        }
    }
    check::traces(&report.traces, &alone, &expected)
}

/// Adds what an instance has received from some federates, as players replay it.
fn add_received(
    played: &mut Played,
    scenario: &Scenario,
    plan: &Plan,
    report: &Report,
    instance: usize,
    replays: impl Fn(usize) -> bool,
) {
    let federate = scenario.instances[instance];
    let inputs = &plan.federates[federate].inputs;
    for (index, connection) in scenario.connections.iter().enumerate() {
        let name = scenario.input_name(connection);
        if connection.to.0 == federate
            && replays(connection.from.0)
            && let Some(input) = inputs.iter().position(|input| input.name.ends_with(&name))
        {
            let handled = &report.lateness[instance].handled[input];
            let events = handled.iter().map(|message| (message.tag, Some(message.value)));
            played.insert(format!("{}.a", player(index)), events.collect());
        }
    }
}

/// Compares each instance of a transient federate with the same federate alone.
fn incarnations_as_alone(scenario: &Scenario, federated: &Plan, report: &Report) -> Option<Violation> {
    let start = report.started()?;
    for federate in (0..scenario.federates.len()).filter(|federate| scenario.federates[*federate].transient) {
        let plan = match compile_text(&source(scenario, Form::Only(federate))) {
            Ok(plan) => plan,
            Err((_, error)) => return Some(Violation::Program(format!("a transient federate alone: {error}"))),
        };
        for instance in scenario.instances_of(federate) {
            let trace = &report.traces[instance];
            let (Some(first), Some(last)) = (report.first[instance], trace.last()) else { continue };
            let mut played = report.played[instance].clone();
            add_received(&mut played, scenario, federated, report, instance, |_| true);
            let until = last.tag.next_microstep();
            // What is scheduled for after the stop takes no room in a queue.
            let stop = match report.granted[instance] {
                _ if last.last_tag => Some(last.tag),
                _ if report.has_ended(instance) => Some(report.completed[instance].max(until)),
                granted => granted.filter(|granted| *granted >= until),
            };
            let joined = Joined { instance, first, state: report.handovers[instance].taken };
            let decided = Decided { start, joined: Some(joined), stop, played: &played, until };
            match run_alone(scenario, &plan, &decided, Runs::OneByOne) {
                Ok(None) => {}
                Ok(Some(alone)) => {
                    if let Some(violation) = check::incarnation(instance, trace, &alone) {
                        return Some(violation);
                    }
                }
                Err(error) => return Some(Violation::Program(format!("a transient federate alone: {error}"))),
            }
        }
    }
    None
}

/// Returns a trace in which each instance's records stand together, in their order. Those of different instances have
/// an order only if one depends on the other.
fn by_instance(trace: &[Record]) -> Vec<Record> {
    let mut sorted = trace.to_vec();
    sorted.sort_by_key(|record| record.instance);
    sorted
}

/// Returns the part of each trace that has to match the unfederated one. Messages of a federate with a fault count as
/// far as the federate announced them to the RTI; the effects of later ones may be missing in all traces. With
/// decentralized coordination nothing is announced, and effects may be missing in each federate that such a federate
/// reaches.
fn expectations(scenario: &Scenario, report: &Report) -> Vec<Option<Expected>> {
    let count = scenario.federates.len();
    let persistent = || (0..count).filter(|federate| !scenario.federates[*federate].transient);
    let lost = |federate: usize| !report.has_ended(federate);
    let victims: Vec<_> = persistent().filter(|it| lost(*it) || report.is_struck(*it)).collect();
    let announced = victims.iter().map(|federate| report.announced[*federate]).min().unwrap_or(Tag::FOREVER);
    let is_decentralized = scenario.decentralized.is_some();
    let affected = if is_decentralized { scenario.reached(&victims) } else { Vec::new() };
    let stop = report.granted_stop().unwrap_or(Tag::FOREVER);
    // A federate that had ended before the stop has run the reactions to it already, and does nothing at the stop of
    // the others.
    let has_left = persistent().any(|federate| report.left_before_stop(federate));
    let until = if has_left { stop } else { Tag::FOREVER };
    let before = |federate: usize| match affected.get(federate) {
        Some(true) => Tag::NEVER,
        Some(false) => Tag::FOREVER,
        None => announced,
    };
    let expected = |federate| Expected { before: before(federate).min(until), prefix: lost(federate) };
    (0..report.traces.len())
        .map(|instance| (instance < count && !scenario.is_transient(instance)).then(|| expected(instance)))
        .collect()
}
