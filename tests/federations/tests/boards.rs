// SPDX-License-Identifier: Apache-2.0
//! `lfz ctl` with virtual boards: shells play the simulators and an RTI that takes commands, since what matters is
//! which of them run, and with which words. Each shell goes on when the test opens its FIFO.

use std::path::Path;
use std::process::{Command, Stdio};

use lf_federations::{Lfz, Run};
use serde_json::{Value, json};

/// Starts the processes of a description, with FIFOs of these names in its folder.
fn supervise(folder: &Path, description: &Value, fifos: &[&str]) -> Run {
    for fifo in fifos {
        assert!(Command::new("mkfifo").arg(folder.join(fifo)).status().expect("it can be run").success());
    }
    let file = folder.join("description.json");
    std::fs::write(&file, description.to_string()).expect("it can be written");
    Run::start(Lfz::command(["supervise", file.to_str().expect("the path is UTF-8")]))
}

/// Lets the shell go on that reads this FIFO.
fn open(folder: &Path, fifo: &str) {
    std::fs::write(folder.join(fifo), "\n").expect("the shell reads");
}

/// Asks the run for something; returns its answer.
fn ctl(run: &Run, words: &[&str]) -> String {
    let id = run.id().to_string();
    let output = Lfz::command(["ctl", "--run", &id].into_iter().chain(words.iter().copied()))
        .stdin(Stdio::null())
        .output()
        .expect("lfz can be started");
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// Returns the words of a shell that prints this and reads the FIFO; then its program has ended, and the board stays.
fn board(folder: &Path, says: &str, fifo: &str) -> Value {
    let fifo = folder.join(fifo);
    json!(["sh", "-c", format!("echo {says}; read -r x < {}; echo status 0; exec tail -f /dev/null", fifo.display())])
}

/// Returns a federation of this transient federate and a persistent one, which ends when its FIFO is opened.
fn with_transient(folder: &Path, takes_commands: bool, transient: &Value) -> Value {
    let commands = "echo listening on TCP port 7; while read -r line; do echo told: $line; done";
    let silent = "echo listening on TCP port 7; exec tail -f /dev/null";
    let end = folder.join("end");
    json!({
        "version": 1, "speaker": "lfz", "id": { "exactly": "f" }, "timeout_ns": 500_000_000_000_u64, "grace_ns": 0,
        "rti": {
            "name": "RTI", "words": ["sh", "-c", if takes_commands { commands } else { silent }],
            "streams": if takes_commands { "commands" } else { "lines" },
        },
        "federates": [
            { "name": "stays", "words": ["sh", "-c", format!("read -r x < {}", end.display())] },
            transient,
        ],
    })
}

#[test]
fn a_board_is_swapped_for_its_spare_and_back() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let transient = json!({
        "name": "meter", "words": board(folder, "first place", "first"), "transient": true, "image_id": 5,
        "status_line": "status ", "instances": { "spare": board(folder, "second place", "second") },
    });
    let mut run = supervise(folder, &with_transient(folder, true, &transient), &["first", "second", "end"]);
    run.wait_for("meter | first place");
    assert!(ctl(&run, &["swap", "meter"]).contains("takes its place"));
    run.wait_for("meter | second place");
    assert!(ctl(&run, &[]).contains("meter: is being swapped"));
    assert!(ctl(&run, &["swap", "meter"]).contains("another instance of meter is about to begin"));
    open(folder, "first");
    run.wait_for("meter | status 0");
    assert!(ctl(&run, &[]).contains("meter: runs on its spare board"));
    // The first board is switched off, and on again.
    let boards = |run: &Run| run.participants().iter().filter(|one| one.command.starts_with("tail")).count();
    assert_eq!(boards(&run), 1);
    assert!(ctl(&run, &["swap", "meter"]).contains("takes its place"));
    while boards(&run) > 0 {}
    open(folder, "second");
    while !ctl(&run, &[]).contains("meter: runs, transient") {}
    // No signal reaches the program on a board.
    assert!(ctl(&run, &["stop", "meter"]).contains("meter is asked to leave"));
    run.wait_for("RTI   | told: stop 5");
    assert!(ctl(&run, &["stop", "meter"]).contains("meter is killed, as it was asked to leave before"));
    run.wait_for("meter was ended by signal 9");
    while !ctl(&run, &[]).contains("meter: does not run") {}
    assert!(ctl(&run, &["start", "meter"]).contains("meter is started"));
    while !ctl(&run, &[]).contains("meter: runs, transient") {}
}

#[test]
fn what_cannot_be_is_said() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let transient = json!({
        "name": "meter", "words": board(folder, "here", "first"), "transient": true, "image_id": 5,
        "status_line": "status ", "instances": "one",
    });
    let mut run = supervise(folder, &with_transient(folder, false, &transient), &["first", "end"]);
    run.wait_for("meter | here");
    let swap = ctl(&run, &["swap", "meter"]);
    assert!(swap.contains("`spare: { ip: ADDRESS }`"), "{swap}");
    let stop = ctl(&run, &["stop", "meter"]);
    assert!(stop.contains("meter is an image, which only its RTI can tell to leave"), "{stop}");
    // Nothing has happened.
    assert!(ctl(&run, &[]).contains("meter: runs, transient"));
}
