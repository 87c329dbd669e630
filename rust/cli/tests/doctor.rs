// SPDX-License-Identifier: Apache-2.0
//! The page of `lfz doctor` about programs that other people wrote.

use std::process::Command;

use crate::support::{folder, said, text};

#[test]
fn a_folder_of_foreign_programs_is_told_in_one_page() {
    let program = |head: &str, body: &str| format!("{head}\nmain reactor {{ reaction(startup) {{= {body} =}} }}\n");
    let folder = folder(&[
        ("P.lf", &program("target C", "")),
        ("a/Warned.lf", &program("target C { build: \"./b.sh\", cmake-include: \"a.cmake\" }", "")),
        ("a/a.cmake", ""),
        ("a/Library.lf", "target C\nreactor A { }\n"),
        ("a/Micro.ulf", &program("@platform(\"native\")", "validate(true);")),
        ("b/Wrong.lf", &program("target C { ros2: true, files: \"x.h\" }", "")),
        ("b/Snake.lf", &program("target Python", "")),
        ("build/lfc_include/Package.lf", &program("target C { ros2: true }", "")),
    ]);
    let doctor = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
        said(command.current_dir(folder.path()).arg("doctor").args(arguments))
    };
    let output = doctor(&[]);
    let all = text(&output.stdout);
    let (programs, computer) = all.split_once("\nThis computer\n").expect("it is told");
    insta::assert_snapshot!(programs);
    assert!(computer.contains("cargo") && output.status.code() == Some(1), "{all}");

    assert_eq!(doctor(&["P.lf", "a"]).status.code(), Some(0));
    let nothing = doctor(&["nowhere"]);
    assert_eq!(text(&nothing.stderr), "error: nowhere does not exist\n");
}
