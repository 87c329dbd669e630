// SPDX-License-Identifier: Apache-2.0
//! Runs the programs of a folder, such as those by which LF tests its targets, and says of each what became of it.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use crate::process;

/// After how long a program is stopped that does not end by itself.
const TIME_LIMIT: &str = "60 s";

/// The exit status of `lfz run` when that time is over.
const TIMED_OUT: i32 = 124;

/// What the name of a diagnostic begins with that refuses a part of LF.
const REFUSALS: [&str; 2] = ["error[E030", "error[E031"];

/// What became of a program.
enum Verdict {
    Passed,
    /// It has no main reactor, for others import it.
    Library,
    /// It needs something of LF that is not there.
    Refused(String),
    Failed(String),
}

/// Runs all programs below a folder, or those whose paths contain a text.
pub(crate) fn run(repository: &Path, folder: &Path, only: Option<&str>) -> ExitCode {
    let mut cargo = process::cargo(repository);
    cargo.args(["build", "--release", "--quiet", "--package", "lfz"]);
    if !process::succeeds(&mut cargo) {
        return ExitCode::FAILURE;
    }
    let target = process::target_folder(repository);
    let mut programs = Vec::new();
    if let Err(error) = find(folder, &mut programs) {
        eprintln!("error: {}: {error}", folder.display());
        return ExitCode::FAILURE;
    }
    programs.sort();
    let shown = |path: &Path| path.strip_prefix(folder).unwrap_or(path).display().to_string();
    programs.retain(|path| only.is_none_or(|only| shown(path).contains(only)));
    let output = target.join("lf-tests");
    let mut reasons: BTreeMap<String, usize> = BTreeMap::new();
    let (mut passed, mut failed, mut refused, mut libraries) = (0, 0, 0, 0);
    for path in &programs {
        let name = shown(path);
        match judge(&target.join("release/lfz"), path, &output.join(&name)) {
            Verdict::Passed => {
                passed += 1;
                println!("passed   {name}");
            }
            Verdict::Library => libraries += 1,
            Verdict::Refused(reason) => {
                refused += 1;
                println!("refused  {name}: {reason}");
                *reasons.entry(reason).or_default() += 1;
            }
            Verdict::Failed(reason) => {
                failed += 1;
                println!("FAILED   {name}: {reason}");
            }
        }
    }
    let mut reasons: Vec<_> = reasons.into_iter().collect();
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    for (reason, count) in reasons {
        println!("refused {count} times: {reason}");
    }
    println!("{libraries} files without a main reactor");
    println!("{passed} passed, {failed} failed, {refused} refused");
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn find(folder: &Path, programs: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            find(&path, programs)?;
        } else if path.extension().is_some_and(|extension| extension == "lf") {
            programs.push(path);
        }
    }
    Ok(())
}

fn judge(lfz: &Path, program: &Path, output: &Path) -> Verdict {
    let mut run = Command::new(lfz);
    run.args(["run", "--timeout", TIME_LIMIT, "--out"]).arg(output).arg(program);
    let result = match run.stdin(Stdio::null()).output() {
        Ok(result) => result,
        Err(error) => return Verdict::Failed(format!("lfz cannot be started: {error}")),
    };
    if result.status.success() {
        return Verdict::Passed;
    }
    let said = String::from_utf8_lossy(&result.stderr);
    let errors = || said.lines().filter(|line| line.contains("error"));
    if said.contains("error[E040") {
        return Verdict::Library;
    }
    if let Some(refusal) = errors().find(|line| REFUSALS.iter().any(|code| line.contains(code))) {
        let reason = refusal.split_once("]: ").map_or(refusal, |(_, reason)| reason);
        return Verdict::Refused(reason.to_owned());
    }
    Verdict::Failed(match result.status.code() {
        Some(TIMED_OUT) => format!("does not end within {TIME_LIMIT}"),
        _ => errors().chain(said.lines().filter(|line| line.contains("panicked"))).next().unwrap_or("").to_owned(),
    })
}
