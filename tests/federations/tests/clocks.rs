// SPDX-License-Identifier: Apache-2.0
//! The synchronization of clocks, as the RTI's trace shows it.

use std::process::Command;

use lf_federations::{Lfz, Run, programs};

/// Runs both federates of a program with an RTI that has clock synchronization on; returns the federate and the message
/// of each line of its trace about that.
fn clock_messages(test: &str, program: &str) -> Vec<(String, String)> {
    let executables = Lfz::build(test, &programs().join(program));
    let folder = tempfile::tempdir().expect("there is a folder for such");
    let options = ["-n", "2", "-i", "clocks", "-c", "on", "period", "5000000", "--trace-csv", "messages.csv"];
    let (rti, port) = Lfz::rti_in(folder.path(), &options);
    let start = |executable| {
        let mut command = Command::new(executable);
        command.args(["--rti", &format!("127.0.0.1:{port}"), "--id", "clocks"]);
        Run::start(command)
    };
    let runs: Vec<Run> = executables.values().map(start).collect();
    for run in runs.into_iter().chain([rti]) {
        run.succeed();
    }
    let trace = std::fs::read_to_string(folder.path().join("messages.csv")).expect("the RTI has written it");
    let columns = trace.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let named = columns.filter(|columns| ["T1", "T3", "T4", "CODED_PROBE"].contains(&columns[3]));
    named.map(|columns| (columns[2].to_owned(), columns[3].to_owned())).collect()
}

#[test]
fn programs_on_the_computer_of_the_rti_have_its_clock() {
    assert_eq!(clock_messages("clocks-default", "centralized/Greeting.lf"), []);
}

#[test]
fn programs_on_the_computer_of_the_rti_take_part_if_they_are_told_to() {
    let messages = clock_messages("clocks-local", "decentralized/SyncedClocks.lf");
    for federate in ["0", "1"] {
        let of = |name: &str| messages.iter().filter(|(one, other)| one == federate && other == name).count();
        // Ten exchanges before the start, then rounds, which end with the probe.
        assert!(of("T1") > 10, "{messages:?}");
        assert!(of("T3") > 10, "{messages:?}");
        assert!(of("T4") > 10, "{messages:?}");
        assert!(of("CODED_PROBE") > 0, "{messages:?}");
    }
}
