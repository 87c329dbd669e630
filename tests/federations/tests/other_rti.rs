// SPDX-License-Identifier: Apache-2.0
//! Our federates with the RTI that `LF_TEST_RTI` names, such as LF's own: more messages than federates send before they
//! need the RTI's confirmation, for each coordination.

use std::path::PathBuf;
use std::process::Command;

use lf_federations::{Lfz, Run, programs};

/// The number of messages of each source.
const MESSAGES: u32 = 101;

/// Runs a program with the other RTI. It may listen on all addresses, so it gets a network of its own.
fn run(name: &str) {
    let rti = std::env::var("LF_TEST_RTI").expect("the test is skipped otherwise");
    let file = programs().join("other_rti").join(format!("{name}.lf"));
    let out: PathBuf = Lfz::path().with_file_name("federations").join(format!("other_rti-{name}"));
    // Downloads have to finish before the network is gone.
    let build = Lfz::command(["build"]).arg(&file).arg("--out").arg(&out).status().expect("lfz can be started");
    assert!(build.success(), "{name} is built");
    let mut command = Command::new("unshare");
    command.args(["--map-root-user", "--net", "sh", "-c", "ip link set lo up && exec \"$@\"", "sh"]);
    command.arg(Lfz::path()).arg("run").arg(&file).arg("--out").arg(&out);
    command.args(["--timeout", "60s", "--rti", &rti]).env("CARGO_NET_OFFLINE", "true");
    let finished = Run::start(command).succeed();
    let received = finished.of("sink").find_map(|line| line.strip_prefix("received ")?.parse::<u32>().ok());
    // The last value on a physical connection may arrive after the end.
    let expected = if name == "Physical" { MESSAGES - 10..=MESSAGES } else { MESSAGES..=MESSAGES };
    assert!(received.is_some_and(|count| expected.contains(&count)), "{finished}");
}

#[test]
#[cfg_attr(not(other_rti), ignore = "LF_TEST_RTI names no other RTI")]
fn centralized_federates_run_with_another_rti() {
    run("Centralized");
}

#[test]
#[cfg_attr(not(other_rti), ignore = "LF_TEST_RTI names no other RTI")]
fn physical_connections_are_made_with_another_rti() {
    run("Physical");
}

#[test]
#[cfg_attr(not(other_rti), ignore = "LF_TEST_RTI names no other RTI")]
fn decentralized_federates_run_with_another_rti() {
    run("Decentralized");
}
