// SPDX-License-Identifier: Apache-2.0
//! The checks of the Rust workspace, which run on every computer.

use std::path::Path;

use crate::counts::Counts;
use crate::process;
use crate::report::Report;

/// Formatting.
pub(crate) fn fmt(repository: &Path, report: &mut Report) {
    let passed = process::succeeds(process::cargo(repository).args(["fmt", "--all", "--check"]));
    report.check("fmt", passed);
}

/// Lints, with warnings as errors.
pub(crate) fn clippy(repository: &Path, report: &mut Report) {
    let arguments = ["clippy", "--workspace", "--all-targets", "--quiet", "--", "-D", "warnings"];
    let passed = process::succeeds(process::cargo(repository).args(arguments));
    report.check("clippy", passed);
}

/// Licences and advisories of the dependencies.
pub(crate) fn deny(repository: &Path, report: &mut Report) {
    if !repository.join("deny.toml").is_file() {
        report.skip("deny", "there is no deny.toml");
    } else if process::find_program("cargo-deny").is_none() {
        report.skip("deny", "cargo-deny is not installed: cargo install cargo-deny");
    } else {
        let passed =
            process::succeeds(process::cargo(repository).args(["deny", "check", "bans", "licenses", "sources"]));
        report.check("deny", passed);
    }
}

/// All tests of the workspace.
pub(crate) fn test(repository: &Path, report: &mut Report) {
    let (succeeded, output) = process::teed(process::cargo(repository).args(["test", "--workspace", "--no-fail-fast"]));
    report.runner("host", succeeded, Counts::from_cargo_test(&output));
}
