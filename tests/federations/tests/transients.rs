// SPDX-License-Identifier: Apache-2.0
//! Federates that come and go: processes that are started, stopped, killed and swapped while the others run.

use std::process::Stdio;

use lf_federations::{Lfz, Run, TIME_LIMIT, programs};

/// Starts a program of the folder `transients`.
fn run(name: &str, arguments: &[&str]) -> Run {
    let file = programs().join(format!("transients/{name}.lf"));
    Lfz::run(&format!("transients-{name}"), &file, &[&[TIME_LIMIT], arguments].concat())
}

/// Asks this run to do something; returns its answer.
fn ctl(run: &Run, words: &[&str]) -> String {
    let id = run.id().to_string();
    let output = Lfz::command(["ctl"].into_iter().chain(words.iter().copied()).chain(["--run", &id]))
        .stdin(Stdio::null())
        .output()
        .expect("lfz can be started");
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// Lets the middle federate leave, come back, and be swapped; the sink ends the federation then.
fn comes_and_goes(name: &str) {
    let mut run = run(name, &[]);
    run.wait_for("five of life 1");
    assert!(ctl(&run, &["start", "middle"]).contains("runs already"));
    assert!(ctl(&run, &["stop", "sink"]).contains("sink is not transient"));
    assert!(ctl(&run, &["stop", "nobody"]).contains("there is no federate `nobody`"));
    assert!(ctl(&run, &["stop", "middle"]).contains("asked to leave"));
    run.wait_for("gone");
    while !ctl(&run, &[]).contains("middle: does not run") {}
    assert!(ctl(&run, &["start", "middle"]).contains("is started"));
    run.wait_for("five of life 2");
    assert!(ctl(&run, &["swap", "middle"]).contains("takes its place"));
    let finished = run.succeed();
    finished.line(&["middle", "the RTI tells this federate to leave"]);
    finished.line(&["sink", "five of life 3"]);
    assert!(!finished.of("sink").any(|line| line.contains(" after ")), "a value is missing: {finished}");
}

#[test]
fn a_federate_leaves_returns_and_is_swapped() {
    comes_and_goes("Comes");
}

#[test]
fn a_federate_leaves_returns_and_is_swapped_without_grants() {
    comes_and_goes("ComesAlone");
}

/// A federate that is killed is missed by nobody, and another instance of it can come.
#[test]
fn a_federate_that_is_killed_leaves_the_others_alone() {
    let mut run = run("Comes", &["--without", "middle"]);
    run.wait_for("middle takes part when you start it");
    for life in 1..3 {
        while !ctl(&run, &[]).contains("middle: does not run") {}
        assert!(ctl(&run, &["start", "middle"]).contains("is started"));
        run.wait_for(&format!("five of life {life}"));
        let middle = run.participants().into_iter().find(|one| one.command.contains("middle")).expect("it runs");
        middle.kill();
        run.wait_for("middle was ended by signal 9");
    }
    while !ctl(&run, &[]).contains("middle: does not run") {}
    assert!(ctl(&run, &["start", "middle"]).contains("is started"));
    run.succeed().line(&["sink", "five of life 3"]);
}

/// A value that a federate has sent before it leaves arrives, also after the last tag of its sender.
#[test]
fn what_was_sent_before_leaving_arrives() {
    for name in ["Leaves", "LeavesAlone"] {
        let finished = run(name, &[]).succeed();
        finished.line(&["visitor", "gone"]);
        finished.line(&["sink", "the last value has come"]);
    }
}

/// Swaps the counter, which hands over what it has counted; one that stops and starts again counts anew.
fn hands_over(name: &str) {
    let mut run = run(name, &[]);
    run.wait_for("counted 5");
    assert!(ctl(&run, &["swap", "counter"]).contains("takes its place"));
    run.wait_for("counted 20");
    assert!(ctl(&run, &["stop", "counter"]).contains("asked to leave"));
    while !ctl(&run, &[]).contains("counter: does not run") {}
    assert!(ctl(&run, &["start", "counter"]).contains("is started"));
    let finished = run.succeed();
    let all: Vec<_> = finished.of("counter").collect();
    let what = |word: &str| {
        let after = all.iter().filter_map(move |line| line.split_once(word)).map(|(_, what)| what.to_owned());
        after.collect::<Vec<_>>()
    };
    let (begun, ended) = (what("begins with "), what("ends with "));
    assert_eq!((begun.len(), ended.len()), (3, 3), "{finished}");
    assert_eq!((&begun[1], &begun[2]), (&ended[0], &begun[0]), "{finished}");
}

#[test]
fn a_federate_hands_over_its_state() {
    hands_over("HandsOver");
}

#[test]
fn a_federate_in_c_hands_over_its_state_without_grants() {
    hands_over("HandsOverInC");
}
