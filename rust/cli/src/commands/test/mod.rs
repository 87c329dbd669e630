// SPDX-License-Identifier: Apache-2.0
//! `lfz test`

mod case;
mod junit;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Output, Stdio};
use std::time::Instant;

use lf_compiler::syntax::ast::ReactorKind;
use walkdir::WalkDir;

use self::junit::Outcome;
use crate::args::TestArgs;
use crate::compile::read_text;
use crate::failure::Failure;
use crate::terminal;

/// The ending of files that describe tests of a reactor.
const DESCRIBED: &str = ".test.yaml";
/// The beginning of what an image prints. Before it stands the output of Zephyr's build.
const BOOTS: &str = "*** Booting ";
/// The number of lines that are printed of a build that failed, which prints hundreds.
const LAST_LINES: usize = 40;

/// One test: a program that ends with status 0 if it passes.
struct Test {
    name: String,
    program: PathBuf,
    is_federated: bool,
    /// The folder for generated files, if the program itself is one.
    out: Option<PathBuf>,
}

/// Runs the tests of a project, one after the other, and tells the outcome of each.
pub(super) fn test(arguments: &TestArgs) -> Result<ExitCode, Failure> {
    let mut tests = Vec::new();
    for path in &arguments.paths {
        find(path, arguments.board.is_some(), &mut tests)?;
    }
    let all = tests.len();
    tests.retain(|test| arguments.filter.as_ref().is_none_or(|filter| test.name.contains(filter)));
    if arguments.list {
        for test in &tests {
            terminal::print(&test.name)?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    if tests.is_empty() {
        let places: Vec<_> = arguments.paths.iter().map(|path| path.display().to_string()).collect();
        let left_out = if all > 0 { format!("; --filter leaves out all {all}") } else { String::new() };
        let what = "a test is a program with a main reactor, or a file whose name ends in .test.yaml";
        return Err(Failure::message(format!("there are no tests in {}: {what}{left_out}", places.join(", "))));
    }
    let mut outcomes = Vec::new();
    for test in &tests {
        for seed in seeds(test, arguments) {
            let outcome = run(test, seed, arguments)?;
            let word = if outcome.failure.is_none() { "ok" } else { "FAILED" };
            terminal::print(format_args!("{} ... {word} ({:.1} s)", outcome.name, outcome.took.as_secs_f64()))?;
            if let Some(output) = &outcome.failure {
                terminal::report(output);
            }
            outcomes.push(outcome);
        }
    }
    if let Some(file) = &arguments.junit {
        let named = |error| Failure::message(format!("{} cannot be written: {error}", file.display()));
        fs::write(file, junit::report(&outcomes)).map_err(named)?;
    }
    let failed = outcomes.iter().filter(|outcome| outcome.failure.is_some()).count();
    terminal::print(format_args!("{} passed, {failed} failed", outcomes.len() - failed))?;
    Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Adds the tests in a folder or a file.
fn find(path: &Path, is_image: bool, tests: &mut Vec<Test>) -> Result<(), Failure> {
    if !path.exists() {
        let hint = "name the folder of the tests, or a single one";
        return Err(Failure::message(format!("{} does not exist: {hint}", path.display())));
    }
    let is_own = |name: &str| !name.starts_with('.') && !["build", "target"].contains(&name);
    let walk = WalkDir::new(path).sort_by_file_name().into_iter();
    for entry in walk.filter_entry(|entry| entry.depth() == 0 || is_own(&entry.file_name().to_string_lossy())) {
        let entry = entry.map_err(|error| Failure::message(error.to_string()))?;
        let (file, name) = (entry.path(), entry.path().display().to_string());
        if let Some(stem) = name.strip_suffix(DESCRIBED) {
            tests.extend(described(file, stem, is_image)?);
        } else if [".lf", ".ulf"].iter().any(|ending| name.ends_with(ending))
            && let Some(kind) = main_kind(file)?
        {
            let name = name.trim_end_matches(".lf").trim_end_matches(".ulf").to_owned();
            let is_federated = kind == ReactorKind::Federated;
            tests.push(Test { name, program: file.to_owned(), is_federated, out: None });
        }
    }
    Ok(())
}

/// Returns what the main reactor of a file is, if it has one.
fn main_kind(file: &Path) -> Result<Option<ReactorKind>, Failure> {
    let name = file.display().to_string();
    let text = read_text(file).map_err(|error| Failure::message(format!("{name} cannot be read: {error}")))?;
    let unit = lf_compiler::parse(&name, &text).unit;
    Ok(unit.reactors.iter().map(|reactor| reactor.kind).find(|kind| *kind != ReactorKind::Plain))
}

/// Returns the tests that a file describes, and writes their programs.
fn described(file: &Path, stem: &str, is_image: bool) -> Result<Vec<Test>, Failure> {
    let name = file.display().to_string();
    let text = read_text(file).map_err(|error| Failure::message(format!("{name} cannot be read: {error}")))?;
    let folder = file.parent().unwrap_or(Path::new("."));
    let programs = case::programs(&name, &text, folder, is_image)?;
    let out = folder.join("build/lfz/tests").join(Path::new(stem).file_name().unwrap_or_default());
    let mut tests = Vec::new();
    for (number, (case, program)) in programs.into_iter().enumerate() {
        let folder = out.join(number.to_string());
        fs::create_dir_all(&folder)?;
        let path = folder.join("Test.lf");
        fs::write(&path, program)?;
        let name = format!("{stem}: {case}");
        tests.push(Test { name, program: path, is_federated: false, out: Some(folder.join("out")) });
    }
    Ok(tests)
}

/// Returns the seeds with which a test runs. Those of a program without a network make no difference.
fn seeds(test: &Test, arguments: &TestArgs) -> Vec<Option<u64>> {
    match &arguments.seed {
        Some(seeds) if test.is_federated => seeds.clone().map(Some).collect(),
        Some(seeds) => vec![Some(seeds.start)],
        None => vec![None],
    }
}

/// Builds and runs the program of a test.
fn run(test: &Test, seed: Option<u64>, arguments: &TestArgs) -> Result<Outcome, Failure> {
    let mut command = Command::new(std::env::current_exe()?);
    match &arguments.board {
        None => command.arg("run").arg(&test.program),
        Some(board) => {
            let west_command = if test.is_federated { "lf-fed-run" } else { "lf-run" };
            command.args(["west", west_command]).arg(&test.program).arg("--west-commands").arg(format!("-b {board}"));
            if let Some(settings) = settings_beside(test) {
                command.arg("--conf-overlays").arg(settings);
            }
            &mut command
        }
    };
    command.arg("--timeout").arg(format!("{} s", arguments.timeout.as_secs_f64()));
    command.args(arguments.release.then_some("--release"));
    // Programs that describe a case run in virtual time anyway.
    if let Some(seed) = seed.filter(|_| test.out.is_none()) {
        command.arg("--seed").arg(seed.to_string());
    }
    if let Some(out) = &test.out {
        command.arg(if arguments.board.is_some() { "--build-dir" } else { "--out" }).arg(out);
        command.args(arguments.board.is_none().then_some(["--", "--virtual-time"]).into_iter().flatten());
    }
    // The reason says which value is wrong; where it was compared is no news.
    command.env("RUST_BACKTRACE", "0");
    let begin = Instant::now();
    let output = command.stdin(Stdio::null()).output()?;
    let failure = (!output.status.success()).then(|| said(&output, arguments.board.is_some()));
    let with = seed.filter(|_| test.is_federated).map_or_else(String::new, |seed| format!(", seed {seed}"));
    Ok(Outcome { name: test.name.clone() + &with, took: begin.elapsed(), failure })
}

/// Returns the prj.conf of the project that a test belongs to: that of the nearest folder around it. West finds those
/// in the program's own folder by itself.
fn settings_beside(test: &Test) -> Option<PathBuf> {
    let program = std::path::absolute(&test.program).ok()?;
    let around = program.parent()?.ancestors().skip(1);
    around.map(|folder| folder.join("prj.conf")).find(|file| file.is_file())
}

/// Returns the output of a test that has failed.
fn said(output: &Output, is_image: bool) -> String {
    let text = [&output.stderr[..], &output.stdout].map(|bytes| String::from_utf8_lossy(bytes).into_owned()).concat();
    let lines: Vec<_> = text.lines().filter(|line| !line.starts_with("Compil")).collect();
    let last = || lines.len().saturating_sub(LAST_LINES);
    let boots = || lines.iter().rposition(|line| line.starts_with(BOOTS));
    let first = if is_image { boots().unwrap_or_else(last) } else { 0 };
    lines[first..].iter().flat_map(|line| ["    ", line, "\n"]).collect()
}
