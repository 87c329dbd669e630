// SPDX-License-Identifier: Apache-2.0
//! Rewrites the snapshots with what the programs print now.

use std::path::Path;
use std::process::ExitCode;

use crate::process;

/// Runs all tests of the workspace with every snapshot accepted, then says which files changed.
pub(crate) fn run(repository: &Path) -> ExitCode {
    let mut cargo = process::cargo(repository);
    cargo.args(["test", "--workspace", "--no-fail-fast", "--quiet"]);
    cargo.env("INSTA_UPDATE", "always");
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
