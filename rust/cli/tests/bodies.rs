// SPDX-License-Identifier: Apache-2.0
//! The diagnostics of mistakes in bodies: at once, when rustc checks them, and when they run. The file beside each
//! program has its diagnostics.
//!
//! `cargo xtask bless -p lfz bodies::` rewrites the expected output.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Returns the folder of the programs.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bodies")
}

/// Returns a command's output about a program, without the parts that differ from run to run.
fn said(arguments: &[&str], file: &str, out: Option<&PathBuf>) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
    command.current_dir(folder()).args(arguments).arg(file);
    command.env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_INCREMENTAL", "0").env_remove("RUST_BACKTRACE");
    // The quotation marks of C compilers depend on it.
    command.env("LC_ALL", "C.UTF-8");
    if let Some(out) = out {
        command.arg("--out").arg(out);
    }
    let output = command.output().expect("lfz can be started");
    let lines = [output.stderr, output.stdout].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    let (out, mut text) = (out.map(|out| out.display().to_string()), format!("> lfz {} {file}\n", arguments.join(" ")));
    // These lines come from builds, also from others that run at the same time.
    let begins = ["Compil", "Check", "Blocking", "Waiting", "Finished", "Locking", "Updating"];
    let is_of_build = |line: &&str| begins.iter().any(|begin| line.starts_with(begin));
    for line in lines.lines().filter(|line| !is_of_build(line)) {
        let line = out.as_ref().map_or_else(|| line.to_owned(), |out| line.replace(out, "OUT"));
        text = text + line.trim_end() + "\n";
    }
    text
}

#[test]
fn every_mistake_in_a_body_is_told_at_its_place() {
    let mut names: Vec<String> = fs::read_dir(folder())
        .expect("the folder is part of the repository")
        .map(|entry| entry.expect("the folder can be listed").file_name().to_string_lossy().into_owned())
        .filter_map(|name| name.strip_suffix(".lf").map(str::to_owned))
        .collect();
    names.sort();
    assert!(names.len() >= 15, "only {} programs were found", names.len());
    for name in names {
        let file = format!("{name}.lf");
        let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bodies").join(&name);
        // Each further step is for mistakes that the previous one has not noticed.
        let mut text = String::new();
        for arguments in [&["check"][..], &["check", "--bodies"], &["run"]] {
            text += &said(arguments, &file, (arguments != ["check"]).then_some(&out));
            if text.contains(": error") {
                break;
            }
            text.push('\n');
        }
        insta::with_settings!({
            snapshot_path => "bodies",
            prepend_module_to_snapshot => false,
            omit_expression => true,
        }, {
            insta::assert_snapshot!(name, text);
        });
    }
}
