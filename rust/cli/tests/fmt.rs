// SPDX-License-Identifier: Apache-2.0
//! `lfz fmt` with files as users have them.

use std::fs;
use std::io::Write;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::support::{said, text};

const TYPED: &str = "target Rust\nmain   reactor{\n      timer t(0,1 s)\n}";
const FORMATTED: &str = "target Rust\nmain reactor {\n  timer t(0, 1 s)\n}\n";

fn fmt(folder: &Path, arguments: &[&str]) -> Output {
    said(Command::new(env!("CARGO_BIN_EXE_lfz")).current_dir(folder).arg("fmt").args(arguments))
}

#[test]
fn files_are_formatted_in_place_behind_links_too() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    fs::write(path("a b.lf"), TYPED).expect("it can be written");
    fs::set_permissions(path("a b.lf"), fs::Permissions::from_mode(0o640)).expect("it is ours");
    symlink("a b.lf", path("link.lf")).expect("it can be made");
    let output = fmt(folder.path(), &["link.lf"]);
    assert!(output.status.success() && output.stdout.is_empty(), "{}", text(&output.stderr));
    assert_eq!(fs::read_to_string(path("a b.lf")).expect("it is there"), FORMATTED);
    assert!(path("link.lf").is_symlink());
    let mode = fs::metadata(path("a b.lf")).expect("it is there").permissions().mode();
    assert_eq!(mode & 0o777, 0o640);
    assert_eq!(fs::read_dir(folder.path()).expect("it is there").count(), 2, "nothing else is left");
}

#[test]
fn check_shows_the_difference_and_changes_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("P.lf"), TYPED).expect("it can be written");
    fs::write(folder.path().join("Q.lf"), FORMATTED).expect("it can be written");
    let output = fmt(folder.path(), &["--check", "P.lf", "Q.lf"]);
    assert_eq!(output.status.code(), Some(1));
    insta::assert_snapshot!(text(&output.stdout));
    assert_eq!(fs::read_to_string(folder.path().join("P.lf")).expect("it is there"), TYPED);
    assert_eq!(fmt(folder.path(), &["--check", "Q.lf"]).status.code(), Some(0));
}

#[test]
fn the_standard_input_is_formatted_to_the_standard_output() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
    command.args(["fmt", "-"]).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().expect("lfz can be started");
    child.stdin.take().expect("it is a pipe").write_all(TYPED.as_bytes()).expect("it is read");
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(text(&output.stdout), FORMATTED);
}

/// Files behind one that cannot be formatted are formatted nevertheless.
#[test]
fn what_is_wrong_with_a_file_is_told_and_the_others_are_formatted() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("folder.lf")).expect("it can be made");
    fs::write(path("latin.lf"), b"target Rust // gr\xfc\xdfe\n").expect("it can be written");
    fs::write(path("wrong.lf"), "target Rust\nmain reactor {\n").expect("it can be written");
    fs::write(path("P.lf"), TYPED).expect("it can be written");
    let output = fmt(folder.path(), &["missing.lf", "folder.lf", "latin.lf", "wrong.lf", "P.lf"]);
    assert_eq!(output.status.code(), Some(1));
    insta::assert_snapshot!(text(&output.stderr));
    assert_eq!(fs::read_to_string(path("P.lf")).expect("it is there"), FORMATTED);
}
