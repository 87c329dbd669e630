// SPDX-License-Identifier: Apache-2.0
//! The progress of cargo for the user: a moving line on a terminal, otherwise a line at the start, at the end, and now
//! and then.

use std::ffi::OsString;
use std::io::{self, IsTerminal};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::terminal;

/// The progress of one build.
pub(crate) struct Progress {
    bar: Option<ProgressBar>,
    /// The text at the end.
    done: String,
    started: Instant,
    told: Mutex<Told>,
}

/// The state of the progress, as far as it was told.
struct Told {
    /// The number of crates that cargo has begun to compile.
    crates: usize,
    /// The time of the last line without a terminal.
    at: Instant,
}

/// The interval of lines without a terminal.
const INTERVAL: Duration = Duration::from_secs(10);

impl Progress {
    /// Begins the progress; `what` completes the two verbs to sentences. A line moves on a terminal, if it may.
    pub(crate) fn begin([doing, done]: [&str; 2], what: &str, may_move: bool) -> Self {
        let moves = may_move && io::stderr().is_terminal() && !terminal::is_quiet();
        let bar = moves.then(|| {
            let bar = ProgressBar::new_spinner();
            // The template is fixed, and the tests use it.
            bar.set_style(ProgressStyle::with_template(TEMPLATE).unwrap_or_else(|_| ProgressStyle::default_spinner()));
            bar.set_prefix(format!("{doing} {what}"));
            bar.enable_steady_tick(Duration::from_millis(120));
            bar
        });
        if bar.is_none() {
            terminal::inform(format_args!("{doing} {what}"));
        }
        let now = Instant::now();
        Self { bar, done: format!("{done} {what}"), started: now, told: Mutex::new(Told { crates: 0, at: now }) }
    }

    /// Shows cargo's current step.
    pub(crate) fn step(&self, text: &str) {
        // The line at the end says that, and how long all of it took.
        if text.starts_with("Finished") {
            return;
        }
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        told.crates += usize::from(text.starts_with("Compiling"));
        if let Some(bar) = &self.bar {
            bar.set_message(format!("{text} ({})", told.crates));
        } else if told.at.elapsed() >= INTERVAL {
            told.at = Instant::now();
            let seconds = self.started.elapsed().as_secs();
            terminal::inform(format_args!("{text} (crate {}, after {seconds} s)", told.crates));
        }
    }

    /// Shows a command to those who want to know it.
    pub(crate) fn show_command(&self, words: impl IntoIterator<Item = OsString>) {
        match &self.bar {
            Some(bar) => bar.suspend(|| terminal::show_command(words)),
            None => terminal::show_command(words),
        }
    }

    /// Shows that cargo waits, in its words, also without a moving line.
    pub(crate) fn wait(&self, text: &str) {
        if self.bar.is_none() {
            terminal::inform(text);
        }
    }

    /// Ends the progress; the caller reports errors.
    pub(crate) fn end(self, success: bool) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        if success {
            let seconds = self.started.elapsed().as_secs_f64();
            terminal::inform(format_args!("{} in {seconds:.1} s", self.done));
        }
    }
}

const TEMPLATE: &str = "{spinner} {prefix} [{elapsed}] {wide_msg:.dim}";

#[cfg(test)]
mod tests {
    #[test]
    fn the_template_is_valid() {
        assert!(indicatif::ProgressStyle::with_template(super::TEMPLATE).is_ok());
    }
}
