// SPDX-License-Identifier: Apache-2.0
//! A trial: a scenario is compiled, run, run unfederated, and judged.

use std::collections::BTreeMap;

use lf_compiler::plan::Plan;
use lf_compiler::{Code, Style, compile};
use lf_model::time::Tag;

use crate::check::{self, Expected, Violation};
use crate::coverage::Coverage;
use crate::run::{Decided, End, Report, run, run_alone};
use crate::scenario::{Scenario, source};

/// What came of a trial.
#[derive(Debug)]
pub(crate) struct Trial {
    pub(crate) violation: Option<Violation>,
    pub(crate) coverage: Coverage,
    /// Reactions that ran, in all federates.
    pub(crate) events: u64,
    /// Messages on all connections.
    pub(crate) messages: u64,
    /// A hash of all that happened.
    pub(crate) digest: u64,
}

/// Runs the scenario of a seed.
pub(crate) fn try_seed(seed: u64) -> (Scenario, Trial) {
    let mut scenario = Scenario::from_seed(seed);
    let plan = compiled(&mut scenario);
    let trial = judge(&scenario, plan);
    (scenario, trial)
}

/// Runs a scenario as it is.
pub(crate) fn try_scenario(scenario: &Scenario) -> Trial {
    judge(scenario, compile_text(&source(scenario, true)).map_err(|error| error.1))
}

/// Runs a scenario once more, and prints all messages, what the RTI has to tell, and how all end.
pub(crate) fn print_messages(scenario: &Scenario) {
    let Ok(plan) = compile_text(&source(scenario, true)) else { return };
    let Ok(report) = run(scenario, &plan, true) else { return };
    for (federate, end) in report.ends.iter().enumerate() {
        println!("f{federate}: {end:?}");
    }
}

/// Compiles a scenario. Where its reactions make a loop without delay, connections that lead back are delayed one by
/// one, until there is none.
fn compiled(scenario: &mut Scenario) -> Result<Plan, String> {
    loop {
        match compile_text(&source(scenario, true)) {
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

/// The plan, or whether the reason why there is none is a loop, and what was said.
fn compile_text(text: &str) -> Result<Plan, (bool, String)> {
    let files = BTreeMap::from([("Simulated.lf".to_owned(), text.to_owned())]);
    let compilation = compile("Simulated.lf", &files);
    compilation.plan.ok_or_else(|| {
        let is_loop = compilation.diagnostics.iter().any(|entry| entry.code == Code::CausalityLoop);
        (is_loop, compilation.diagnostics.render(Style::Plain))
    })
}

fn judge(scenario: &Scenario, plan: Result<Plan, String>) -> Trial {
    let mut trial =
        Trial { violation: None, coverage: Coverage::default(), events: 0, messages: 0, digest: scenario.seed };
    let report = match plan {
        Ok(plan) => run(scenario, &plan, false).map_err(|error| error.to_string()),
        Err(error) => Err(error),
    };
    let report = match report {
        Ok(report) => report,
        Err(error) => {
            trial.violation = Some(Violation::Program(error));
            return trial;
        }
    };
    trial.coverage.count(scenario, &report);
    trial.events = report.traces.iter().map(|trace| trace.len() as u64).sum();
    trial.messages = report.counts.messages;
    trial.digest = report.digest;
    let violation = report.violation.clone().filter(|found| !check::is_endless(scenario, &report, found));
    trial.violation = violation.or_else(|| check::ends(scenario, &report).filter(|_| !report.cut_short));
    if trial.violation.is_none() && !check::own_fault(&report) {
        trial.violation = same_as_alone(scenario, &report);
    }
    trial
}

/// Compares with the same program unfederated.
fn same_as_alone(scenario: &Scenario, report: &Report) -> Option<Violation> {
    let start = report.started()?;
    let plan = match compile_text(&source(scenario, false)) {
        Ok(plan) => plan,
        Err((_, error)) => return Some(Violation::Program(format!("unfederated: {error}"))),
    };
    let expected = expectations(report);
    let until = expected.iter().map(|it| it.before).max().unwrap_or(Tag::FOREVER);
    let decided = Decided { start, stop: report.granted_stop(), played: &report.played, until };
    match run_alone(scenario, &plan, &decided) {
        Ok(alone) => check::traces(&report.traces, &alone?, &expected),
        Err(error) => Some(Violation::Program(format!("unfederated: {error}"))),
    }
}

/// How much of each trace is to be as unfederated. What somebody sent who was struck counts as far as it was announced
/// to the RTI; what came later may be missing everywhere.
fn expectations(report: &Report) -> Vec<Expected> {
    let lost = |end: &End| !matches!(end, End::Ended(Ok(())));
    let struck = |federate: usize| report.struck.iter().any(|(participant, _)| *participant == federate + 1);
    let victims = (0..report.ends.len()).filter(|federate| lost(&report.ends[*federate]) || struck(*federate));
    let before = victims.map(|federate| report.announced[federate]).min().unwrap_or(Tag::FOREVER);
    let stop = report.granted_stop().unwrap_or(Tag::FOREVER);
    // Who was at its own end already has done what the others were spared, and does nothing at their stop.
    let has_left = (0..report.ends.len()).any(|federate| report.left_before_stop(federate));
    let before = if has_left { before.min(stop) } else { before };
    report.ends.iter().map(|end| Expected { before, prefix: lost(end) }).collect()
}
