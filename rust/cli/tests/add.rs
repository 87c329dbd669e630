// SPDX-License-Identifier: Apache-2.0
//! `lfz add`: crates in the target declaration of a program.

use std::fs;
use std::process::{Command, Output};

use crate::support::{folder, said, text};

const PROGRAM: &str = "// The program.
target Rust {
  timeout: 0 // at once
}
main reactor {
  reaction(startup) {= println!(\"{}\", thermo::celsius(29_315)); =}
}
";

#[test]
fn a_crate_in_a_folder_is_added_and_can_be_used() {
    let manifest = "[package]\nname = \"thermo\"\nversion = \"0.1.0\"\nedition = \"2024\"\n";
    let code = "pub fn celsius(reading: i32) -> i32 { (reading - 27_315) / 100 }\n";
    let files = [("src/P.lf", PROGRAM), ("thermo/Cargo.toml", manifest), ("thermo/src/lib.rs", code)];
    let folder = folder(&files);
    let lfz = |arguments: &[&str]| -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
        command.env("CARGO_NET_OFFLINE", "true").env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_INCREMENTAL", "0");
        said(command.current_dir(folder.path()).args(arguments))
    };
    let output = lfz(&["add", "src/P.lf", "--path", "thermo"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "src/P.lf has thermo: { path: \"../thermo\" }\n");
    let program = fs::read_to_string(folder.path().join("src/P.lf")).expect("it is there");
    let added = "timeout: 0, // at once\n  cargo-dependencies: { thermo: { path: \"../thermo\" } }\n}";
    assert_eq!(program, PROGRAM.replace("timeout: 0 // at once\n}", added));
    assert_eq!(text(&lfz(&["run", "-q", "src/P.lf", "--out", "out"]).stdout), "20\n");
    let output = lfz(&["add", "src/P.lf", "a-crate-that-nobody-has-written"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("a-crate-that-nobody-has-written"), "{}", text(&output.stderr));
    assert_eq!(fs::read_to_string(folder.path().join("src/P.lf")).expect("it is there"), program);
}
