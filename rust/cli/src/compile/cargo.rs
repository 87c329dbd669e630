// SPDX-License-Identifier: Apache-2.0
//! Runs cargo on the generated workspace.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::thread;

use super::messages::{CargoMessage, Target};
use super::native;
use super::progress::Progress;
use super::rustc::Diagnostic;
use crate::guard;

/// The packages to compile, and how.
pub(crate) struct Job<'a> {
    /// The folder of the workspace.
    pub(crate) workspace: &'a Path,
    /// The folder in which cargo runs, which determines the user's settings that it finds.
    pub(crate) current: &'a Path,
    /// The packages in it; every one has one executable of its name.
    pub(crate) packages: &'a [String],
    /// The folder for the executables.
    pub(crate) target: &'a Path,
    /// The folder for all other files of cargo.
    pub(crate) build: &'a Path,
    /// Cargo's profile.
    pub(crate) profile: &'a str,
    /// Whether rustc only checks the code, and makes no program.
    pub(crate) checks_only: bool,
    /// Whether diagnostics that are printed unchanged may have colours.
    pub(crate) coloured: bool,
}

/// The output of cargo and rustc.
#[derive(Debug, Default)]
pub(crate) struct BuildOutcome {
    /// Whether everything was compiled.
    pub(crate) success: bool,
    /// Whether anything was compiled, because it was missing or not up to date.
    pub(crate) has_changed: bool,
    /// The executables, by package.
    pub(crate) executables: BTreeMap<String, PathBuf>,
    /// The diagnostics of rustc about the packages of the workspace, and the errors of others.
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// The rest of cargo's output.
    pub(crate) log: String,
}

impl Job<'_> {
    /// Compiles, and shows progress meanwhile.
    ///
    /// # Errors
    /// When cargo cannot be run. Code that does not compile is no error here, but [`BuildOutcome::success`].
    pub(crate) fn run(&self, progress: &Progress) -> io::Result<BuildOutcome> {
        let mut command = self.command();
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        // What cargo itself says is read here; rustc's diagnostics have their own option.
        command.env("CARGO_TERM_COLOR", "never");
        let words = command.get_args().skip(guard::WORDS).map(ToOwned::to_owned);
        progress.show_command(words);
        let mut child = command.spawn().map_err(|error| {
            let cargo = cargo_program();
            io::Error::new(error.kind(), format!("{} cannot be run: {error}", Path::new(&cargo).display()))
        })?;
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

    fn command(&self) -> std::process::Command {
        let mut command = guard::command(cargo_program());
        command.current_dir(self.current).args([if self.checks_only { "check" } else { "build" }, "--keep-going"]);
        command.arg("--manifest-path").arg(self.workspace.join("Cargo.toml"));
        let format = if self.coloured { "json-diagnostic-rendered-ansi" } else { "json" };
        command.arg(format!("--message-format={format}"));
        command.arg("--target-dir").arg(self.target);
        // The programs select the packages, because another crate may have the name of a package.
        command.arg("--workspace");
        for package in self.packages {
            command.args(["--bin", package]);
        }
        command.args(["--profile", self.profile]);
        command.env("CARGO_BUILD_BUILD_DIR", self.build);
        // The files for incremental compilation take more room than the programs, and programs are small.
        if std::env::var_os("CARGO_INCREMENTAL").is_none() {
            command.env("CARGO_INCREMENTAL", "0");
        }
        command
            .env_remove("CARGO_TARGET_DIR")
            .env("CARGO_TERM_COLOR", "never")
            .env("CARGO_TERM_PROGRESS_WHEN", "never");
        command
    }

    fn understand(&self, line: &str, outcome: &mut BuildOutcome) {
        let Some(message) = CargoMessage::read(line) else { return };
        match message {
            CargoMessage::Diagnostic { target, message, .. } => {
                if message.is_error() || target.is_some_and(|target| self.has(&target)) {
                    outcome.diagnostics.push(message);
                }
            }
            CargoMessage::Artifact { target, executable, fresh } => {
                outcome.has_changed |= !fresh;
                if let Some(executable) = executable.filter(|_| self.has_program(&target)) {
                    outcome.executables.insert(target.name, executable);
                }
            }
            CargoMessage::Other => {}
        }
    }

    /// Returns whether a target is the library or the program of a package; names of libraries have `_` for `-`.
    fn has(&self, target: &Target) -> bool {
        self.packages.iter().any(|package| package.replace('-', "_") == target.name.replace('-', "_"))
    }

    /// Returns whether a target is the program of a package. Of its dependencies, cargo compiles libraries only, so the
    /// name suffices, and the path does not matter.
    fn has_program(&self, target: &Target) -> bool {
        target.is_program() && self.packages.contains(&target.name)
    }
}

/// Returns the path of cargo, which cargo itself passes to its subcommands.
pub(crate) fn cargo_program() -> OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// Reads cargo's own messages, shows the last one, and returns all.
fn follow(stderr: impl Read, progress: &Progress) -> String {
    let mut log = String::new();
    for line in BufReader::new(stderr).lines().map_while(Result::ok) {
        if let Some(step) = step_of(&line) {
            progress.step(step);
            if step.starts_with("Blocking") {
                progress.wait(step);
            }
        }
        log.push_str(&line);
        log.push('\n');
    }
    log
}

/// Returns the step that a line of cargo tells. Cargo aligns the verbs of its steps in 12 columns; its errors, and what
/// build scripts say, are no steps, and the caller reports them.
fn step_of(line: &str) -> Option<&str> {
    let (verb, _) = line.split_at_checked(12).filter(|(_, rest)| rest.starts_with(' '))?;
    let verb = verb.trim_start();
    let is_verb = verb.starts_with(|first: char| first.is_ascii_uppercase()) && !verb.contains(' ');
    is_verb.then(|| line.trim())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{BuildOutcome, Job, step_of};

    fn understood(lines: &[&str]) -> BuildOutcome {
        let (folder, packages) = (Path::new("/w"), ["a".to_owned()]);
        let job = Job {
            workspace: folder,
            current: folder,
            packages: &packages,
            target: folder,
            build: folder,
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

    /// The caller reports an error once; a slow build does not tell it as a step before.
    #[test]
    fn lines_of_errors_are_no_steps() {
        assert_eq!(step_of("   Compiling a v0.1.0 (/w/a)"), Some("Compiling a v0.1.0 (/w/a)"));
        assert_eq!(step_of("    Blocking waiting for file lock"), Some("Blocking waiting for file lock"));
        for line in [
            "error: failed to run custom build command for `a v0.0.0`",
            "Caused by:",
            "",
            "ééééééé A",
            "  process didn't exit successfully: `build-script`",
            "  --- stderr",
            "warning: a: Unused variable",
        ] {
            assert_eq!(step_of(line), None);
        }
    }

    /// Cargo names paths without symbolic links, and the user with some.
    #[test]
    fn executables_are_known_by_their_packages_wherever_cargo_says_that_these_are() {
        let artifact = r#"{"reason":"compiler-artifact","package_id":"path+file:///real/w/a#0.1.0","manifest_path":
            "/real/w/a/Cargo.toml","target":{"kind":["bin"],"name":"a"},"profile":{},"features":[],"filenames":["/t/a"],
            "executable":"/t/debug/a","fresh":true}"#;
        let library = r#"{"reason":"compiler-artifact","manifest_path":"/home/rust/linux/Cargo.toml",
            "target":{"kind":["lib"],"name":"lf_linux"},"executable":null,"fresh":true}"#;
        let outcome = understood(&[artifact, library, r#"{"reason":"build-finished","success":true}"#, "hello"]);
        assert_eq!(outcome.executables.len(), 1);
        assert_eq!(outcome.executables["a"], Path::new("/t/debug/a"));
        assert!(!outcome.has_changed);
    }

    #[test]
    fn warnings_of_other_crates_are_not_the_users() {
        let message = |name: &str, kind: &str, level: &str| {
            format!(
                r#"{{"reason":"compiler-message","manifest_path":"/x/Cargo.toml","target":{{"name":"{name}",
                "kind":["{kind}"]}},"message":
                {{"rendered":"r","level":"{level}","message":"m","code":null,"spans":[],"children":[]}}}}"#
            )
        };
        let lines = [
            message("a", "bin", "warning"),
            message("b", "lib", "warning"),
            message("a", "lib", "warning"),
            message("b", "lib", "error"),
        ];
        // A package has its bodies in a library.
        let outcome = understood(&lines.each_ref().map(String::as_str));
        assert_eq!(outcome.diagnostics.len(), 3);
    }
}
