// SPDX-License-Identifier: Apache-2.0
//! The extension for VS Code: its types, its grammar, its package, and the package in a real editor; the grammar for
//! other editors, and one of these.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::counts::Counts;
use crate::process;
use crate::report::Report;

/// The programs by which Debian and others call a browser that the suite can drive.
const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// Arguments of cargo that choose the workspace with the parser of the tree-sitter grammar, which needs Node.js. The
/// grammar's package alone would compile the compiler once more, with other features of its dependencies.
pub(crate) const WITH_PARSER: [&str; 3] = ["--workspace", "--features", "tree-sitter-lf/parser"];

/// Checks what `editors` has.
pub(crate) fn step(repository: &Path, report: &mut Report) {
    let folder = repository.join("editors/vscode");
    for program in ["node", "npm"] {
        if process::find_program(program).is_none() {
            report.skip("editor", &format!("{program} is not installed: Debian's packages nodejs and npm"));
            return;
        }
    }
    let (succeeded, output) =
        process::teed(process::cargo(repository).arg("test").args(WITH_PARSER).args(["--test", "grammar"]));
    report.runner("editor tree-sitter", succeeded, Counts::from_cargo_test(&output));
    if let Err(reason) = install(&folder) {
        report.fail("editor", &reason);
        return;
    }
    for (name, script) in [("types", "check"), ("grammar", "test:grammar"), ("package", "package")] {
        report.check(&format!("editor {name}"), process::succeeds(&mut npm(&folder, &["run", "--silent", script])));
    }
    let Some(lfz) = lfz(repository) else {
        report.fail("editor", "lfz cannot be compiled");
        return;
    };
    let grammar = process::target_folder(repository).join("debug/tree-sitter-lf");
    let mut suite = |name: &str, script: &str, programs: &[&str]| {
        if programs.iter().any(|program| process::find_program(program).is_some()) {
            let mut npm = npm(&folder, &["run", "--silent", script]);
            let passed = process::succeeds(npm.env("LFZ", &lfz).env("TREE_SITTER_LF", &grammar));
            report.check(name, passed);
        } else {
            report.skip(name, &format!("not installed: {}", programs[0]));
        }
    };
    suite("neovim", "test:neovim", &["nvim"]);
    suite("editor suite", "test:editor", &BROWSERS);
}

fn npm(folder: &Path, arguments: &[&str]) -> Command {
    let mut npm = Command::new("npm");
    npm.current_dir(folder).args(arguments);
    npm
}

/// Installs the packages of the lock file, unless they are there. Their scripts do not run: they would download
/// programs that the suite does not need.
fn install(folder: &Path) -> Result<(), String> {
    let said = |error: std::io::Error| format!("{}: {error}", folder.display());
    let lock = std::fs::read(folder.join("package-lock.json")).map_err(said)?;
    let installed = folder.join("node_modules/.lf-lock.json");
    if std::fs::read(&installed).is_ok_and(|text| text == lock) {
        return Ok(());
    }
    if !process::succeeds(&mut npm(folder, &["ci", "--ignore-scripts", "--no-audit", "--no-fund"])) {
        return Err("npm cannot install the packages of package-lock.json".to_owned());
    }
    std::fs::write(installed, lock).map_err(said)
}

/// Compiles `lfz`, and returns its path.
fn lfz(repository: &Path) -> Option<PathBuf> {
    let built = process::succeeds(process::cargo(repository).args(["build", "--quiet", "--bin", "lfz"]));
    built.then(|| process::target_folder(repository).join("debug/lfz"))
}
