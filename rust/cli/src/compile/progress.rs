// SPDX-License-Identifier: Apache-2.0
//! The progress of cargo for the user: a moving line on a terminal, a line at the start and at the end otherwise.

use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::terminal;

/// The progress of one build.
pub(crate) struct Progress {
    bar: Option<ProgressBar>,
    /// The text at the end.
    done: String,
    started: Instant,
}

impl Progress {
    /// Begins the progress; `what` completes the two verbs to sentences.
    pub(crate) fn begin([doing, done]: [&str; 2], what: &str) -> Self {
        let bar = io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new_spinner();
            // The template is fixed, and the tests use it.
            bar.set_style(ProgressStyle::with_template(TEMPLATE).unwrap_or_else(|_| ProgressStyle::default_spinner()));
            bar.set_prefix(format!("{doing} {what}"));
            bar.enable_steady_tick(Duration::from_millis(120));
            bar
        });
        if bar.is_none() {
            terminal::remark(format_args!("{doing} {what}"));
        }
        Self { bar, done: format!("{done} {what}"), started: Instant::now() }
    }

    /// Shows cargo's current step.
    pub(crate) fn step(&self, text: &str) {
        if let Some(bar) = &self.bar {
            bar.set_message(text.trim().to_owned());
        }
    }

    /// Shows that cargo waits, in its words, also without a moving line.
    pub(crate) fn wait(&self, text: &str) {
        if self.bar.is_none() {
            terminal::remark(text.trim());
        }
    }

    /// Ends the progress; the caller reports errors.
    pub(crate) fn end(self, success: bool) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        if success {
            let seconds = self.started.elapsed().as_secs_f64();
            terminal::remark(format_args!("{} in {seconds:.1} s", self.done));
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
