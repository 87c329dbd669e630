// SPDX-License-Identifier: Apache-2.0
//! `lfz check` for editors and scripts: several files, the standard input, diagnostics in JSON.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::support::text;

const RIGHT: &str = "target Rust\nmain reactor {\n}\n";
const WRONG: &str = "target Rust
reactor A {
  output y: u8
}
main reactor {
  a = new A()
  a.y /* ü */, a.b -> a.c
}
";

/// Checks the programs `Right.lf` and `Wrong.lf`, with this standard input.
fn check(folder: &Path, arguments: &[&str], input: &str) -> Output {
    fs::write(folder.join("Right.lf"), RIGHT).expect("it can be written");
    fs::write(folder.join("Wrong.lf"), WRONG).expect("it can be written");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
    command.current_dir(folder).arg("check").args(arguments);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("lfz can be started");
    child.stdin.take().expect("it is a pipe").write_all(input.as_bytes()).expect("a pipe takes that");
    child.wait_with_output().expect("it ends")
}

#[test]
fn each_of_several_programs_is_checked() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = check(folder.path(), &["Wrong.lf", "Missing.lf", "Right.lf"], "");
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(text(&output.stdout), "Right.lf: no errors\n");
    let errors = text(&output.stderr);
    assert!(errors.contains("Wrong.lf: 2 errors\n") && errors.contains("Missing.lf: 1 error\n"), "{errors}");
    assert_eq!(check(folder.path(), &["Right.lf", "Right.lf"], "").status.code(), Some(0));
}

#[test]
fn the_standard_input_is_a_program_of_the_current_folder() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let input = "target Rust\nimport A from \"Own.lf\"\nmain reactor {\n  a = new A()\n}\n";
    let output = check(folder.path(), &["-"], input);
    let error = text(&output.stderr);
    assert!(error.contains("standard_input.lf:2:") && error.contains("standard input: 1 error"), "{error}");
    fs::write(folder.path().join("Own.lf"), "target Rust\nreactor A {\n}\n").expect("it can be written");
    let output = check(folder.path(), &["-"], input);
    assert_eq!(text(&output.stdout), "standard input: no errors\n");
    let output = check(folder.path(), &["-", "--bodies"], RIGHT);
    let error = text(&output.stderr);
    assert!(error.contains("the standard input has no folder"), "{error}");
}

#[test]
fn a_deployment_is_checked_beside_its_program() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let program = "target Rust\nreactor A {\n}\nfederated reactor {\n  one = new A()\n}\n";
    let deployment = folder.path().join("deployment.yaml");
    for (text, error) in [
        ("federates:\n  one: { platform: host }\n", ""),
        ("federates:\n  two: { platform: host }\n", "deployment.yaml:2:8: error: standard_input has no federate named"),
        ("federates: [\n", "deployment.yaml:"),
    ] {
        fs::write(&deployment, text).expect("it can be written");
        let output = check(folder.path(), &["-", "--deployment", "deployment.yaml"], program);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(said.contains(error) && output.status.success() == error.is_empty(), "{said}");
    }
    let output = check(folder.path(), &["-", "--deployment", "nothing.yaml"], program);
    assert!(text(&output.stderr).contains("cannot read nothing.yaml: it does not exist"));
}

#[test]
fn diagnostics_are_a_list_in_json() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = check(folder.path(), &["--json", "Wrong.lf", "Right.lf", "-"], "target Rust\nmain reactor {\n");
    assert_eq!(output.status.code(), Some(1));
    insta::assert_snapshot!(text(&output.stdout));
    let output = check(folder.path(), &["--json", "Right.lf"], "");
    assert_eq!((text(&output.stdout).trim(), output.status.code()), ("[]", Some(0)));
}

/// A shell completes what people use, and there are manual pages of the same.
#[test]
fn completions_and_manual_pages_have_the_commands_for_people() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let lfz = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_lfz")).current_dir(folder.path()).args(arguments).output();
        output.expect("lfz can be started")
    };
    let script = lfz(&["completions", "bash"]).stdout;
    fs::write(folder.path().join("script"), script).expect("it can be written");
    let completed = |word: &str| {
        let line = format!(
            ". ./script; COMP_WORDS=(lfz {word}); COMP_CWORD=1; _lfz lfz {word} lfz; echo \"${{COMPREPLY[@]}}\""
        );
        let output = Command::new("bash").current_dir(folder.path()).args(["-c", &line]).output();
        text(&output.expect("there is a bash").stdout).trim().to_owned()
    };
    assert_eq!((completed("ru"), completed("f"), completed("sup")), ("run".into(), "fmt".into(), String::new()));
    assert_eq!((completed("gr"), completed("--qu")), ("graph".into(), "--quiet".into()));
    for shell in ["fish", "zsh"] {
        let script = text(&lfz(&["completions", shell]).stdout);
        assert!(script.contains("without") && script.contains("verbose"), "{shell}");
    }
    assert!(lfz(&["man", "pages"]).status.success());
    let pages = fs::read_dir(folder.path().join("pages")).expect("it was made");
    let mut pages: Vec<String> = pages.map(|page| page.unwrap().file_name().into_string().unwrap()).collect();
    pages.sort();
    insta::assert_snapshot!(pages.join(" "));
    fs::write(folder.path().join("file"), "").expect("it can be written");
    let error = text(&lfz(&["man", "file"]).stderr);
    assert!(error.contains("no page is written in file"), "{error}");
}
