// SPDX-License-Identifier: Apache-2.0
//! The checks of the west commands, which are written in Python.

use std::path::Path;
use std::process::Command;

use crate::counts::Counts;
use crate::process;
use crate::report::Report;

/// pytest, ruff and mypy over `scripts/`.
pub(crate) fn step(repository: &Path, report: &mut Report) {
    let scripts = repository.join("scripts");
    if !has_python(&scripts) {
        report.skip("python", "there are no Python files in scripts/");
        return;
    }
    tool(repository, report, "ruff", &["check", "scripts"]);
    tool(repository, report, "mypy", &["scripts"]);
    if is_installed(repository, "pytest") {
        let mut command = Command::new("python3");
        command.current_dir(repository).args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "scripts"]);
        let (succeeded, output) = process::teed(&mut command);
        report.runner("pytest", succeeded, Counts::from_pytest(&output));
    } else {
        report.skip("pytest", "not installed: pip install pytest");
    }
}

/// Runs a Python tool that is one check by itself.
fn tool(repository: &Path, report: &mut Report, name: &str, arguments: &[&str]) {
    if is_installed(repository, name) {
        let passed =
            process::succeeds(Command::new("python3").current_dir(repository).args(["-m", name]).args(arguments));
        report.check(name, passed);
    } else {
        report.skip(name, &format!("not installed: pip install {name}"));
    }
}

fn is_installed(repository: &Path, module: &str) -> bool {
    process::captured(Command::new("python3").current_dir(repository).args(["-m", module, "--version"])).is_some()
}

fn has_python(folder: &Path) -> bool {
    std::fs::read_dir(folder).into_iter().flatten().flatten().any(|entry| {
        let path = entry.path();
        path.extension().is_some_and(|extension| extension == "py") || (path.is_dir() && has_python(&path))
    })
}
