// SPDX-License-Identifier: Apache-2.0
//! Runs the programs of a folder, such as LF's tests of its targets, and prints the outcome of each.

mod verdicts;

use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use self::verdicts::{Verdict, Verdicts};

use crate::process;
use crate::zephyr;

/// The time in seconds after which a program is stopped.
const TIME_LIMIT_S: u32 = 60;

/// The exit status of `lfz run`, and of `timeout`, when that time is over.
const TIMED_OUT: i32 = 124;

/// The beginnings of diagnostics that refuse a part of LF.
const REFUSALS: [&str; 3] = ["error[E010-", "error[E030-", "error[E031-"];

/// Folders of programs that LF's own compiler does not run either.
const NOT_RUN_BY_LF: [&str; 4] = ["failing", "failed", "knownfailed", "fed-gen"];

/// The way in which programs are tested.
pub(crate) enum TestMode<'a> {
    /// They run on this computer, those of federations with this RTI, or our own.
    Run(Option<&'a Path>),
    /// They are checked, with [bodies that are empty](empty_bodies).
    EmptyBodies,
    /// They run as images for a board of `native_sim`.
    Image(&'a str),
}

/// Runs or checks all programs below a folder, or those whose paths contain a text.
pub(crate) fn run(repository: &Path, folder: &Path, only: Option<&str>, mode: &TestMode<'_>) -> ExitCode {
    let mut cargo = process::cargo(repository);
    cargo.args(["build", "--release", "--quiet", "--package", "lfz"]);
    if !process::succeeds(&mut cargo) {
        return ExitCode::FAILURE;
    }
    let target = process::target_folder(repository);
    let (lfz, output) = (target.join("release/lfz"), target.join("lf-tests"));
    let programs = match programs(folder, &output, mode) {
        Ok(programs) => programs,
        Err(error) => {
            eprintln!("error: {}: {error}", folder.display());
            return ExitCode::FAILURE;
        }
    };
    let mut counts = Verdicts::default();
    for (name, path) in programs.iter().filter(|(name, _)| only.is_none_or(|only| name.contains(only))) {
        let mut command = Command::new(&lfz);
        counts.add(
            name,
            match mode {
                TestMode::Run(rti) => why_not(name, &fs::read_to_string(path).unwrap_or_default()).map_or_else(
                    || {
                        command.args(["run", "--timeout", &format!("{TIME_LIMIT_S} s"), "--out"]);
                        command.arg(output.join(name)).arg(path);
                        command.args(rti.iter().flat_map(|rti| [Path::new("--rti"), rti]));
                        judge(&mut command)
                    },
                    Verdict::Refused,
                ),
                TestMode::EmptyBodies => judge(command.arg("check").arg(path)),
                TestMode::Image(board) => judge_image(repository, &lfz, board, path, &output.join("image")),
            },
        );
    }
    counts.close()
}

/// Returns the programs below a folder, by their paths in it: copies of them if they have to be changed.
fn programs(folder: &Path, output: &Path, mode: &TestMode<'_>) -> io::Result<Vec<(String, PathBuf)>> {
    let mut found = Vec::new();
    find(folder, &mut found)?;
    found.sort();
    let mut programs = Vec::new();
    for path in found {
        let name = path.strip_prefix(folder).unwrap_or(&path).display().to_string();
        let path = if matches!(mode, TestMode::EmptyBodies) {
            let copy = output.join("empty-bodies").join(&name);
            copy.parent().map_or(Ok(()), fs::create_dir_all)?;
            fs::write(&copy, empty_bodies(&String::from_utf8_lossy(&fs::read(&path)?)))?;
            copy
        } else {
            path
        };
        programs.push((name, path));
    }
    Ok(programs)
}

/// Converts a program for any target to one for Rust with empty bodies, and empty types and values where they are code.
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
        } else if path.extension().is_some_and(|extension| extension == "lf" || extension == "ulf") {
            programs.push(path);
        }
    }
    Ok(())
}

/// The name of the copy that becomes an image: all have one build folder, and Zephyr is compiled once.
const COPY: &str = "LfTest";

/// Returns the outcome of a program that runs as an image.
///
/// The copy is beside the program, where its imports are found, and is removed again.
fn judge_image(repository: &Path, lfz: &Path, board: &str, program: &Path, output: &Path) -> Verdict {
    let ending = program.extension().unwrap_or_default();
    let copy = program.with_file_name(COPY).with_extension(ending);
    // An existing file of this name belongs to the user.
    let written = fs::read_to_string(program)
        .and_then(|text| fs::File::create_new(&copy)?.write_all(without_main_name(&text).as_bytes()));
    if let Err(error) = written {
        return Verdict::Failed(format!("{} cannot be written: {error}", copy.display()));
    }
    let mut build = zephyr::command_in_workspace(repository, Path::new("python3"));
    build.arg(repository.join("scripts/lf")).arg("lf-build").arg(&copy).env("LFZ", lfz);
    let verdict = judge(build.args(["-w", &format!("-b {board}"), "--build-dir"]).arg(output));
    let removed = fs::remove_file(&copy);
    match (verdict, removed) {
        (Verdict::Passed, Ok(())) => {
            let image = output.join("zephyr").join(COPY).join(COPY).join("zephyr/zephyr.exe");
            judge(Command::new("timeout").arg(TIME_LIMIT_S.to_string()).arg(image))
        }
        (Verdict::Passed, Err(error)) => Verdict::Failed(format!("{}: {error}", copy.display())),
        (verdict, _) => verdict,
    }
}

/// Removes the name of the main reactor, which has to be that of its file.
fn without_main_name(program: &str) -> String {
    let Some((before, after)) = program.split_once("main reactor") else { return program.to_owned() };
    let name = after.trim_start().find(|character: char| !(character.is_alphanumeric() || character == '_'));
    format!("{before}main reactor {}", &after.trim_start()[name.unwrap_or(0)..])
}

/// Returns why a program does not run on this computer, as far as its text shows.
fn why_not(name: &str, text: &str) -> Option<String> {
    let folders = name.split('/').collect::<Vec<_>>();
    if let Some(folder) = folders.iter().find(|folder| NOT_RUN_BY_LF.contains(folder)) {
        return Some(format!("LF does not run what is in a folder `{folder}`"));
    }
    let head = text.split("reactor").next().unwrap_or_default();
    let platform = head.split_once("platform:").map(|(_, behind)| behind.lines().take(3).collect::<String>());
    if head.contains("target C") && platform.is_some_and(|platform| platform.to_lowercase().contains("zephyr")) {
        return Some("the program is for Zephyr: `west lf-build` makes an image of it".to_owned());
    }
    text.contains("@property(").then(|| "the program is to be verified, and not to be run".to_owned())
}

/// Returns the outcome of a command that runs, builds or checks a program.
fn judge(command: &mut Command) -> Verdict {
    let result = match command.stdin(Stdio::null()).output() {
        Ok(result) => result,
        Err(error) => return Verdict::Failed(format!("lfz cannot be started: {error}")),
    };
    if result.status.success() {
        return Verdict::Passed;
    }
    let said = [&result.stderr[..], &result.stdout].map(String::from_utf8_lossy).concat();
    let is_said = |line: &&str| line.to_lowercase().contains("error") && !line.contains(": no errors");
    let errors = || said.lines().filter(|line| !line.trim_start().starts_with("hint:")).filter(is_said);
    if said.contains("error[E040") {
        return Verdict::Library;
    }
    if let Some(refusal) = errors().find(|line| REFUSALS.iter().any(|code| line.contains(code))) {
        let reason = refusal.split_once("]: ").map_or(refusal, |(_, reason)| reason);
        return Verdict::Refused(reason.to_owned());
    }
    let last = || said.lines().rev().filter(|line| !line.trim().is_empty());
    Verdict::Failed(match result.status.code() {
        Some(TIMED_OUT) => format!("does not end within {TIME_LIMIT_S} s"),
        _ => errors()
            .chain(said.lines().filter(|line| line.contains("panicked")))
            .chain(last())
            .next()
            .unwrap_or_default()
            .to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::why_not;

    #[test]
    fn programs_that_need_something_else_say_so() {
        let is_run = |name, text| why_not(name, text).is_none();
        assert!(is_run("concurrent/A.lf", "target C {\n  platform: Linux\n}\nmain reactor { }"));
        assert!(is_run("A.lf", "target Rust { platform: Zephyr }\nmain reactor { }"));
        assert!(!is_run("A.lf", "target C {\n  platform: {\n    name: zephyr\n  }\n}\nmain reactor { }"));
        assert!(!is_run("concurrent/failing/A.lf", "target C\nmain reactor { }"));
        assert!(!is_run("A.lf", "target C\n@property(name=\"p\")\nmain reactor { }"));
    }
}
