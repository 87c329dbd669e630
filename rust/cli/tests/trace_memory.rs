// SPDX-License-Identifier: Apache-2.0
//! `lfz trace` with less memory than the recording has bytes.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::Command;

use lf_linux::model::Part;
use lf_linux::model::time::{Instant, Microstep, Tag};
use lf_linux::runtime::trace::{Event, Header, MessageType, RECORD_BYTES, RTI, Record, Role, TracedMessage, Waits};

/// The number of records of one turn, which contains all kinds of records that repeat.
const TURN: usize = 8;

/// The bytes of memory that `lfz` can write, whose code of a build for tests takes as much again and varies.
const MEMORY_BYTES: usize = 32 << 20;

/// The number of turns in a recording that does not fit into that memory, even in the form of the file.
const TURNS: usize = MEMORY_BYTES / RECORD_BYTES / TURN;

/// Returns the records of one turn of a federate, whose clock is corrected in each.
fn turn(number: i64) -> [Event; TURN] {
    let time = Instant::from_nanos(number * 1_000);
    let tag = Tag { time, microstep: Microstep(0) };
    let word = |peer| TracedMessage { kind: MessageType::TaggedMessage, peer, to: (1, 0), tag: Some(tag), bytes: 4 };
    [
        Event::Clock(Instant::from_nanos(number * 1_001)),
        Event::WaitBegins(Waits::Grant(tag)),
        Event::WaitEnds,
        Event::TagBegins(tag),
        Event::ReactionBegins(0, Part::Body, 0),
        Event::Sent(word(RTI)),
        Event::ReactionEnds(0, 0),
        Event::TagEnds(tag),
    ]
}

fn record(folder: &Path) {
    let mut file = BufWriter::new(File::create(folder.join("a.lftrace")).expect("it can be made"));
    let header = Header { role: Role::Federate(0), sizes: [1, 0, 1] };
    file.write_all(&header.to_bytes()).expect("there is room");
    for number in 0..i64::try_from(TURNS).expect("it is small") {
        for (part, event) in (0..).zip(turn(number)) {
            let at = Instant::from_nanos(number * 1_000 + part);
            file.write_all(&Record { at, event }.to_bytes()).expect("there is room");
        }
    }
    file.flush().expect("there is room");
    let names = r#"{ "program": "P", "federates": [{ "name": "a", "outputs": 1, "inputs": [],
        "reactions": [{ "name": "a.reaction_1", "at": "P.lf:3" }] }] }"#;
    fs::write(folder.join("trace.json"), names).expect("there is room");
}

/// A recording may be larger than the memory of the computer that converts it.
#[test]
fn a_recording_is_put_together_in_less_memory_than_it_has_bytes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    record(folder.path());
    let script = format!("ulimit -d {} && exec \"$0\" trace . --output /dev/null", MEMORY_BYTES / 1024);
    let mut command = Command::new("sh");
    command.current_dir(folder.path()).args(["-c", &script, env!("CARGO_BIN_EXE_lfz")]);
    let output = command.output().expect("a shell can be started");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}: {errors}", output.status);
    let table = String::from_utf8_lossy(&output.stdout);
    assert!(table.contains("a.reaction_1 (P.lf:3)") && table.contains(&TURNS.to_string()), "{table}");
}
