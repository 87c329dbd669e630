// SPDX-License-Identifier: Apache-2.0
//! `lfz package`

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use serde::{Deserialize, Serialize};

use crate::args::PackageCommand;
use crate::failure::Failure;
use crate::terminal;

/// The folder in which the compilers of LF look for packages, beside `src`.
const FOLDER: &str = "lf-packages";

/// The file that says which packages a project has, beside that folder.
const LOCK: &str = "lf-packages.json";

/// The folder of a package that has its reactors.
const LIBRARY: &str = "src/lib";

/// The packages of a project, by their names.
#[derive(Debug, Default, Serialize, Deserialize)]
struct PackageLock {
    packages: BTreeMap<String, LockedPackage>,
}

/// A package as it was when it was added.
#[derive(Debug, Serialize, Deserialize)]
struct LockedPackage {
    /// The repository of git.
    git: String,
    /// The commit.
    commit: String,
}

/// Adds packages to the project in the current folder, fetches those that it has, or lists them.
pub(super) fn package(command: &PackageCommand) -> Result<ExitCode, Failure> {
    let mut lock = PackageLock::read()?;
    match command {
        PackageCommand::Add { git, revision, name } => {
            let name = name.as_deref().unwrap_or_else(|| name_of(git));
            let locked = add(&lock, git, revision.as_deref(), name)?;
            terminal::print(format_args!("{name} {}", locked.commit))?;
            lock.packages.insert(name.to_owned(), locked);
            lock.write()?;
        }
        PackageCommand::Fetch => {
            for (name, locked) in &lock.packages {
                fetch(name, locked)?;
            }
        }
        PackageCommand::List => {
            for (name, LockedPackage { git, commit }) in &lock.packages {
                let state = if folder_of(name).is_dir() { "" } else { " (not fetched)" };
                terminal::print(format_args!("{name} {commit} {git}{state}"))?;
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

impl PackageLock {
    fn read() -> Result<Self, Failure> {
        match fs::read(LOCK) {
            Ok(text) => {
                serde_json::from_slice(&text).map_err(|error| Failure::message(format!("{LOCK} is wrong: {error}")))
            }
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(Self::default()),
            Err(error) => Err(Failure::message(format!("{LOCK} cannot be read: {error}"))),
        }
    }

    fn write(&self) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(self).map_err(|error| Failure::message(error.to_string()))?;
        fs::write(LOCK, text + "\n").map_err(|error| Failure::message(format!("{LOCK} cannot be written: {error}")))
    }
}

fn add(lock: &PackageLock, git: &str, revision: Option<&str>, name: &str) -> Result<LockedPackage, Failure> {
    let is_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    if name.is_empty() || name.starts_with(['.', '-']) || !name.chars().all(is_name) {
        let hint = "a package has a name of letters, digits, `-`, `_` and `.`: `--name NAME` chooses one";
        return Err(Failure::message(format!("`{name}` is no name of a package: {hint}")));
    }
    let folder = folder_of(name);
    if folder.exists() || lock.packages.contains_key(name) {
        let message = format!("there is a package {name} already: remove it from {FOLDER} and {LOCK} before");
        return Err(Failure::message(message));
    }
    let added = clone(git, &folder).and_then(|()| {
        if let Some(revision) = revision {
            checkout(&folder, revision)?;
        }
        if !folder.join(LIBRARY).is_dir() {
            let message =
                format!("{git} is no package of LF: it has no folder {LIBRARY}, in which its reactors would be");
            return Err(Failure::message(message));
        }
        Ok(LockedPackage { git: git.to_owned(), commit: run(&folder, &["rev-parse", "HEAD"])? })
    });
    if added.is_err() {
        // Nothing else is in it, as it did not exist before.
        let _ = fs::remove_dir_all(&folder);
    }
    added
}

/// Makes the folder of a package what it was when it was added.
fn fetch(name: &str, LockedPackage { git, commit }: &LockedPackage) -> Result<(), Failure> {
    let folder = folder_of(name);
    if !folder.is_dir() {
        clone(git, &folder)?;
    }
    if run(&folder, &["rev-parse", "HEAD"])? == *commit {
        return Ok(());
    }
    if !run(&folder, &["status", "--porcelain"])?.is_empty() {
        let message = format!("{} has changes, so it stays as it is: commit them, or undo them", folder.display());
        return Err(Failure::message(message));
    }
    // The commit may be here already.
    if checkout(&folder, commit).is_err() {
        run(&folder, &["fetch", "--quiet", "origin"])?;
        checkout(&folder, commit)?;
    }
    terminal::inform(format_args!("{name} is at {commit}"));
    Ok(())
}

/// Returns the name of a package: the last part of its address.
fn name_of(git: &str) -> &str {
    let last = git.trim_end_matches('/').rsplit(['/', ':']).next().unwrap_or(git);
    last.strip_suffix(".git").unwrap_or(last)
}

fn folder_of(name: &str) -> PathBuf {
    Path::new(FOLDER).join(name)
}

fn clone(git: &str, folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(FOLDER)?;
    run(Path::new("."), &["clone".as_ref(), "--quiet".as_ref(), "--".as_ref(), OsStr::new(git), folder.as_os_str()])?;
    Ok(())
}

fn checkout(folder: &Path, revision: &str) -> Result<(), Failure> {
    run(folder, &["-c", "advice.detachedHead=false", "checkout", "--quiet", revision, "--"])?;
    Ok(())
}

/// Runs git in a folder; returns what it prints.
fn run<A: AsRef<OsStr>>(folder: &Path, arguments: &[A]) -> Result<String, Failure> {
    let mut command = Command::new("git");
    // Nobody waits for an answer to a question that is not seen.
    command.arg("-C").arg(folder).args(arguments).env("GIT_TERMINAL_PROMPT", "0");
    let output = command.output().map_err(|error| Failure::message(format!("git cannot be run: {error}")))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned());
    }
    Err(Failure::message(String::from_utf8_lossy(&output.stderr).trim()))
}
