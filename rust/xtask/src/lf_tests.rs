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
const REFUSALS: [&str; 2] = ["error[E030-", "error[E031-"];

/// What became of a program.
enum Verdict {
    Passed,
    /// It has no main reactor, for others import it.
    Library,
    /// It needs something of LF that is not there.
    Refused(String),
    Failed(String),
}

/// Runs all programs below a folder, or those whose paths contain a text; or checks them with
/// [bodies that are empty](empty_bodies).
pub(crate) fn run(repository: &Path, folder: &Path, only: Option<&str>, with_empty_bodies: bool) -> ExitCode {
    let mut cargo = process::cargo(repository);
    cargo.args(["build", "--release", "--quiet", "--package", "lfz"]);
    if !process::succeeds(&mut cargo) {
        return ExitCode::FAILURE;
    }
    let target = process::target_folder(repository);
    let (lfz, output) = (target.join("release/lfz"), target.join("lf-tests"));
    let programs = match programs(folder, &output, with_empty_bodies) {
        Ok(programs) => programs,
        Err(error) => {
            eprintln!("error: {}: {error}", folder.display());
            return ExitCode::FAILURE;
        }
    };
    let mut counts = Counts::default();
    for (name, path) in programs.iter().filter(|(name, _)| only.is_none_or(|only| name.contains(only))) {
        let mut command = Command::new(&lfz);
        if with_empty_bodies {
            command.arg("check").arg(path);
        } else {
            command.args(["run", "--timeout", TIME_LIMIT, "--out"]).arg(output.join(name)).arg(path);
        }
        counts.add(name, judge(&mut command));
    }
    counts.close()
}

/// How many programs came out how.
#[derive(Default)]
struct Counts {
    passed: usize,
    failed: usize,
    libraries: usize,
    /// How many were refused for which reason.
    refused: BTreeMap<String, usize>,
}

impl Counts {
    fn add(&mut self, name: &str, verdict: Verdict) {
        match verdict {
            Verdict::Passed => {
                self.passed += 1;
                println!("passed   {name}");
            }
            Verdict::Library => self.libraries += 1,
            Verdict::Refused(reason) => {
                println!("refused  {name}: {reason}");
                *self.refused.entry(reason).or_default() += 1;
            }
            Verdict::Failed(reason) => {
                self.failed += 1;
                println!("FAILED   {name}: {reason}");
            }
        }
    }

    fn close(self) -> ExitCode {
        let Self { passed, failed, libraries, refused } = self;
        let mut reasons: Vec<_> = refused.into_iter().collect();
        reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        for (reason, count) in &reasons {
            println!("refused {count} times: {reason}");
        }
        println!("{libraries} files without a main reactor");
        println!("{passed} passed, {failed} failed, {} refused", reasons.iter().map(|(_, count)| count).sum::<usize>());
        if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }
}

/// The programs below a folder, by their paths in it; where bodies are to be empty, copies of them.
fn programs(folder: &Path, output: &Path, with_empty_bodies: bool) -> io::Result<Vec<(String, PathBuf)>> {
    let mut found = Vec::new();
    find(folder, &mut found)?;
    found.sort();
    let mut programs = Vec::new();
    for path in found {
        let name = path.strip_prefix(folder).unwrap_or(&path).display().to_string();
        if with_empty_bodies {
            let copy = output.join("empty-bodies").join(&name);
            copy.parent().map_or(Ok(()), fs::create_dir_all)?;
            fs::write(&copy, empty_bodies(&String::from_utf8_lossy(&fs::read(&path)?)))?;
            programs.push((name, copy));
        } else {
            programs.push((name, path));
        }
    }
    Ok(programs)
}

/// A program for any target as one for Rust: its bodies are empty, and so are its types and values where they are code.
fn empty_bodies(program: &str) -> String {
    let mut text = String::with_capacity(program.len());
    let mut rest = program;
    while let Some((before, after)) = rest.split_once("{=") {
        push_types(&mut text, before);
        let (code, behind) = after.split_once("=}").unwrap_or((after, ""));
        let is_value = before.trim_end().ends_with([':', '=', '(', ',', '<']);
        text.push_str(if is_value { "{= () =}" } else { "{= =}" });
        // Lines stay where they are, so that errors point into the original as well.
        text.extend(code.chars().filter(|character| *character == '\n'));
        rest = behind;
    }
    push_types(&mut text, rest);
    for target in ["CCpp", "Cpp", "C", "Python", "TypeScript"] {
        for end in [" ", ";", "\n", "{"] {
            text = text.replacen(&format!("target {target}{end}"), &format!("target Rust{end}"), 1);
        }
    }
    text
}

/// Adds a part of a program without the `*` and `[…]` behind types, which only C has.
fn push_types(text: &mut String, part: &str) {
    let mut pieces = part.split_inclusive(':');
    text.push_str(pieces.next().unwrap_or_default());
    for piece in pieces {
        let name = piece.find(|character: char| !(character.is_alphanumeric() || " _".contains(character)));
        let (name, mut behind) = piece.split_at(name.unwrap_or(piece.len()));
        text.push_str(name);
        while !name.trim().is_empty() {
            let shorter = behind.strip_prefix('*').or_else(|| behind.strip_prefix('[')?.split_once(']').map(|it| it.1));
            let Some(shorter) = shorter else { break };
            behind = shorter;
        }
        text.push_str(behind);
    }
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

/// What became of a program that is run or checked so.
fn judge(command: &mut Command) -> Verdict {
    let result = match command.stdin(Stdio::null()).output() {
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
