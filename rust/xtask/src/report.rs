// SPDX-License-Identifier: Apache-2.0
//! Collects the outcome of every step and sums them up at the end.

use std::process::ExitCode;
use std::time::{Duration, Instant, SystemTime};

use crate::counts::Counts;

/// The outcomes so far.
pub(crate) struct Report {
    steps: Vec<Outcome>,
    started: Instant,
    /// The time after which no long step begins.
    limit: Option<Duration>,
}

struct Outcome {
    name: String,
    counts: Counts,
    /// The reason why something was skipped or failed as a whole.
    reason: Option<String>,
    /// Seconds since the run began, when it ended.
    ended_s: u64,
}

impl Report {
    pub(crate) fn new(limit: Option<Duration>) -> Self {
        Self { steps: Vec::new(), started: Instant::now(), limit }
    }

    /// Returns the time left; `None` without a limit.
    pub(crate) fn left(&self) -> Option<Duration> {
        self.limit.map(|limit| limit.saturating_sub(self.started.elapsed()))
    }

    /// Returns when the time is over, for programs that read the clock: seconds since 1970.
    pub(crate) fn until(&self) -> Option<u64> {
        let since_1970 = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
        self.left().map(|left| (since_1970 + left).as_secs())
    }

    /// Records a step as skipped when no time is left for it.
    pub(crate) fn is_too_late(&mut self, name: &str) -> bool {
        let late = self.left().is_some_and(|left| left.is_zero());
        if late {
            self.skip(name, "the time of --within is over");
        }
        late
    }

    /// Prints the name of the next step.
    #[allow(clippy::unused_self, reason = "a step is begun in a report")]
    pub(crate) fn begin(&self, name: &str) {
        println!("\n==== {name} ====");
    }

    /// Records the results of a step.
    pub(crate) fn add(&mut self, name: &str, counts: Counts) {
        self.push(name, counts, None);
    }

    /// Records a check that is one test by itself.
    pub(crate) fn check(&mut self, name: &str, passed: bool) {
        self.add(name, Counts::one(passed));
    }

    /// Records results of a test runner; a runner that fails without a failed test (it did not build) is a failure.
    pub(crate) fn runner(&mut self, name: &str, succeeded: bool, mut counts: Counts) {
        let mut reason = None;
        if !succeeded && counts.failed == 0 {
            counts.failed = 1;
            reason = Some("the test runner itself failed".to_owned());
        }
        self.push(name, counts, reason);
    }

    /// Records, loudly, something that could not be tested here.
    pub(crate) fn skip(&mut self, name: &str, reason: &str) {
        println!("\n**** SKIPPED {name}: {reason} ****");
        self.push(name, Counts::SKIPPED, Some(reason.to_owned()));
    }

    /// Records a step that failed for a reason of its own.
    pub(crate) fn fail(&mut self, name: &str, reason: &str) {
        eprintln!("error: {name}: {reason}");
        self.push(name, Counts::one(false), Some(reason.to_owned()));
    }

    /// Prints all outcomes, the sum last, and returns the exit status.
    pub(crate) fn finish(self) -> ExitCode {
        println!("\n==== summary ====");
        let mut sum = Counts::default();
        let mut previous_s = 0;
        for step in &self.steps {
            let mark = if step.counts.failed > 0 {
                "FAILED"
            } else if step.counts.passed > 0 {
                "ok"
            } else {
                "skipped"
            };
            let reason = step.reason.as_ref().map(|reason| format!(" ({reason})")).unwrap_or_default();
            println!("{mark:7} {:12} {}, {} s{reason}", step.name, step.counts, step.ended_s - previous_s);
            previous_s = step.ended_s;
            sum += step.counts;
        }
        println!("\n{sum}");
        if sum.failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }

    fn push(&mut self, name: &str, counts: Counts, reason: Option<String>) {
        let ended_s = self.started.elapsed().as_secs();
        self.steps.push(Outcome { name: name.to_owned(), counts, reason, ended_s });
    }
}
