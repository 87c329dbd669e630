// SPDX-License-Identifier: Apache-2.0
//! Builds the measured and the measuring programs, for release, and starts the Python package that runs the parts.

use std::path::Path;
use std::process::ExitCode;

use crate::{process, zephyr};

/// Measures RTIs and applications; `arguments` are those of `scripts/lf_evaluate`.
pub(crate) fn run(repository: &Path, arguments: &[String]) -> ExitCode {
    // A page of earlier measurements needs no programs, and neither does the help.
    let measures =
        !arguments.iter().any(|argument| matches!(argument.split('=').next(), Some("--from" | "--help" | "-h")));
    let mut cargo = process::cargo(repository);
    cargo.args(["build", "--release", "--quiet", "--package", "lf-bench", "--package", "lfz"]);
    if measures && !process::succeeds(&mut cargo) {
        return ExitCode::FAILURE;
    }
    let mut evaluate = zephyr::command_in_workspace(repository, Path::new("python3"));
    evaluate.arg(repository.join("scripts/evaluate.py")).arg(process::target_folder(repository).join("release"));
    if process::succeeds(evaluate.args(arguments)) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
