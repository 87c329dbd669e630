// SPDX-License-Identifier: Apache-2.0
//! The Zephyr workspace that tests need, and the tests of the west commands in it.
//!
//! A workspace is looked for where Zephyr's own tools look: in `ZEPHYR_BASE`, in the west workspace around this
//! repository, and in CMake's user package registry (`west zephyr-export`).

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process;
use crate::python;
use crate::report::Report;

/// Tests the west commands and federations with Zephyr images in them: the tests of `scripts/` with the marker
/// `zephyr`.
pub(crate) fn federations(repository: &Path, report: &mut Report) {
    let Some(workspace) = workspace_or_skip("federations", repository, report) else { return };
    if report.is_too_late("federations") {
        return;
    }
    let mut command = workspace.command("python3");
    command.current_dir(repository).envs(compiler(repository));
    if let Some(until) = report.until() {
        command.env("LF_TESTS_UNTIL", until.to_string());
    }
    python::pytest(report, "federations", &mut command, "zephyr");
}

/// Returns the variable that names this repository's `lfz` for the build of images, as the tests of the Rust workspace
/// have built it: a build with optimizations would compile all of its dependencies once more.
pub(crate) fn compiler(repository: &Path) -> Option<(&'static str, PathBuf)> {
    const NAME: &str = "LFZ";
    if env::var_os(NAME).is_some() {
        return None;
    }
    let build = ["build", "--quiet", "--package", "lfz", "--bin", "lfz", "--message-format=json-render-diagnostics"];
    let messages = process::captured(process::cargo(repository).args(build))?;
    let executable = messages.lines().find_map(|line| {
        let message: serde_json::Value = serde_json::from_str(line).ok()?;
        Some(PathBuf::from(message.get("executable")?.as_str()?))
    })?;
    Some((NAME, executable))
}

/// Returns a command with the environment of a Zephyr workspace, if there is one.
pub(crate) fn command_in_workspace(repository: &Path, program: &Path) -> Command {
    match Workspace::find(repository) {
        Some(workspace) => workspace.command(&program.to_string_lossy()),
        None => Command::new(program),
    }
}

pub(crate) fn workspace_or_skip(name: &str, repository: &Path, report: &mut Report) -> Option<Workspace> {
    let Some(workspace) = Workspace::find(repository) else {
        let reason = "no Zephyr workspace found: set ZEPHYR_BASE, or run `west zephyr-export` in one";
        report.skip(name, reason);
        return None;
    };
    // Zephyr takes its lists of files apart at these characters.
    if repository.to_string_lossy().contains([' ', ';']) {
        let path = repository.display();
        report.skip(name, &format!("Zephyr cannot build in {path}: clone to a path without a space or a semicolon"));
        return None;
    }
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
pub(crate) struct Workspace {
    /// The value of `ZEPHYR_BASE`.
    base: PathBuf,
}

impl Workspace {
    fn find(repository: &Path) -> Option<Self> {
        from_environment().or_else(|| from_west(repository)).or_else(from_cmake_registry).map(|base| Self { base })
    }

    /// Returns the west workspace around the tree, or the tree itself if there is none.
    pub(crate) fn top(&self) -> &Path {
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

    /// Returns a command in the environment that Zephyr's build needs.
    pub(crate) fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("ZEPHYR_BASE", &self.base);
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

/// Looks in CMake's registry, which has one file per package, whose text is the path of the package's CMake folder.
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

/// Returns whether Zephyr's own tool chains are installed where its build finds them.
pub(crate) fn has_zephyr_sdk() -> bool {
    let registered =
        env::var_os("HOME").is_some_and(|home| Path::new(&home).join(".cmake/packages/Zephyr-sdk").is_dir());
    registered || env::var_os("ZEPHYR_SDK_INSTALL_DIR").is_some()
}
