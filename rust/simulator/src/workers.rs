// SPDX-License-Identifier: Apache-2.0
//! Many seeds in many processes. The memory that a run leaks (its tables) ends with its process.

use std::io::{BufRead, BufReader, Write as _};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::Instant;

use lf_runtime::Coordination;

use crate::Kind;
use crate::check::Violation;
use crate::coverage::Coverage;
use crate::scenario::Scenario;
use crate::trial::{Trial, made, try_seed};

/// The number of seeds of one process.
const CHUNK: u64 = 500;

/// The results of many seeds.
#[derive(Debug, Default)]
pub(crate) struct Summary {
    pub(crate) seeds: u64,
    pub(crate) events: u64,
    pub(crate) messages: u64,
    pub(crate) coverage: Coverage,
    /// Seeds with the violation of each.
    pub(crate) violations: Vec<(u64, String)>,
}

/// Runs seeds in this process, and prints the results for [`all`] to read.
pub(crate) fn worker(kind: Kind, seeds: Range<u64>) {
    let mut coverage = Coverage::default();
    let (mut events, mut messages) = (0, 0);
    for seed in seeds.clone() {
        let (_, trial) = try_safely(kind, seed);
        (events, messages) = (events + trial.events, messages + trial.messages);
        coverage.merge(&trial.coverage);
        if let Some(violation) = trial.violation {
            println!("violation {seed} {}", violation.to_string().replace('\n', " | "));
        }
    }
    for (name, count) in &coverage.0 {
        println!("coverage {count} {name}");
    }
    println!("done {} {events} {messages}", seeds.end - seeds.start);
}

/// Returns the options, with a space before each, that select this kind.
pub(crate) fn options(kind: Kind) -> String {
    let coordination = match kind.coordination {
        Coordination::Centralized => "",
        Coordination::Decentralized => " --decentralized",
    };
    format!("{coordination}{}", if kind.comings { " --comings" } else { "" })
}

/// Runs the scenario of a seed; a panic is a violation too.
pub(crate) fn try_safely(kind: Kind, seed: u64) -> (Scenario, Trial) {
    catch_unwind(AssertUnwindSafe(|| try_seed(kind, seed))).unwrap_or_else(|_| {
        let violation = Some(Violation::Program("it panicked, as said above".to_owned()));
        let trial = Trial { violation, coverage: Coverage::default(), events: 0, messages: 0, digest: 0 };
        (made(kind, seed), trial)
    })
}

/// Runs all seeds in worker processes, `jobs` at a time.
pub(crate) fn all(kind: Kind, seeds: Range<u64>, jobs: usize) -> std::io::Result<Summary> {
    let program = std::env::current_exe()?;
    let chunks = Mutex::new(seeds.clone().step_by(usize::try_from(CHUNK).unwrap_or(1)));
    let summary = Mutex::new(Summary::default());
    let started = Instant::now();
    let lock = |mutex: &Mutex<Summary>, change: &mut dyn FnMut(&mut Summary)| {
        change(&mut mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner));
    };
    std::thread::scope(|scope| {
        for _ in 0..jobs.max(1) {
            scope.spawn(|| {
                loop {
                    let next = chunks.lock().unwrap_or_else(std::sync::PoisonError::into_inner).next();
                    let Some(first) = next else { return };
                    let range = first..(first + CHUNK).min(seeds.end);
                    let outcome = run_chunk(&program, kind, &range);
                    lock(&summary, &mut |summary| {
                        summary.add(&range, &outcome);
                        progress(summary, &seeds, started);
                    });
                }
            });
        }
    });
    Ok(summary.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner))
}

fn progress(summary: &Summary, seeds: &Range<u64>, started: Instant) {
    let seconds = started.elapsed().as_secs().max(1);
    eprint!(
        "\r{} of {} seeds, {} per second, {} violations ",
        summary.seeds,
        seeds.end - seeds.start,
        summary.seeds / seconds,
        summary.violations.len()
    );
    let _ = std::io::stderr().flush();
}

/// Returns the lines that a worker prints.
fn run_chunk(program: &std::path::Path, kind: Kind, range: &Range<u64>) -> Vec<String> {
    let seeds = format!("{}..{}", range.start, range.end);
    let child = Command::new(program)
        .args(["--worker", "--seeds", &seeds])
        .args(options(kind).split_whitespace())
        .stdout(Stdio::piped())
        .spawn();
    let Ok(mut child) = child else { return Vec::new() };
    let lines = child.stdout.take().map(|output| BufReader::new(output).lines().map_while(Result::ok).collect());
    let _ = child.wait();
    lines.unwrap_or_default()
}

impl Summary {
    fn add(&mut self, range: &Range<u64>, lines: &[String]) {
        let mut done = false;
        for line in lines {
            let mut words = line.splitn(3, ' ');
            let (kind, number, rest) = (words.next(), words.next(), words.next().unwrap_or_default());
            let number = number.and_then(|text| text.parse::<u64>().ok()).unwrap_or(0);
            match kind {
                Some("violation") => {
                    eprintln!("\nseed {number}: {rest}");
                    self.violations.push((number, rest.to_owned()));
                }
                Some("coverage") => self.coverage.add(rest, number),
                Some("done") => {
                    done = true;
                    self.seeds += number;
                    let mut counts = rest.split(' ').map(|text| text.parse::<u64>().unwrap_or(0));
                    self.events += counts.next().unwrap_or(0);
                    self.messages += counts.next().unwrap_or(0);
                }
                _ => {}
            }
        }
        if !done {
            let what = format!("the process for the seeds from here to {} died", range.end);
            self.violations.push((range.start, what));
        }
    }
}
