// SPDX-License-Identifier: Apache-2.0
//! `lfz supervise`, with shells that stand in for an RTI and federates.

use std::io::Write;
use std::process::{Command, Output, Stdio};

/// Runs a description from standard input to its end.
fn supervise(description: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
    command.args(["supervise", "-"]).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut process = command.spawn().expect("lfz can be started");
    let mut input = process.stdin.take().expect("it is piped");
    input.write_all(description.as_bytes()).expect("lfz reads all");
    drop(input);
    process.wait_with_output().expect("lfz ends")
}

#[test]
fn federates_start_when_the_rti_listens_and_are_told_what_is_known_then() {
    let output = supervise(
        r#"{
          "version": 1,
          "speaker": "me",
          "id": { "begins_with": "Grid" },
          "rti": { "name": "RTI", "words": ["sh", "-c", "echo $1; echo listening on TCP port 4711", "sh",
            { "known": "federation_id" }] },
          "federates": [{ "name": "a", "words": ["sh", "-c", "echo $1 $2 $X $PWD; exit 3", "sh",
            { "before": "localhost:", "known": "rti_port" }, { "before": "id=", "known": "federation_id" }],
            "environment": { "X": "from here" }, "folder": "/" }]
        }"#,
    );
    assert_eq!(output.status.code(), Some(3));
    let text = String::from_utf8(output.stdout).expect("it is text");
    let lines: Vec<&str> = text.lines().collect();
    let [rti, federate] = lines[..] else { panic!("one line of each: {text}") };
    let id = rti.strip_prefix("RTI | ").expect("the RTI is told the id");
    assert!(id.starts_with("Grid-"), "{id}");
    assert_eq!(federate, format!("a   | localhost:4711 id={id} from here /"));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "me  | a ended with exit status 3\n");
}

#[test]
fn federates_do_not_start_without_their_rti() {
    let output = supervise(
        r#"{ "version": 1, "speaker": "me", "id": { "exactly": "f" },
          "rti": { "name": "r", "words": ["sh", "-c", "exit 1"] },
          "federates": [{ "name": "a", "words": ["echo", "here", { "known": "rti_port" }] }] }"#,
    );
    assert_eq!((output.status.code(), output.stdout), (Some(1), Vec::new()));
}

#[test]
fn a_wrong_description_is_refused_with_the_place() {
    let output = supervise("{ \"version\": 1,\n  \"speker\": \"me\" }");
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("-: unknown field `speker`") && text.contains("line 2 column 10"), "{text}");
}
