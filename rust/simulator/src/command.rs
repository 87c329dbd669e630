// SPDX-License-Identifier: Apache-2.0
//! The command line.

use std::ops::Range;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use lf_runtime::Coordination;

use crate::scenario::{Form, RICH, Scenario, source};
use crate::shrink::{cut, shrink};
use crate::trial::{Trial, print_messages, try_scenario, write_traces};
use crate::workers::{all, options, try_safely, worker};
use crate::{Kind, with_stack};

/// The maximum number of violations that are shrunk.
const SHRUNK_MAX: usize = 3;

/// Runs random federations in virtual time, and checks them.
#[derive(Parser)]
#[allow(clippy::struct_excessive_bools, reason = "these are switches, each of its own")]
#[command(name = "cargo xtask simulate", bin_name = "cargo xtask simulate")]
struct Arguments {
    /// The seeds to run: `A..B`, B not included.
    #[arg(long, value_name = "A..B", default_value = "0..1000", value_parser = range)]
    seeds: Range<u64>,
    /// Run federations with decentralized coordination, which differ for the same seeds.
    #[arg(long)]
    decentralized: bool,
    /// Let federates come and go while the federation runs: they join, stop, vanish, come back, and are replaced.
    #[arg(long)]
    comings: bool,
    /// Add this offset to the seeds: programs of seeds beyond it have banks, multiports, modes and watchdogs, too.
    #[arg(long)]
    rich: bool,
    /// Run this seed only, and print all details of it.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// With --seed: apply these reductions, a list of numbers as --shrink prints it.
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    cuts: Vec<usize>,
    /// With --seed: shrink the scenario as long as it violates the same invariant.
    #[arg(long)]
    shrink: bool,
    /// With --seed: print all messages.
    #[arg(long)]
    messages: bool,
    /// With --seed: write the recordings of all participants, with values, into this folder, for `lfz trace`.
    #[arg(long, value_name = "FOLDER")]
    trace: Option<PathBuf>,
    /// Number of processes to run in parallel.
    #[arg(long, value_name = "N", default_value_t = 1)]
    jobs: usize,
    /// Run the seeds in this process, and print the results for another process.
    #[arg(long, hide = true)]
    worker: bool,
}

impl Arguments {
    fn kind(&self) -> Kind {
        let coordination = if self.decentralized { Coordination::Decentralized } else { Coordination::Centralized };
        Kind { coordination, comings: self.comings }
    }
}

fn range(text: &str) -> Result<Range<u64>, String> {
    let wrong = || format!("\"{text}\" is not two numbers with `..` between them, as 0..1000");
    let (start, end) = text.split_once("..").ok_or_else(wrong)?;
    let number = |text: &str| text.parse::<u64>().map_err(|_| wrong());
    Ok(number(start)?..number(end)?)
}

/// Runs the simulator with this process's command line.
pub fn main() -> ExitCode {
    let mut arguments = Arguments::parse();
    if arguments.rich {
        arguments.seeds = arguments.seeds.start + RICH..arguments.seeds.end + RICH;
    }
    if arguments.worker {
        with_stack(|| worker(arguments.kind(), arguments.seeds));
        return ExitCode::SUCCESS;
    }
    with_stack(|| match arguments.seed {
        Some(seed) => one(seed, &arguments),
        None => many(&arguments),
    })
}

fn one(seed: u64, arguments: &Arguments) -> ExitCode {
    let (whole, first) = try_safely(arguments.kind(), seed);
    let Some(mut scenario) = cut(&whole, &arguments.cuts) else {
        eprintln!("error: --cuts names a reduction that this scenario does not have");
        return ExitCode::from(2);
    };
    let mut trial = if arguments.cuts.is_empty() { first } else { try_scenario(&scenario) };
    let mut cuts = arguments.cuts.clone();
    if let Some(violation) = trial.violation.as_ref().filter(|_| arguments.shrink) {
        let (smaller, more) = shrink(&scenario, violation);
        scenario = smaller;
        cuts.extend(more);
        trial = try_scenario(&scenario);
    }
    describe(&scenario, &trial, arguments.kind(), seed, &cuts);
    if arguments.messages {
        print_messages(&scenario);
    }
    if let Some(folder) = &arguments.trace {
        if let Err(error) = write_traces(&scenario, folder) {
            eprintln!("error: cannot write into {}: {error}", folder.display());
            return ExitCode::FAILURE;
        }
        println!("recorded in {0}: see it with `lfz trace {0}`", folder.display());
    }
    if trial.violation.is_some() { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// Prints all inputs of a run, and its results.
fn describe(scenario: &Scenario, trial: &Trial, kind: Kind, seed: u64, cuts: &[usize]) {
    println!("{}", source(scenario, Form::Federated));
    println!("{:#?}", scenario.conditions);
    println!("faults: {:?}", scenario.faults);
    for (instance, federate) in scenario.instances.iter().enumerate().skip(scenario.federates.len()) {
        println!("f{instance} (participant {}) is another instance of f{federate}", instance + 1);
    }
    if let Some(decentralized) = scenario.decentralized {
        println!("{decentralized:?}");
    }
    println!("{}", trial.coverage);
    println!("{} reactions, {} messages, hash of the run {:016x}", trial.events, trial.messages, trial.digest);
    let cuts: Vec<_> = cuts.iter().map(usize::to_string).collect();
    let cuts = if cuts.is_empty() { String::new() } else { format!(" --cuts {}", cuts.join(",")) };
    match &trial.violation {
        Some(violation) => println!("VIOLATION of {violation}"),
        None => println!("nothing is violated"),
    }
    println!("repeat with: cargo xtask simulate{} --seed {seed}{cuts}", options(kind));
}

fn many(arguments: &Arguments) -> ExitCode {
    let started = Instant::now();
    let summary = match all(arguments.kind(), arguments.seeds.clone(), arguments.jobs) {
        Ok(summary) => summary,
        Err(error) => {
            eprintln!("error: cannot start worker processes: {error}");
            return ExitCode::FAILURE;
        }
    };
    eprintln!();
    let seconds = started.elapsed().as_secs_f64();
    println!("{}", summary.coverage);
    for (seed, violation) in summary.violations.iter().take(20) {
        println!("VIOLATION in seed {seed}: {violation}");
    }
    println!(
        "{} federations, {} reactions, {} messages in {seconds:.1} s; {} violations",
        summary.seeds,
        summary.events,
        summary.messages,
        summary.violations.len()
    );
    for (seed, _) in summary.violations.iter().take(SHRUNK_MAX) {
        println!("\nseed {seed}, made smaller:");
        let program = std::env::current_exe().unwrap_or_default();
        let _ = std::process::Command::new(program)
            .args(["--shrink", "--seed", &seed.to_string()])
            .args(options(arguments.kind()).split_whitespace())
            .status();
    }
    if summary.violations.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
