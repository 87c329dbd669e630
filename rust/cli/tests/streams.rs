// SPDX-License-Identifier: Apache-2.0
//! The input of programs under `lfz run`, and output that cannot be written.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::support::{folder, lfz, said, text};

const ECHO: &str = "target Rust\nmain reactor {\n  reaction(startup) {=\n    let mut line = String::new();\n    \
                    std::io::stdin().read_line(&mut line).unwrap();\n    println!(\"read {line:?}\");\n  =}\n}\n";

#[test]
fn a_program_with_one_process_reads_the_input() {
    let folder = folder(&[("P.lf", ECHO)]);
    let mut command = lfz(folder.path(), &["run"]);
    let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("lfz can be started");
    process.stdin.take().expect("it is piped").write_all(b"hello\n").expect("it is read");
    let output = process.wait_with_output().expect("it ends");
    assert_eq!(text(&output.stdout), "read \"hello\\n\"\n");
}

fn full() -> File {
    File::options().write(true).open("/dev/full").expect("Linux has it")
}

/// Returns a command of `lfz supervise` with a description in a folder.
fn supervise(folder: &Path, description: &str) -> Command {
    std::fs::write(folder.join("run.json"), description).expect("it can be written");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
    command.current_dir(folder).args(["supervise", "run.json"]);
    command
}

#[test]
fn output_without_room_is_an_error_of_each_command() {
    let folder = folder(&[("P.lf", ECHO)]);
    let run = r#"{ "version": 1, "speaker": "me", "id": { "exactly": "f" },
        "federates": [{ "name": "a", "words": ["echo", "here"] }] }"#;
    let mut commands = vec![supervise(folder.path(), run), Command::new(env!("CARGO_BIN_EXE_lfz"))];
    commands[1].arg("--help");
    commands.extend([&["check"][..], &["plan"], &["plan", "--json"]].map(|words| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
        command.current_dir(folder.path()).args(words).arg("P.lf");
        command
    }));
    for mut command in commands {
        let output = said(command.stdout(full()));
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{command:?}: {errors}");
        assert!(errors.contains("the output cannot be written: No space left on device"), "{command:?}: {errors}");
    }
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    let folder = folder(&[("P.lf", ECHO)]);
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
    let output = said(command.current_dir(folder.path()).args(["plan", "P.lf"]).stdout(writer));
    assert_eq!(text(&output.stderr), "");
}

/// `cargo install` and package managers replace programs that run.
#[test]
fn a_run_goes_on_when_lfz_is_replaced() {
    let folder = folder(&[]);
    let own = folder.path().join("lfz");
    std::fs::copy(env!("CARGO_BIN_EXE_lfz"), &own).expect("it can be copied");
    let run = r#"{ "version": 1, "speaker": "me", "id": { "exactly": "f" },
        "rti": { "name": "r", "words": ["sh", "-c", "mv lfz old && rm old && echo listening on TCP port 1"] },
        "federates": [{ "name": "a", "words": ["echo", "here"] },
                      { "name": "b", "words": ["/proc/self/exe", "--version"] }] }"#;
    std::fs::write(folder.path().join("run.json"), run).expect("it can be written");
    let output = said(Command::new(&own).current_dir(folder.path()).args(["supervise", "run.json"]));
    let (shown, errors) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success() && shown.contains("a  | here\n"), "{shown}{errors}");
    assert!(shown.contains("b  | lfz "), "{shown}{errors}");
}
