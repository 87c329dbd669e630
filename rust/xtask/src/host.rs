// SPDX-License-Identifier: Apache-2.0
//! The checks of the Rust workspace, which run on every computer.

use std::path::Path;
use std::process::Command;

use crate::counts::Counts;
use crate::process;
use crate::report::Report;
use crate::tidy::tree::Tree;

/// Formatting of all crates, those outside the workspace too.
pub(crate) fn fmt(repository: &Path, report: &mut Report) {
    let tree = match Tree::read(repository) {
        Ok(tree) => tree,
        Err(error) => {
            report.fail("fmt", &format!("cannot read the tree: {error}"));
            return;
        }
    };
    let files = tree.files.iter().filter(|file| file.kind() == "rs").map(|file| &file.path);
    let mut command = Command::new("rustfmt");
    command.current_dir(repository).args(["--check", "--edition", "2024"]).args(files);
    let passed = process::succeeds(&mut command);
    report.check("fmt", passed);
}

/// Lints, with warnings as errors.
pub(crate) fn clippy(repository: &Path, report: &mut Report) {
    let arguments = ["clippy", "--workspace", "--all-targets", "--quiet", "--", "-D", "warnings"];
    let passed = process::succeeds(process::cargo(repository).args(arguments));
    report.check("clippy", passed);
}

/// All tests of the workspace.
pub(crate) fn test(repository: &Path, report: &mut Report) {
    let (succeeded, output) = process::teed(process::cargo(repository).args(["test", "--workspace", "--no-fail-fast"]));
    report.runner("host", succeeded, Counts::from_cargo_test(&output));
}
