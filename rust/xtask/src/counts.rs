// SPDX-License-Identifier: Apache-2.0
//! The numbers of passed, failed and skipped tests, from the output of each test runner.

use std::fmt;
use std::ops::AddAssign;

/// A sum of test results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) passed: u64,
    pub(crate) failed: u64,
    pub(crate) skipped: u64,
}

impl Counts {
    /// Returns the counts of one check that passed or failed.
    pub(crate) fn one(passed: bool) -> Self {
        Self { passed: u64::from(passed), failed: u64::from(!passed), skipped: 0 }
    }

    /// One check that could not be made.
    pub(crate) const SKIPPED: Self = Self { passed: 0, failed: 0, skipped: 1 };

    /// Reads the sum of all `test result:` lines that `cargo test` printed.
    pub(crate) fn from_cargo_test(output: &str) -> Self {
        let mut counts = Self::default();
        for line in output.lines() {
            let line = without_escapes(line);
            if let Some(result) = line.trim_start().strip_prefix("test result:") {
                counts += Self {
                    passed: number_before(result, "passed"),
                    failed: number_before(result, "failed"),
                    skipped: number_before(result, "ignored"),
                };
            }
        }
        counts
    }

    /// Reads the last summary line of pytest: `== 2 failed, 3 passed, 1 skipped in 0.1s ==`.
    pub(crate) fn from_pytest(output: &str) -> Self {
        let is_summary = |line: &&str| {
            line.contains(" in ") && ["passed", "failed", "skipped", "error"].iter().any(|w| line.contains(w))
        };
        let line = output.lines().rev().map(str::trim).find(is_summary).map(without_escapes).unwrap_or_default();
        Self {
            passed: number_before(&line, "passed") + number_before(&line, "xfailed"),
            failed: number_before(&line, "failed") + number_before(&line, "error") + number_before(&line, "errors"),
            skipped: number_before(&line, "skipped"),
        }
    }

    /// Reads `twister.json`, or `None` when it is not one.
    pub(crate) fn from_twister(json: &str) -> Option<Self> {
        let report: serde_json::Value = serde_json::from_str(json).ok()?;
        let mut counts = Self::default();
        for suite in report.get("testsuites")?.as_array()? {
            counts += Self::from_twister_suite(suite);
        }
        Some(counts)
    }

    /// Counts the cases of a suite. A suite that did not reach its cases (because it does not build, say) is one test.
    fn from_twister_suite(suite: &serde_json::Value) -> Self {
        let status = |value: &serde_json::Value| value.get("status").and_then(|s| s.as_str()).unwrap_or("").to_owned();
        let suite_status = status(suite);
        let mut counts = Self::default();
        for case in suite.get("testcases").and_then(|cases| cases.as_array()).into_iter().flatten() {
            match status(case).as_str() {
                // A case that only has to be built has been built.
                "passed" | "not run" => counts.passed += 1,
                "failed" | "error" => counts.failed += 1,
                // A case of a suite that failed before this case was not skipped on purpose.
                "blocked" | "None" | "" if matches!(suite_status.as_str(), "failed" | "error") => counts.failed += 1,
                _ => counts.skipped += 1,
            }
        }
        match suite_status.as_str() {
            "failed" | "error" if counts.failed == 0 => counts.failed = 1,
            "passed" | "not run" if counts == Self::default() => counts.passed = 1,
            _ => {}
        }
        counts
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.skipped += other.skipped;
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} passed, {} failed, {} skipped", self.passed, self.failed, self.skipped)
    }
}

/// Returns the number in front of a word, or 0 when the word does not occur.
fn number_before(text: &str, word: &str) -> u64 {
    let words: Vec<&str> = text.split(|c: char| c.is_whitespace() || matches!(c, ';' | ',' | '=')).collect();
    let words: Vec<&str> = words.into_iter().filter(|w| !w.is_empty()).collect();
    words.windows(2).filter(|pair| pair[1] == word).find_map(|pair| pair[0].parse().ok()).unwrap_or(0)
}

/// Returns the line without the terminal's colour codes.
fn without_escapes(line: &str) -> String {
    let mut plain = String::with_capacity(line.len());
    let mut characters = line.chars();
    while let Some(character) = characters.next() {
        if character == '\u{1b}' {
            // A colour code ends with its first letter.
            characters.by_ref().find(char::is_ascii_alphabetic);
        } else {
            plain.push(character);
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::{Counts, without_escapes};

    #[test]
    fn cargo_test_lines_of_several_binaries_are_summed() {
        let output = "running 3 tests\ntest a ... ok\n\
            test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 7 filtered out; finished in 0.00s\n\
            test result: \u{1b}[31mFAILED\u{1b}[m. 2 passed; 4 failed; 0 ignored; 0 measured; 0 filtered out\n";
        assert_eq!(Counts::from_cargo_test(output), Counts { passed: 5, failed: 4, skipped: 1 });
    }

    #[test]
    fn pytest_summary_is_read() {
        let output = "collected 6 items\n\n==== \u{1b}[31m2 failed\u{1b}[0m, 3 passed, 1 skipped in 0.12s ====\n";
        assert_eq!(Counts::from_pytest(output), Counts { passed: 3, failed: 2, skipped: 1 });
        assert_eq!(Counts::from_pytest("1 passed, 2 errors in 0.1s"), Counts { passed: 1, failed: 2, skipped: 0 });
        assert_eq!(Counts::from_pytest("no tests ran in 0.01s"), Counts::default());
    }

    #[test]
    fn twister_suites_that_did_not_build_count_as_failed() {
        let json = r#"{"testsuites": [
            {"status": "passed", "testcases": [{"status": "passed"}, {"status": "skipped"}]},
            {"status": "error", "testcases": [{"status": "blocked"}]},
            {"status": "error", "testcases": []},
            {"status": "filtered", "testcases": [{"status": "filtered"}]},
            {"status": "passed", "testcases": []},
            {"status": "not run", "testcases": [{"status": "not run"}]}
        ]}"#;
        assert_eq!(Counts::from_twister(json), Some(Counts { passed: 3, failed: 2, skipped: 2 }));
        assert_eq!(Counts::from_twister("no json"), None);
    }

    #[test]
    fn colour_codes_are_removed() {
        assert_eq!(without_escapes("\u{1b}[1;31mred\u{1b}[0m"), "red");
    }
}
