// SPDX-License-Identifier: Apache-2.0
//! The checks of the west commands, which are written in Python.

use std::path::Path;
use std::process::Command;

use crate::counts::Counts;
use crate::process;
use crate::report::Report;

/// ruff, mypy, and those tests of `scripts/` that need no Zephyr workspace.
pub(crate) fn step(repository: &Path, report: &mut Report) {
    if !has_python(&repository.join("scripts")) {
        report.skip("python", "there are no Python files in scripts/");
        return;
    }
    tool(repository, report, "ruff", &["check", "scripts", "applications"]);
    tool(repository, report, "mypy", &["--config-file", "scripts/pyproject.toml", "scripts", "applications/pytest"]);
    let mut python = Command::new("python3");
    pytest(report, "pytest", python.current_dir(repository), "not zephyr");
}

/// Runs the tests of `scripts/` that a marker expression chooses; `python` is started in the repository.
pub(crate) fn pytest(report: &mut Report, name: &str, python: &mut Command, markers: &str) {
    if !is_installed("pytest") {
        report.skip(name, "pytest is not installed: pip install pytest");
        return;
    }
    let configuration =
        ["-m", "pytest", "-q", "-rs", "--durations=12", "-c", "scripts/pyproject.toml", "--rootdir", "scripts"];
    let (succeeded, output) = process::teed(python.args(configuration).args(["-m", markers, "scripts/tests"]));
    let counts = Counts::from_pytest(&output);
    if counts == Counts::default() && (output.contains("deselected") || output.contains("no tests ran")) {
        report.skip(name, "there is no such test");
    } else {
        report.runner(name, succeeded, counts);
    }
}

/// Runs a Python tool that is one check by itself.
fn tool(repository: &Path, report: &mut Report, name: &str, arguments: &[&str]) {
    if is_installed(name) {
        let mut command = Command::new("python3");
        let passed = process::succeeds(command.current_dir(repository).args(["-m", name]).args(arguments));
        report.check(name, passed);
    } else {
        report.skip(name, &format!("not installed: pip install {name}"));
    }
}

fn is_installed(module: &str) -> bool {
    process::captured(Command::new("python3").args(["-m", module, "--version"])).is_some()
}

fn has_python(folder: &Path) -> bool {
    std::fs::read_dir(folder).into_iter().flatten().flatten().any(|entry| {
        let path = entry.path();
        path.extension().is_some_and(|extension| extension == "py") || (path.is_dir() && has_python(&path))
    })
}
