// SPDX-License-Identifier: Apache-2.0
//! Running cargo on the generated workspace.

use std::collections::BTreeMap;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::thread;

use super::messages::CargoMessage;
use super::native;
use super::progress::Progress;
use super::rustc::Diagnostic;
use crate::guard;

/// What to compile.
pub(crate) struct Job<'a> {
    /// The folder of the generated workspace.
    pub(crate) workspace: &'a Path,
    /// The packages in it; every one has one executable.
    pub(crate) packages: &'a [String],
    /// Where the executables go.
    pub(crate) target: &'a Path,
    /// Where everything else goes that cargo keeps.
    pub(crate) shared: &'a Path,
    /// Cargo's profile.
    pub(crate) profile: &'a str,
    /// Whether rustc only looks at the code, and no program is made.
    pub(crate) checks_only: bool,
    /// Whether diagnostics that are printed as they are may have colours.
    pub(crate) coloured: bool,
}

/// What cargo and rustc said.
#[derive(Debug, Default)]
pub(crate) struct BuildOutcome {
    /// Whether everything was compiled.
    pub(crate) success: bool,
    /// The executables, by package.
    pub(crate) executables: BTreeMap<String, PathBuf>,
    /// What rustc said about the packages of the workspace.
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// What cargo wrote beside that.
    pub(crate) log: String,
}

impl Job<'_> {
    /// Compiles, and shows progress meanwhile.
    ///
    /// # Errors
    /// When cargo cannot be run. That something does not compile is no error here, but [`BuildOutcome::success`].
    pub(crate) fn run(&self, progress: &Progress) -> io::Result<BuildOutcome> {
        let mut command = self.command()?;
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
        let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
        let mut outcome = BuildOutcome::default();
        thread::scope(|scope| -> io::Result<()> {
            let log = scope.spawn(|| stderr.map_or_else(String::new, |stderr| follow(stderr, progress)));
            for line in stdout.into_iter().flat_map(|stdout| BufReader::new(stdout).lines()) {
                self.understand(&line?, &mut outcome);
            }
            outcome.log = log.join().unwrap_or_default();
            Ok(())
        })?;
        outcome.success = child.wait()?.success();
        outcome.diagnostics.extend(native::diagnostics(&outcome.log));
        Ok(outcome)
    }

    fn command(&self) -> io::Result<std::process::Command> {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut command = guard::command(cargo)?;
        command.current_dir(self.workspace).args([if self.checks_only { "check" } else { "build" }, "--keep-going"]);
        let format = if self.coloured { "json-diagnostic-rendered-ansi" } else { "json" };
        command.arg(format!("--message-format={format}"));
        command.arg("--target-dir").arg(self.target);
        // By their programs, because another crate may have the name of a package.
        command.arg("--workspace");
        for package in self.packages {
            command.args(["--bin", package]);
        }
        command.args(["--profile", self.profile]);
        // What is compiled once serves all programs; the executables, whose names may be alike, stay apart.
        command.env("CARGO_BUILD_BUILD_DIR", self.shared);
        command
            .env_remove("CARGO_TARGET_DIR")
            .env("CARGO_TERM_COLOR", "never")
            .env("CARGO_TERM_PROGRESS_WHEN", "never");
        Ok(command)
    }

    fn understand(&self, line: &str, outcome: &mut BuildOutcome) {
        let Some(message) = CargoMessage::read(line) else { return };
        match message {
            CargoMessage::Diagnostic { manifest_path, message, .. } if manifest_path.starts_with(self.workspace) => {
                outcome.diagnostics.push(message);
            }
            CargoMessage::Diagnostic { message, .. } if message.is_error() => outcome.diagnostics.push(message),
            CargoMessage::Artifact { manifest_path, target, executable: Some(executable) }
                if manifest_path.starts_with(self.workspace) =>
            {
                outcome.executables.insert(target.name, executable);
            }
            _ => {}
        }
    }
}

/// Reads cargo's own words, shows the last one, and keeps all.
fn follow(stderr: impl Read, progress: &Progress) -> String {
    let mut log = String::new();
    for line in BufReader::new(stderr).lines().map_while(Result::ok) {
        progress.step(&line);
        log.push_str(&line);
        log.push('\n');
    }
    log
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{BuildOutcome, Job};

    fn understood(lines: &[&str]) -> BuildOutcome {
        let folder = Path::new("/w");
        let job = Job {
            workspace: folder,
            packages: &[],
            target: folder,
            shared: folder,
            profile: "dev",
            checks_only: false,
            coloured: false,
        };
        let mut outcome = BuildOutcome::default();
        for line in lines {
            job.understand(line, &mut outcome);
        }
        outcome
    }

    #[test]
    fn executables_of_the_workspace_are_found() {
        let artifact = r#"{"reason":"compiler-artifact","package_id":"path+file:///w/a#0.1.0","manifest_path":
            "/w/a/Cargo.toml","target":{"kind":["bin"],"name":"a"},"profile":{},"features":[],"filenames":["/t/a"],
            "executable":"/t/debug/a","fresh":true}"#;
        let library = r#"{"reason":"compiler-artifact","manifest_path":"/home/rust/linux/Cargo.toml",
            "target":{"kind":["lib"],"name":"lf_linux"},"executable":null,"fresh":true}"#;
        let outcome = understood(&[artifact, library, r#"{"reason":"build-finished","success":true}"#, "hello"]);
        assert_eq!(outcome.executables.len(), 1);
        assert_eq!(outcome.executables["a"], Path::new("/t/debug/a"));
    }

    #[test]
    fn warnings_of_other_crates_are_not_the_users() {
        let message = |manifest: &str, level: &str| {
            format!(
                r#"{{"reason":"compiler-message","manifest_path":"{manifest}","target":{{"name":"x"}},"message":
                {{"rendered":"r","level":"{level}","message":"m","code":null,"spans":[],"children":[]}}}}"#
            )
        };
        let lines = [
            message("/w/a/Cargo.toml", "warning"),
            message("/x/Cargo.toml", "warning"),
            message("/x/Cargo.toml", "error"),
        ];
        let outcome = understood(&lines.each_ref().map(String::as_str));
        assert_eq!(outcome.diagnostics.len(), 2);
    }
}
