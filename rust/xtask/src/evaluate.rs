// SPDX-License-Identifier: Apache-2.0
//! Builds what is measured and what measures, for release, and runs it.

use std::path::Path;
use std::process::ExitCode;

use crate::{process, zephyr};

/// Measures RTIs and applications; `arguments` are those of `lf-bench`.
pub(crate) fn run(repository: &Path, arguments: &[String]) -> ExitCode {
    let mut cargo = process::cargo(repository);
    cargo.args(["build", "--release", "--quiet", "--package", "lf-bench"]);
    // A page of what was measured before needs nothing to measure.
    if !arguments.iter().any(|argument| argument.split('=').next() == Some("--from")) {
        cargo.args(["--package", "lfz"]);
    }
    if !process::succeeds(&mut cargo) {
        return ExitCode::FAILURE;
    }
    let folder = process::target_folder(repository).join("release");
    let mut evaluate = zephyr::command_in_workspace(repository, &folder.join("lf-bench"));
    evaluate.arg("--repository").arg(repository).arg("--lfz").arg(folder.join("lfz")).args(arguments);
    if process::succeeds(&mut evaluate) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
