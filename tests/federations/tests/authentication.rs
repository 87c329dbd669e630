// SPDX-License-Identifier: Apache-2.0
//! Authentication between real processes: the RTI accepts federates that know the federation's id, and tells all others
//! why it does not.

use std::path::{Path, PathBuf};
use std::process::Command;

use lf_federations::{Finished, Lfz, Run, programs};
use rustix::process::Signal;

/// Returns the executable of the source of a program.
fn source(test: &str, program: &str) -> PathBuf {
    Lfz::build(test, &programs().join(program)).remove("source").expect("it has a source")
}

/// Runs a federate with an RTI that is started with these options; returns the ends of both.
fn meet(program: &Path, federation_id: &str, rti_options: &[&str]) -> (Finished, Finished) {
    let (mut rti, port) = Lfz::rti(&[&["-n", "2", "-i", "the right id"], rti_options].concat());
    let mut command = Command::new(program);
    command.args(["--rti", &format!("127.0.0.1:{port}"), "--id", federation_id]);
    let federate = Run::start(command).finish();
    rti.wait_for("refuse");
    rti.signal(Signal::TERM);
    (federate, rti.finish())
}

#[test]
fn a_federation_with_authentication_runs() {
    let finished = Lfz::run("authenticated", &programs().join("Authenticated.lf"), &[]).succeed();
    assert_eq!(finished.of("sink").find(|line| line.contains("sum")), Some("the sum is 21"), "{finished}");
}

#[test]
fn a_federate_with_another_key_refuses_the_rti_and_both_say_so() {
    let (federate, rti) = meet(&source("other_key", "Authenticated.lf"), "a wrong id", &["--auth"]);
    assert_eq!(federate.code(), 1, "{federate}");
    federate.line(&["error:", "could not prove", "same federation id"]);
    rti.line(&["federate 0 refuses this RTI", "HMAC"]);
}

#[test]
fn an_rti_without_authentication_is_told_apart() {
    let (federate, rti) = meet(&source("rti_without", "Authenticated.lf"), "the right id", &[]);
    assert_eq!(federate.code(), 1, "{federate}");
    federate.line(&["error:", "does not use authentication (code 7)", "`-a`"]);
    rti.line(&["refused", "code 7"]);
}

#[test]
fn a_federate_without_authentication_is_told_apart() {
    let (federate, rti) = meet(&source("federate_without", "Endless.lf"), "the right id", &["-a"]);
    assert_eq!(federate.code(), 1, "{federate}");
    federate.line(&["error:", "code 4", "`auth: true`"]);
    rti.line(&["refused", "`auth: true`"]);
}

#[test]
fn a_federate_whose_key_everybody_can_guess_says_so() {
    let program = source("public_key", "Authenticated.lf");
    let warning = ["warn:", "the federation id is the key", "--id"];
    let (mut rti, port) = Lfz::rti(&["-n", "2", "-a", "-i", "Authenticated"]);
    let mut command = Command::new(&program);
    command.args(["--rti", &format!("127.0.0.1:{port}")]);
    let federate = Run::start(command);
    rti.wait_for("federate 0 has joined");
    federate.signal(Signal::INT);
    federate.finish().line(&warning);
    // A federate with a key of its own does not.
    let (federate, _) = meet(&program, "a secret", &["--auth"]);
    assert!(!federate.lines.iter().any(|line| line.contains("warn:")), "{federate}");
}
