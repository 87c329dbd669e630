// SPDX-License-Identifier: Apache-2.0
//! The table of faults in the guide is true: this test causes those that can occur on this computer, and names the
//! tests on boards of the others.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use lf_federations::{Lfz, Run, programs, table};
use rustix::process::Signal;

/// The evidence that a row is true.
enum Proof {
    /// A federate fails in this way, which the program reads in the environment, and prints such a text.
    Does(&'static str, &'static str),
    /// The RTI of a federate is killed.
    LosesItsRti,
    /// A file of the repository that expects the words of the row: suites that run on boards.
    Suite(&'static str),
    /// No suite causes it; the words are at least those of this source.
    Source(&'static str),
}

impl Proof {
    fn of(row: &str) -> Self {
        match row {
            "the program's own error" => Self::Does("a full queue", "error:"),
            "a panic" => Self::Does("a panic", "panicked at"),
            "no socket, thread or room in a queue is left" => Self::Does("a full queue", "@capacity"),
            "the RTI has ended or was started again" => Self::LosesItsRti,
            "stack overflow" | "another error of the kernel, such as an assertion" => {
                Self::Suite("tests/zephyr/faults/testcase.yaml")
            }
            row if row.starts_with("a reaction that takes longer than") => {
                Self::Suite("tests/zephyr/faults/testcase.yaml")
            }
            "another fault of the processor" => Self::Source("zephyr/src/fatal.c"),
            "no network at the start" => Self::Source("src/network.c"),
            _ => panic!("no row is without a test: {row}"),
        }
    }
}

/// Returns the quoted text in a cell, without placeholders.
fn quoted(cell: &str) -> &str {
    let quoted = cell.split('`').nth(1).unwrap_or_default();
    quoted.trim_start_matches("lf: ").split(" …").next().unwrap_or_default().trim_end_matches(';')
}

/// Returns the end of the source after this failure, and its output.
fn happens(federates: &BTreeMap<String, PathBuf>, does: &str, loses_rti: bool) -> (i32, String) {
    let (rti, port) = Lfz::rti(&["-n", "2", "-i", "faults"]);
    let start = |name: &str| {
        let mut command = Command::new(&federates[name]);
        command.args(["--rti", &format!("127.0.0.1:{port}"), "--id", "faults"]).env("ENDS", does);
        Run::start(command)
    };
    let [mut source, sink] = ["source", "sink"].map(start);
    source.wait_for("the source runs");
    if loses_rti {
        rti.signal(Signal::KILL);
    }
    let [source, sink, rti] = [source, sink, rti].map(Run::finish);
    // The federation ends for all.
    assert!(sink.code() == 1 && rti.code() != 0, "{sink}\n{rti}");
    (source.code(), source.to_string())
}

#[test]
fn faults_do_what_the_guide_says() {
    let federates = Lfz::build("faults", &programs().join("Ends.lf"));
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for row in table("faults.md", "what") {
        let [what, happening, status] = &row[..] else { panic!("a row has three cells: {row:?}") };
        let status: i32 = status.parse().expect("the last cell is a status");
        match Proof::of(what) {
            Proof::Does(does, says) => {
                let (code, output) = happens(&federates, does, false);
                assert!(code == status && output.contains(says), "{what}: {output}");
            }
            Proof::LosesItsRti => {
                let (code, output) = happens(&federates, "", true);
                assert!(code == status && output.contains(quoted(happening)), "{what}: {output}");
            }
            Proof::Suite(file) | Proof::Source(file) => {
                let text = std::fs::read_to_string(repository.join(file)).expect("it is there");
                // Formats have a number or another text in some places.
                let words = quoted(happening).rsplit(": ").next().unwrap_or_default();
                let words = words.split("; ").next().unwrap_or_default();
                assert!(!words.is_empty() && text.contains(words), "{file} does not have `{words}`");
            }
        }
    }
}
