// SPDX-License-Identifier: Apache-2.0
//! Debuggers and backtraces find the lines of bodies in the LF program.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::support::{folder, lfz, said, text};

/// Its lines 8 to 11 and 22 are bodies. Characters of several bytes stand before what is looked for.
const PROGRAM: &str = r#"target Rust { timeout: 1 ms }
import Helper from "Helper.lf"
reactor Shows {
  state count: u32 = 0
  output y: u32
  timer t(0, 1 ms)
  reaction(t) -> y {=
    self.count += 1;
    let grüße = "ü"; let shown = std::backtrace::Backtrace::force_capture();
    let twice = self.count * 2;
    ctx.set(y, twice); println!("{grüße} {shown}");
  =}
}
federated reactor {
  shows = new Shows()
  helper = new Helper()
  shows.y -> helper.x
}
"#;
const HELPER: &str = r"target Rust
reactor Helper {
  input x: u32
  reaction(x) {=
    let got = ctx.get(x).unwrap_or_default();
    assert!(got > 0);
  =}
}
";

/// The debugging information that lines need.
const LINES: &str = "line-tables-only";

/// Returns a folder with the program, built with this debugging information, and what the build said.
fn built(profile: &str) -> (tempfile::TempDir, Output) {
    let folder = folder(&[("P.lf", PROGRAM), ("Helper.lf", HELPER)]);
    let output = said(lfz(folder.path(), &["build"]).env("CARGO_PROFILE_DEV_DEBUG", profile));
    assert!(output.status.success(), "{}", text(&output.stderr));
    (folder, output)
}

/// Returns the program of a federate, as the build has named it.
fn program(build: &Output, federate: &str) -> PathBuf {
    let lines = text(&build.stdout);
    let line = lines.lines().find_map(|line| line.strip_prefix(federate)).expect("it was built");
    PathBuf::from(line.trim())
}

/// Returns what gdb says of a program after these commands.
fn gdb(program: &Path, commands: &[&str]) -> String {
    let mut gdb = Command::new("gdb-multiarch");
    gdb.args(["-q", "-batch", "-nx", "-iex", "set auto-load off"]);
    gdb.args(commands.iter().flat_map(|command| ["-ex", command])).arg(program);
    let output = gdb.output().expect("gdb can be started: apt install gdb-multiarch");
    text(&output.stdout) + &text(&output.stderr)
}

#[test]
fn lines_and_columns_of_bodies_are_those_of_the_program() {
    let (folder, build) = built(LINES);
    let file = fs::canonicalize(folder.path().join("P.lf")).expect("it is there");
    let (shows, helper) = (program(&build, "shows"), program(&build, "helper"));
    // The column counts bytes, as Rust's compiler does.
    let column = PROGRAM.lines().nth(8).and_then(|line| line.find("std::backtrace")).expect("it is there") + 1;
    let places = gdb(&shows, &["info line P.lf:8", "info line P.lf:10", "maintenance info line-table P.lf"]);
    assert!(places.contains(&format!("Line 8 of \"{}\"", file.display())), "{places}");
    assert!(places.contains("Line 10 of") && !places.contains("no code"), "{places}");
    assert!(places.lines().any(|line| line.split_whitespace().nth(1) == Some("9")), "{places}");
    let helper = gdb(&helper, &["info line Helper.lf:6"]);
    assert!(helper.contains("Line 6 of") && !helper.contains("no code"), "{helper}");
    // A second build finds the lines named, or compiles nothing and names them again.
    let again = said(lfz(folder.path(), &["build"]).env("CARGO_PROFILE_DEV_DEBUG", LINES));
    assert!(again.status.success(), "{}", text(&again.stderr));
    assert_eq!(gdb(&shows, &["info line P.lf:8"]), gdb(&program(&again, "shows"), &["info line P.lf:8"]));
    // What the program itself reads of its debugging information are the same places.
    let run = said(lfz(folder.path(), &["run"]).env("CARGO_PROFILE_DEV_DEBUG", LINES));
    let output = text(&run.stdout);
    assert!(output.contains(&format!("P.lf:9:{column}")), "{output}");
}

#[test]
fn a_breakpoint_stops_where_the_program_says_and_lines_are_steps() {
    let (folder, build) = built(LINES);
    let shows = program(&build, "shows");
    let rti_is_missing = gdb(&shows, &["break P.lf:8", "info breakpoints"]);
    assert!(rti_is_missing.contains("P.lf:8"), "{rti_is_missing}");
    // One that is not federated needs no other process.
    let alone = PROGRAM.replace("federated reactor", "main reactor");
    fs::write(folder.path().join("P.lf"), alone).expect("it can be written");
    let output = said(lfz(folder.path(), &["build"]).env("CARGO_PROFILE_DEV_DEBUG", LINES));
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = gdb(&program(&output, "P"), &["break P.lf:8", "run", "next", "next", "next", "kill"]);
    let stops: Vec<&str> = said.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_digit())).collect();
    let expected: Vec<String> =
        PROGRAM.lines().zip(1..).skip(7).take(4).map(|(line, number)| format!("{number}\t{line}")).collect();
    assert_eq!(stops, expected, "{said}");
}

/// Nothing is converted without debugging information, and nothing is wrong then.
#[test]
fn a_program_without_debugging_information_is_built_as_ever() {
    let (folder, build) = built("0");
    let before = fs::read(program(&build, "shows")).expect("it is there");
    assert!(said(lfz(folder.path(), &["build"]).env("CARGO_PROFILE_DEV_DEBUG", "0")).status.success());
    assert!(fs::read(program(&build, "shows")).expect("it is there") == before);
}

#[test]
fn a_federate_that_is_left_out_can_be_started_by_hand() {
    let (folder, _) = built("0");
    let unknown = said(lfz(folder.path(), &["run"]).args(["--without", "nobody"]).env("CARGO_PROFILE_DEV_DEBUG", "0"));
    let error = text(&unknown.stderr);
    assert!(error.contains("no federate `nobody`; P has helper, shows"), "{error}");
    let several = said(lfz(folder.path(), &["debug"]).args(["--debugger", "true"]).env("CARGO_PROFILE_DEV_DEBUG", "0"));
    let error = text(&several.stderr);
    assert!(error.contains("name the one to debug after the file, of helper, shows"), "{error}");
}

/// The debugger gets the program and its arguments as they are.
#[test]
fn a_debugger_is_started_with_the_program_and_its_arguments() {
    let (folder, _) = built("0");
    let mut command = lfz(folder.path(), &["debug"]);
    command.args(["shows", "--debugger", "echo", "--", "--id", "a b"]).env("CARGO_PROFILE_DEV_DEBUG", "0");
    let output = said(&mut command);
    let shown = text(&output.stdout);
    assert!(shown.starts_with("--args /") && shown.trim_end().ends_with("/p-shows --id a b"), "{shown}");
    let mut missing = lfz(folder.path(), &["debug"]);
    missing.args(["shows", "--debugger", "no-such-debugger"]).env("CARGO_PROFILE_DEV_DEBUG", "0");
    let error = text(&said(&mut missing).stderr);
    assert!(error.contains("the debugger no-such-debugger cannot be run"), "{error}");
}
