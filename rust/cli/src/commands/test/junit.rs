// SPDX-License-Identifier: Apache-2.0
//! The outcomes of tests in the format of `JUnit`, which services for continuous integration read.

use std::fmt::Write as _;
use std::time::Duration;

/// The outcome of a test.
pub(super) struct Outcome {
    pub(super) name: String,
    pub(super) took: Duration,
    /// The output, if it has failed.
    pub(super) failure: Option<String>,
}

/// Returns the report.
pub(super) fn report(outcomes: &[Outcome]) -> String {
    let failed = outcomes.iter().filter(|outcome| outcome.failure.is_some()).count();
    let seconds: f64 = outcomes.iter().map(|outcome| outcome.took.as_secs_f64()).sum();
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <testsuite name=\"lfz\" tests=\"{}\" failures=\"{failed}\" time=\"{seconds:.3}\">\n",
        outcomes.len()
    );
    for Outcome { name, took, failure } in outcomes {
        let (name, seconds) = (escaped(name), took.as_secs_f64());
        // Writing to a String cannot fail.
        let _ = match failure {
            None => writeln!(text, "  <testcase name=\"{name}\" time=\"{seconds:.3}\"/>"),
            Some(output) => writeln!(
                text,
                "  <testcase name=\"{name}\" time=\"{seconds:.3}\">\n    <failure>{}</failure>\n  </testcase>",
                escaped(output)
            ),
        };
    }
    text + "</testsuite>\n"
}

/// Returns a text as XML has it, which lacks most control characters.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for character in text.chars() {
        match character {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\n' | '\t' => escaped.push(character),
            character if character.is_control() => escaped.push(char::REPLACEMENT_CHARACTER),
            character => escaped.push(character),
        }
    }
    escaped
}
