// SPDX-License-Identifier: Apache-2.0
//! The checks of the west commands, which are written in Python.

use std::path::Path;
use std::process::Command;

use crate::counts::Counts;
use crate::process;
use crate::report::Report;

/// pytest, ruff and mypy over `scripts/`, where their configuration is.
pub(crate) fn step(repository: &Path, report: &mut Report) {
    let scripts = repository.join("scripts");
    if !has_python(&scripts) {
        report.skip("python", "there are no Python files in scripts/");
        return;
    }
    tool(&scripts, report, "ruff", &["check", "."]);
    tool(&scripts, report, "mypy", &["."]);
    if is_installed(&scripts, "pytest") {
        let mut command = Command::new("python3");
        command.current_dir(&scripts).args(["-m", "pytest", "-q"]);
        let (succeeded, output) = process::teed(&mut command);
        report.runner("pytest", succeeded, Counts::from_pytest(&output));
    } else {
        report.skip("pytest", "not installed: pip install pytest");
    }
}

/// Runs a Python tool that is one check by itself.
fn tool(scripts: &Path, report: &mut Report, name: &str, arguments: &[&str]) {
    if is_installed(scripts, name) {
        let mut command = Command::new("python3");
        let passed = process::succeeds(command.current_dir(scripts).args(["-m", name]).args(arguments));
        report.check(name, passed);
    } else {
        report.skip(name, &format!("not installed: pip install {name}"));
    }
}

fn is_installed(scripts: &Path, module: &str) -> bool {
    process::captured(Command::new("python3").current_dir(scripts).args(["-m", module, "--version"])).is_some()
}

fn has_python(folder: &Path) -> bool {
    std::fs::read_dir(folder).into_iter().flatten().flatten().any(|entry| {
        let path = entry.path();
        path.extension().is_some_and(|extension| extension == "py") || (path.is_dir() && has_python(&path))
    })
}
