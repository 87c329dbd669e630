// SPDX-License-Identifier: Apache-2.0
//! The program under test, built from this workspace.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use serde_json::Value;

use crate::run::{Finished, Run};

/// A limit far longer than the run of any program on a busy computer, and less than [`TIME_OUT`](crate::TIME_OUT), so
/// that the run itself reports that it hangs.
pub const TIME_LIMIT: &str = "--timeout=500s";

static LFZ: OnceLock<PathBuf> = OnceLock::new();

/// Returns the repository.
fn repository() -> &'static Path {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest.ancestors().nth(2).expect("this crate lies two folders below the repository")
}

/// Returns the LF programs of these tests.
pub fn programs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("programs")
}

/// The `lfz` program.
pub struct Lfz;

impl Lfz {
    /// Returns its path; the first call lets cargo build it.
    ///
    /// # Panics
    /// When it does not compile.
    pub fn path() -> &'static Path {
        LFZ.get_or_init(build)
    }

    /// Returns a command with these arguments, started in the repository.
    pub fn command<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Command {
        let mut command = Command::new(Self::path());
        command.current_dir(repository()).args(arguments);
        // These programs need no debug information; without it they compile in half the time and a tenth of the space.
        command.env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_INCREMENTAL", "0");
        command
    }

    /// Runs a program, with generated files in a folder of its own.
    pub fn run(test: &str, file: &Path, arguments: &[&str]) -> Run {
        Run::start(Self::run_command(test, file, arguments))
    }

    /// Returns the command of [`Lfz::run`].
    pub fn run_command(test: &str, file: &Path, arguments: &[&str]) -> Command {
        let mut command = Self::command(["run"]);
        command.arg(file).arg("--out").arg(Self::out(test)).args(arguments);
        command
    }

    /// Runs programs of a folder to their successful ends, all at the same time because they mostly wait. Ends a
    /// program that hangs, and shows its output. `LF_TEST_RTI` in the environment is the RTI.
    ///
    /// # Panics
    /// When one of them ends with an error.
    pub fn run_all<'n>(folder: &str, names: &[&'n str]) -> Vec<(&'n str, Finished)> {
        let rti = std::env::var("LF_TEST_RTI").map(|program| format!("--rti={program}"));
        let arguments: Vec<&str> = std::iter::once(TIME_LIMIT).chain(rti.as_deref()).collect();
        let file = |name: &str| programs().join(folder).join(format!("{name}.lf"));
        let start = |name: &str| Self::run(&format!("{folder}-{name}"), &file(name), &arguments);
        let runs: Vec<(&str, Run)> = names.iter().map(|name| (*name, start(name))).collect();
        runs.into_iter().map(|(name, run)| (name, run.succeed())).collect()
    }

    /// Starts an RTI on a port that the system chooses, and returns it and the port.
    ///
    /// # Panics
    /// When it does not listen.
    pub fn rti(arguments: &[&str]) -> (Run, u16) {
        Self::rti_in(repository(), arguments)
    }

    /// Starts an RTI in this folder, as [`Lfz::rti`] does.
    ///
    /// # Panics
    /// When it does not listen.
    pub fn rti_in(folder: &Path, arguments: &[&str]) -> (Run, u16) {
        let mut command = Self::command(["rti", "--port", "0"]);
        command.current_dir(folder).args(arguments);
        let mut rti = Run::start(command);
        let line = rti.wait_for("listening on TCP port");
        let port = line.rsplit(' ').next().and_then(|word| word.parse().ok()).expect("the line ends with the port");
        (rti, port)
    }

    /// Builds a program; returns the executable of each federate.
    ///
    /// # Panics
    /// When it does not compile.
    pub fn build(test: &str, file: &Path) -> BTreeMap<String, PathBuf> {
        let mut command = Self::command(["build", "--json"]);
        let output = command.arg(file).arg("--out").arg(Self::out(test)).stdin(Stdio::null()).output();
        let output = output.expect("lfz can be started");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let description: Value = serde_json::from_slice(&output.stdout).expect("lfz prints JSON");
        let participants = description["participants"].as_array().expect("it has participants");
        let string = |value: &Value| value.as_str().expect("it is a text").to_owned();
        participants.iter().map(|one| (string(&one["name"]), PathBuf::from(string(&one["program"])))).collect()
    }

    /// Returns the folder for the generated files of a test; it stays, so that a later run has nothing to compile.
    fn out(test: &str) -> PathBuf {
        let target = Self::path().ancestors().nth(2).expect("lfz lies in a folder of the target folder");
        target.join("federations").join(test)
    }
}

fn build() -> PathBuf {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let arguments = ["build", "--package", "lfz", "--bin", "lfz", "--message-format", "json-render-diagnostics"];
    let output = Command::new(cargo).current_dir(repository()).args(arguments).stdin(Stdio::null()).output();
    let output = output.expect("cargo can be started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let messages = String::from_utf8_lossy(&output.stdout);
    let messages = messages.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let executable = messages
        .filter(|message| message["target"]["name"] == "lfz")
        .find_map(|message| message["executable"].as_str().map(PathBuf::from));
    executable.expect("cargo says where it put lfz")
}
