// SPDX-License-Identifier: Apache-2.0
//! Federations over IPv6, and over both families at once, on this computer.

use std::process::Command;

use lf_federations::{Finished, Lfz, Run, programs};

/// Runs both federates of a program, each with the RTI at its address; returns their ends and the RTI's trace.
/// Synchronizes clocks if the program demands it.
fn run(test: &str, program: &str, hosts: [&str; 2]) -> (Vec<Finished>, String) {
    let executables = Lfz::build(test, &programs().join(program));
    let folder = tempfile::tempdir().expect("there is a folder for such");
    let options = ["-n", "2", "-i", "six", "-c", "on", "period", "5000000", "--trace-csv", "messages.csv"];
    let (rti, port) = Lfz::rti_in(folder.path(), &options);
    let start = |(executable, host)| {
        let mut command = Command::new(executable);
        command.args(["--rti", &format!("{host}:{port}"), "--id", "six"]);
        Run::start(command)
    };
    let runs: Vec<Run> = executables.values().zip(hosts).map(start).collect();
    let finished = runs.into_iter().chain([rti]).map(Run::succeed).collect();
    (finished, std::fs::read_to_string(folder.path().join("messages.csv")).expect("the RTI has written it"))
}

#[test]
fn a_program_whose_rti_is_at_an_ipv6_address_runs() {
    let finished = Lfz::run("ipv6-at", &programs().join("OverIpv6.lf"), &[]).succeed();
    assert!(finished.of("sink").any(|line| line == "seen 21, heard some"), "{finished}");
}

#[test]
fn centralized_coordination_and_connections_beside_it_work_over_ipv6() {
    let (finished, messages) = run("ipv6-centralized", "OverIpv6.lf", ["[::1]", "[::1]"]);
    assert!(finished.iter().any(|one| one.lines.contains(&"seen 21, heard some".to_owned())), "{messages}");
    assert!(messages.contains("ADDRESS_QUERY_REPLY_IPV6"), "{messages}");
}

#[test]
fn decentralized_coordination_works_over_ipv6() {
    let (_, messages) = run("ipv6-decentralized", "decentralized/CountAfter.lf", ["[::1]", "[::1]"]);
    assert!(messages.contains("ADDRESS_QUERY_REPLY_IPV6"), "{messages}");
}

/// Both take part in rounds over UDP, whichever family they use.
#[test]
fn clocks_are_synchronized_over_both_families() {
    let (_, messages) = run("ipv6-clocks", "decentralized/SyncedClocks.lf", ["[::1]", "127.0.0.1"]);
    for federate in ["0", "1"] {
        let probe = format!("sent,{federate},CODED_PROBE");
        assert!(messages.contains(&probe), "{messages}");
    }
}

/// The RTI accepts both families at one port, and federates that use different ones find each other.
#[test]
fn federates_of_both_families_are_one_federation() {
    for hosts in [["[::1]", "127.0.0.1"], ["127.0.0.1", "[::1]"]] {
        let (_, messages) = run("ipv6-both", "decentralized/CountAfter.lf", hosts);
        assert!(messages.contains(",ADDRESS_QUERY_REPLY,"), "{messages}");
    }
}
