// SPDX-License-Identifier: Apache-2.0
//! The tests that need a Zephyr workspace: twister suites, and federations with Zephyr images in them.
//!
//! A workspace is looked for where Zephyr's own tools look: in `ZEPHYR_BASE`, in the west workspace around this
//! repository, and in CMake's user package registry (`west zephyr-export`).

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::counts::Counts;
use crate::process;
use crate::python;
use crate::report::Report;

/// The board on which the tests run: a Linux program with the host's network.
const BOARD: &str = "native_sim/native/64";

/// The twister suites of this repository.
pub(crate) fn twister(repository: &Path, report: &mut Report) {
    let Some(workspace) = workspace_or_skip("twister", repository, report) else { return };
    let suites = suites(repository);
    if suites.is_empty() {
        report.skip("twister", "there is no testcase.yaml or sample.yaml in applications/ and tests/");
        return;
    }
    let output = repository.join("target/twister");
    let mut command = workspace.command("west");
    command.current_dir(workspace.top()).args(["twister", "--platform", BOARD, "--no-detailed-test-id"]);
    command.args(["--inline-logs", "--clobber-output", "--outdir"]).arg(&output);
    // All images, those of the west commands too, compile what they have in common once.
    command.env("CARGO_TARGET_DIR", repository.join("target/lf-zephyr"));
    for suite in suites {
        command.arg("--testsuite-root").arg(suite);
    }
    let succeeded = process::succeeds(&mut command);
    let json = fs::read_to_string(output.join("twister.json")).unwrap_or_default();
    match Counts::from_twister(&json) {
        Some(counts) => report.runner("twister", succeeded, counts),
        None => report.fail("twister", "twister left no readable twister.json"),
    }
}

/// The west commands and federations with Zephyr images in them: the tests of `scripts/` with the marker `zephyr`.
pub(crate) fn federations(repository: &Path, report: &mut Report) {
    let Some(workspace) = workspace_or_skip("federations", repository, report) else { return };
    python::pytest(report, "federations", workspace.command("python3").current_dir(repository), "zephyr");
}

/// A command with the environment of a Zephyr workspace, if there is one.
pub(crate) fn command_in_workspace(repository: &Path, program: &Path) -> Command {
    match Workspace::find(repository) {
        Some(workspace) => workspace.command(&program.to_string_lossy()),
        None => Command::new(program),
    }
}

fn workspace_or_skip(name: &str, repository: &Path, report: &mut Report) -> Option<Workspace> {
    let Some(workspace) = Workspace::find(repository) else {
        let reason = "no Zephyr workspace found: set ZEPHYR_BASE, or run `west zephyr-export` in one";
        report.skip(name, reason);
        return None;
    };
    for program in ["west", "cmake", "ninja", "dtc"] {
        if process::find_program(program).is_none() {
            report.skip(name, &format!("there is a Zephyr workspace, but no `{program}`; .ci/run installs it"));
            return None;
        }
    }
    println!("Zephyr {} in {}", workspace.version(), workspace.base.display());
    Some(workspace)
}

/// A Zephyr tree that was found.
struct Workspace {
    /// What `ZEPHYR_BASE` names.
    base: PathBuf,
}

impl Workspace {
    fn find(repository: &Path) -> Option<Self> {
        from_environment().or_else(|| from_west(repository)).or_else(from_cmake_registry).map(|base| Self { base })
    }

    /// The west workspace around the tree, or the tree itself where there is none.
    fn top(&self) -> &Path {
        self.base.ancestors().find(|folder| folder.join(".west").is_dir()).unwrap_or(&self.base)
    }

    fn version(&self) -> String {
        let text = fs::read_to_string(self.base.join("VERSION")).unwrap_or_default();
        let number = |key: &str| {
            let line = text.lines().find(|line| line.starts_with(key));
            line.and_then(|line| line.split('=').nth(1)).map_or("?", str::trim).to_owned()
        };
        format!("{}.{}.{}", number("VERSION_MAJOR"), number("VERSION_MINOR"), number("PATCHLEVEL"))
    }

    /// A command in the environment that Zephyr's build needs on this computer.
    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("ZEPHYR_BASE", &self.base);
        if env::var_os("ZEPHYR_TOOLCHAIN_VARIANT").is_none() && !has_zephyr_sdk() {
            command.env("ZEPHYR_TOOLCHAIN_VARIANT", "host");
        }
        // Cargo sets these for its children; a Zephyr build has a tool chain and a target folder of its own.
        for variable in ["CARGO", "CARGO_TARGET_DIR", "RUSTUP_TOOLCHAIN", "RUSTC", "CARGO_MANIFEST_DIR"] {
            command.env_remove(variable);
        }
        command
    }
}

fn from_environment() -> Option<PathBuf> {
    env::var_os("ZEPHYR_BASE").map(PathBuf::from).filter(|base| is_zephyr(base))
}

fn from_west(repository: &Path) -> Option<PathBuf> {
    let top = process::captured(Command::new("west").current_dir(repository).arg("topdir"))?;
    Some(Path::new(top.trim()).join("zephyr")).filter(|base| is_zephyr(base))
}

/// CMake's registry holds one file per package, whose text is the path of the package's CMake folder.
fn from_cmake_registry() -> Option<PathBuf> {
    let registry = Path::new(&env::var_os("HOME")?).join(".cmake/packages/Zephyr");
    let mut bases: Vec<PathBuf> = fs::read_dir(registry)
        .ok()?
        .flatten()
        .filter_map(|entry| fs::read_to_string(entry.path()).ok())
        .filter_map(|text| Path::new(text.trim()).ancestors().nth(3).map(Path::to_path_buf))
        .filter(|base| is_zephyr(base))
        .collect();
    bases.sort();
    bases.pop()
}

fn is_zephyr(base: &Path) -> bool {
    base.join("VERSION").is_file() && base.join("Kconfig.zephyr").is_file()
}

fn has_zephyr_sdk() -> bool {
    let registered =
        env::var_os("HOME").is_some_and(|home| Path::new(&home).join(".cmake/packages/Zephyr-sdk").is_dir());
    registered || env::var_os("ZEPHYR_SDK_INSTALL_DIR").is_some()
}

/// The folders below `applications/` and `tests/` that hold a twister suite.
fn suites(repository: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for folder in ["applications", "tests"] {
        collect_suites(&repository.join(folder), &mut found);
    }
    found.sort();
    found
}

fn collect_suites(folder: &Path, found: &mut Vec<PathBuf>) {
    if ["testcase.yaml", "sample.yaml"].iter().any(|name| folder.join(name).is_file()) {
        found.push(folder.to_path_buf());
        return;
    }
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        if entry.path().is_dir() && name != "build" && name != "target" {
            collect_suites(&entry.path(), found);
        }
    }
}
