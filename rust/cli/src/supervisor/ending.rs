// SPDX-License-Identifier: Apache-2.0
//! The end of a run: the first cause decides the exit status; the processes are asked to stop, then terminated, then
//! killed. This module touches neither processes nor clocks.
//!
//! The supervisor does not see ends in the order in which they happen: a killed process closes its connections before
//! its own end is visible, and by then the RTI may have ended because of it. Participants that end because of another
//! one have the status [`CONSEQUENCE`]. So as long as no process has been sent a signal, an end with another status
//! came first.

use std::io;
use std::time::{Duration, Instant};

/// The status of a participant that ends because another one has; it may also be that of the first one.
const CONSEQUENCE: u8 = 1;

/// The time limits of a run and of its end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// The limit of the whole run, from its start; `None` for no limit.
    pub(crate) run: Option<Duration>,
    /// The time in which the others have to end by themselves, after the first failure and after the end of the
    /// federation.
    pub(crate) grace: Duration,
    /// The time from SIGTERM to SIGKILL.
    pub(crate) terminate: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self { run: None, grace: Duration::from_secs(5), terminate: Duration::from_secs(3) }
    }
}

/// The outcome of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    /// All participants ended well.
    Success,
    /// The first participant that failed had this exit code (128 + n for signal n).
    Failed(u8),
    /// This program was told to stop by this signal.
    Interrupted(u8),
    /// The time limit was reached.
    TimedOut,
    /// The reader of the output has closed it.
    OutputClosed,
}

impl Ending {
    /// Returns the exit status with the same meaning, in the manner of shells and of timeout(1).
    pub(crate) fn exit_code(self) -> u8 {
        match self {
            Self::Success => 0,
            Self::Failed(code) => code.max(1),
            Self::Interrupted(signal) => 128 + signal,
            Self::TimedOut => 124,
            Self::OutputClosed => 141,
        }
    }
}

/// The action for all participants that still run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    Terminate,
    Kill,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// No process has to stop.
    Running,
    /// The others may end by themselves until then.
    Waiting(Instant),
    /// They have been sent SIGTERM, and are killed then.
    Terminating(Instant),
    /// They have been sent SIGKILL.
    Killing,
}

/// The way from the first cause to the last process.
#[derive(Debug)]
pub(super) struct Plan {
    limits: Limits,
    /// The time at which the run has to end, unless it is ending.
    deadline: Option<Instant>,
    stage: Stage,
    ending: Ending,
    /// Whether the transient federates have been stopped, because the others have ended.
    has_dismissed: bool,
}

impl Plan {
    pub(super) fn new(limits: Limits, now: Instant) -> Self {
        let deadline = limits.run.and_then(|run| now.checked_add(run));
        Self { limits, deadline, stage: Stage::Running, ending: Ending::Success, has_dismissed: false }
    }

    /// Returns whether there is a cause for the run to end early.
    pub(super) fn is_ending(&self) -> bool {
        self.stage != Stage::Running
    }

    /// Returns whether the participants have been sent a signal.
    pub(super) fn is_stopping(&self) -> bool {
        matches!(self.stage, Stage::Terminating(_) | Stage::Killing)
    }

    pub(super) fn ending(&self) -> Ending {
        self.ending
    }

    /// Returns the time at which to call [`Self::due`] next.
    pub(super) fn next(&self) -> Option<Instant> {
        match self.stage {
            Stage::Running => self.deadline,
            Stage::Waiting(until) => Some(self.deadline.map_or(until, |deadline| until.min(deadline))),
            Stage::Terminating(until) => Some(until),
            Stage::Killing => None,
        }
    }

    /// Handles the failure of a participant; the others have some time to notice.
    pub(super) fn failed(&mut self, exit_code: u8, now: Instant) {
        if self.ending == Ending::Failed(CONSEQUENCE) && !self.is_stopping() {
            self.ending = Ending::Failed(exit_code);
        }
        self.cause(Ending::Failed(exit_code));
        if self.stage == Stage::Running {
            self.stage = Stage::Waiting(now + self.limits.grace);
        }
    }

    /// Handles the successful end of the RTI or of all federates: the others are expected to end, too.
    pub(super) fn federation_over(&mut self, now: Instant) {
        if self.stage == Stage::Running {
            self.stage = Stage::Waiting(now + self.limits.grace);
        }
    }

    /// Returns whether to stop the transient federates now that the others have ended. They are given the same time
    /// again.
    pub(super) fn dismisses(&mut self, now: Instant) -> bool {
        let is_due = matches!(self.stage, Stage::Waiting(until) if until <= now);
        if !is_due || self.ending != Ending::Success || self.has_dismissed {
            return false;
        }
        self.has_dismissed = true;
        self.stage = Stage::Waiting(now + self.limits.grace);
        true
    }

    /// Handles a signal to stop; the second one ends the wait.
    pub(super) fn interrupted(&mut self, signal: u8, now: Instant) -> Action {
        self.cause(Ending::Interrupted(signal));
        match self.stage {
            Stage::Running | Stage::Waiting(_) => self.terminate(now),
            Stage::Terminating(_) | Stage::Killing => {
                self.stage = Stage::Killing;
                Action::Kill
            }
        }
    }

    /// Handles a failure of the output: its reader is gone, or there is no room for it.
    pub(super) fn output_lost(&mut self, error: &io::Error, now: Instant) -> Action {
        let is_closed = error.kind() == io::ErrorKind::BrokenPipe;
        self.cause(if is_closed { Ending::OutputClosed } else { Ending::Failed(1) });
        self.terminate(now)
    }

    /// Returns the action that has become due, and the reason; `None` if there is none. `names` are those that have not
    /// ended.
    pub(super) fn due(&mut self, now: Instant, names: impl Fn() -> String) -> Option<(Action, String)> {
        match self.stage {
            Stage::Running | Stage::Waiting(_) if self.deadline.is_some_and(|deadline| deadline <= now) => {
                self.cause(Ending::TimedOut);
                Some((self.terminate(now), "the time limit is reached; stopping all participants".to_owned()))
            }
            Stage::Waiting(until) if until <= now => {
                let why = match self.ending {
                    Ending::Success => format!("{} did not end with the federation; stopping", names()),
                    _ => format!("stopping {}", names()),
                };
                self.cause(Ending::Failed(1));
                Some((self.terminate(now), why))
            }
            Stage::Terminating(until) if until <= now => {
                self.stage = Stage::Killing;
                Some((Action::Kill, format!("killing {}, which did not stop when asked to", names())))
            }
            _ => None,
        }
    }

    /// Sets the cause of the end; the first one counts.
    fn cause(&mut self, ending: Ending) {
        if self.ending == Ending::Success {
            self.ending = ending;
        }
    }

    fn terminate(&mut self, now: Instant) -> Action {
        self.stage = Stage::Terminating(now + self.limits.terminate);
        Action::Terminate
    }
}

#[cfg(test)]
mod tests {
    use super::{Action, Duration, Ending, Instant, Limits, Plan};

    const SECOND: Duration = Duration::from_secs(1);

    fn names() -> String {
        "RTI".to_owned()
    }

    fn limits(run: Option<Duration>) -> Limits {
        Limits { run, grace: 5 * SECOND, terminate: 3 * SECOND }
    }

    #[test]
    fn a_failure_gives_the_others_time_then_asks_then_kills() {
        let start = Instant::now();
        let mut plan = Plan::new(limits(None), start);
        assert_eq!(plan.next(), None);
        plan.failed(3, start);
        assert_eq!(plan.due(start + 4 * SECOND, names), None);
        assert_eq!(plan.due(start + 5 * SECOND, names).map(|(action, _)| action), Some(Action::Terminate));
        assert_eq!(plan.next(), Some(start + 8 * SECOND));
        assert_eq!(plan.due(start + 8 * SECOND, names).map(|(action, _)| action), Some(Action::Kill));
        assert_eq!(plan.due(start + 99 * SECOND, names), None);
        assert_eq!(plan.ending(), Ending::Failed(3));
    }

    #[test]
    fn the_first_cause_decides_the_exit_status() {
        let start = Instant::now();
        let mut plan = Plan::new(limits(Some(SECOND)), start);
        assert_eq!(plan.due(start + SECOND, names).map(|(action, _)| action), Some(Action::Terminate));
        plan.failed(143, start + SECOND);
        assert_eq!(plan.ending().exit_code(), 124);
    }

    /// The supervisor sees the ends of the RTI and of another federate before that of the killed one.
    #[test]
    fn the_first_failure_counts_also_where_its_consequences_are_seen_first() {
        let start = Instant::now();
        let mut plan = Plan::new(limits(None), start);
        for code in [1, 1, 137, 1, 101] {
            plan.failed(code, start);
        }
        assert_eq!(plan.ending().exit_code(), 137);
        // Processes that get a signal end because of that.
        let mut plan = Plan::new(limits(None), start);
        plan.failed(1, start);
        assert!(plan.due(start + 5 * SECOND, names).is_some());
        plan.failed(143, start + 5 * SECOND);
        assert_eq!(plan.ending().exit_code(), 1);
    }

    #[test]
    fn a_second_interrupt_kills_at_once() {
        let start = Instant::now();
        let mut plan = Plan::new(limits(None), start);
        assert_eq!(plan.interrupted(2, start), Action::Terminate);
        assert_eq!(plan.interrupted(2, start), Action::Kill);
        assert_eq!(plan.ending().exit_code(), 130);
    }

    #[test]
    fn an_rti_that_outlives_its_federates_is_a_failure() {
        let start = Instant::now();
        let mut plan = Plan::new(limits(None), start);
        plan.federation_over(start);
        assert_eq!(plan.ending(), Ending::Success);
        assert!(plan.due(start + 5 * SECOND, names).is_some_and(|(_, why)| why.contains("RTI")));
        assert_eq!(plan.ending(), Ending::Failed(1));
    }

    #[test]
    fn the_time_limit_also_cuts_the_wait_after_a_failure() {
        let start = Instant::now();
        let mut plan = Plan::new(limits(Some(2 * SECOND)), start);
        plan.failed(1, start);
        assert_eq!(plan.next(), Some(start + 2 * SECOND));
    }
}
