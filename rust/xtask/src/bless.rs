// SPDX-License-Identifier: Apache-2.0
//! Rewrites the snapshots with the programs' present output.

use std::path::Path;
use std::process::ExitCode;

use crate::process;

/// Runs the tests of a crate, or of the workspace, whose names contain `filter`, with every snapshot accepted; then
/// lists the changed files.
pub(crate) fn run(repository: &Path, package: Option<&str>, filter: Option<&str>) -> ExitCode {
    let mut cargo = process::cargo(repository);
    cargo.args(["test", "--no-fail-fast", "--quiet"]).env("INSTA_UPDATE", "always");
    match package {
        Some(package) => cargo.args(["--package", package]),
        None => cargo.arg("--workspace"),
    };
    if package.is_none_or(|name| name == "tree-sitter-lf") && process::find_program("node").is_some() {
        cargo.args(["--features", "tree-sitter-lf/parser"]);
    }
    cargo.args(filter);
    let passed = process::succeeds(&mut cargo);
    let mut git = std::process::Command::new("git");
    git.current_dir(repository).args(["status", "--short", "--", "*.snap", "tests", "README.md", "docs"]);
    match process::captured(&mut git) {
        Some(changes) if changes.is_empty() => println!("\nno expected output changed"),
        Some(changes) => println!("\nread the difference of these files before you commit them:\n{changes}"),
        None => println!("\nthis is no git repository, so the changed files cannot be listed"),
    }
    if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
