// SPDX-License-Identifier: Apache-2.0
//! A failure ends all participants, with a sentence about the reason, and leaves no process behind.

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::Command;

use lf_federations::{Finished, Lfz, Participant, Run, programs, wait_for_ends};
use rustix::process::Signal;

fn endless() -> PathBuf {
    programs().join("Endless.lf")
}

/// Starts the endless program, and returns the run and its participants once its federates have begun: the RTI and the
/// two federates.
fn running(test: &str, arguments: &[&str]) -> (Run, Vec<Participant>) {
    let mut run = Lfz::run(test, &endless(), arguments);
    run.wait_for("the source runs");
    run.wait_for("the sink runs");
    let participants = run.participants();
    assert_eq!(participants.len(), 3);
    (run, participants)
}

fn find<'a>(participants: &'a [Participant], text: &str) -> &'a Participant {
    participants.iter().find(|participant| participant.command.contains(text)).expect("it takes part")
}

/// Asserts that both federates, by their names in the output, print one of these texts.
fn assert_both_say(finished: &Finished, texts: &[&str]) {
    for name in ["source", "sink"] {
        let mut lines = finished.of(name);
        assert!(lines.any(|line| texts.iter().all(|text| line.contains(text))), "{name}, {texts:?}: {finished}");
    }
}

#[test]
fn a_lost_rti_ends_the_federates() {
    let (run, participants) = running("lost_rti", &[]);
    find(&participants, " rti ").kill();
    let finished = run.finish();
    assert_eq!(finished.code(), 137, "{finished}");
    finished.line(&["lfz", "RTI was ended by signal 9 (SIGKILL)"]);
    assert_both_say(&finished, &["error:", "RTI"]);
    wait_for_ends(&participants);
}

#[test]
fn a_killed_federate_ends_the_rti_and_the_others() {
    let (run, participants) = running("killed_federate", &[]);
    find(&participants, "endless-source").kill();
    let finished = run.finish();
    assert_eq!(finished.code(), 137, "{finished}");
    finished.line(&["lfz", "source was ended by signal 9 (SIGKILL)"]);
    finished.line(&["RTI", "federate 0 is lost: its connection ended without a word"]);
    assert!(finished.of("sink").any(|line| line.contains("error:")), "{finished}");
    wait_for_ends(&participants);
}

/// Writes a program of these tests with another target declaration.
fn with_target(folder: &Path, program: &str, properties: &str) -> PathBuf {
    let text = std::fs::read_to_string(programs().join(program)).expect("the program is there");
    let file = folder.join(program);
    std::fs::write(&file, text.replacen("target Rust", &format!("target Rust {{ {properties} }}"), 1))
        .expect("it can be written");
    file
}

/// Each federate waits for the other's answer at each tag, so the remaining one waits for an answer that never comes.
#[test]
fn a_killed_federate_of_a_cycle_without_delay_ends_all() {
    for killed in ["asks", "answers"] {
        let mut run = Lfz::run("killed_in_cycle", &programs().join("EndlessCycle.lf"), &[]);
        run.wait_for("the first answer has come");
        let participants = run.participants();
        find(&participants, &format!("-{killed} ")).kill();
        let finished = run.finish();
        assert_eq!(finished.code(), 137, "{finished}");
        finished.line(&["lfz", &format!("{killed} was ended by signal 9 (SIGKILL)")]);
        finished.line(&["RTI", "is lost: its connection ended without a word"]);
        wait_for_ends(&participants);
    }
}

/// No RTI grants anything, but it knows of the loss; and without an RTI no federate learns when the others have gone. A
/// sink whose source is lost never mistakes that for an orderly end.
#[test]
fn a_killed_participant_of_a_decentralized_federation_ends_all() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = with_target(folder.path(), "Endless.lf", "coordination: decentralized");
    for (killed, lost) in [("endless-source", "source"), ("endless-sink", "sink"), (" rti ", "RTI")] {
        let mut run = Lfz::run("killed_decentralized", &file, &[]);
        run.wait_for("the sink runs");
        let participants = run.participants();
        find(&participants, killed).kill();
        let finished = run.finish();
        assert_eq!(finished.code(), 137, "{finished}");
        finished.line(&["lfz", &format!("{lost} was ended by signal 9 (SIGKILL)")]);
        for other in ["source", "sink"].iter().filter(|name| **name != lost) {
            assert!(finished.of(other).any(|line| line.contains("error:")), "{finished}");
        }
        wait_for_ends(&participants);
    }
}

/// `keepalive` and an RTI that continues do not keep a federate alive if the only one that could create an event for it
/// is lost.
#[test]
fn no_federate_stays_for_a_lost_one_that_alone_could_make_an_event() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for coordination in ["centralized", "decentralized"] {
        let properties = format!("keepalive: true, coordination: {coordination}");
        let file = with_target(folder.path(), "KeptAfterLoss.lf", &properties);
        let programs = Lfz::build(&format!("kept_after_loss_{coordination}"), &file);
        let (rti, port) = Lfz::rti(&["-n", "2", "-i", "kept", "--go-on-after-loss"]);
        let start = |name: &str| {
            let mut command = Command::new(&programs[name]);
            command.args(["--rti", &format!("127.0.0.1:{port}"), "--id", "kept"]);
            Run::start(command)
        };
        let [source, sink] = ["source", "sink"].map(start);
        let (source, sink, rti) = (source.finish(), sink.finish(), rti.finish());
        assert_eq!(source.code(), 7, "{coordination}: {source}");
        assert_eq!(sink.code(), 0, "{coordination}: {sink}\n{rti}");
        sink.line(&["the sink has had 4 values"]);
        assert_eq!(rti.code(), 1, "{coordination}: {rti}");
        rti.line(&["error:", "federate 0 is lost"]);
    }
}

/// The others wait for a federate that is stopped for a while, name it, and lose nothing.
#[test]
fn a_federate_that_stands_still_is_named_and_waited_for() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (coordination, names) in [
        ("centralized", ["RTI", "federate 1 has been waiting for ", "federate 0"]),
        ("decentralized", ["sink", "waiting for ", "source.y -> sink.x"]),
    ] {
        let properties =
            format!("coordination: {coordination}, timeout: 3 sec, coordination-options: {{ log-waits: 300 msec }}");
        let file = with_target(folder.path(), "Endless.lf", &properties);
        let mut run = Lfz::run("stands_still", &file, &[]);
        run.wait_for("the sink runs");
        let participants = run.participants();
        let source = find(&participants, "endless-source");
        source.signal(Signal::STOP);
        run.wait_for(names[1]);
        source.signal(Signal::CONT);
        let finished = run.succeed();
        finished.line(&names);
        finished.line(&["the sink has had 300 values"]);
        wait_for_ends(&participants);
    }
}

#[test]
fn a_wrong_federation_id_is_refused() {
    let run = Lfz::run("wrong_id", &endless(), &["--", "--id", "another federation"]);
    let finished = run.finish();
    assert_eq!(finished.code(), 1, "{finished}");
    finished.line(&["RTI", "refused", "another federation"]);
    assert_both_say(&finished, &["error:", "federation"]);
}

#[test]
fn a_port_in_use_is_named() {
    let taken = TcpListener::bind(("0.0.0.0", 0)).expect("there is a free port");
    let port = taken.local_addr().expect("it is bound").port();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("Endless.lf");
    let text = std::fs::read_to_string(endless()).expect("the program is there");
    let text = text.replace("federated reactor Endless", &format!("federated reactor Endless at localhost:{port}"));
    std::fs::write(&file, text).expect("it can be written");
    let finished = Lfz::run("port_in_use", &file, &[]).finish();
    assert_eq!(finished.code(), 1, "{finished}");
    finished.line(&["RTI", &port.to_string(), "in use"]);
    assert_eq!(finished.of("source").count(), 0, "no federate is started without an RTI: {finished}");
}

#[test]
fn a_second_federate_with_the_same_id_is_refused() {
    let programs = Lfz::build("same_id", &endless());
    let (mut rti, port) = Lfz::rti(&["-n", "2", "-i", "same id"]);
    let source = || {
        let mut command = Command::new(&programs["source"]);
        command.args(["--rti", &format!("127.0.0.1:{port}"), "--id", "same id"]);
        Run::start(command)
    };
    let first = source();
    rti.wait_for("federate 0 has joined");
    let second = source().finish();
    assert_ne!(second.code(), 0);
    second.line(&["error:", "id"]);
    rti.wait_for("refused");
    // The first one is not disturbed; it ends when the RTI does.
    rti.signal(Signal::TERM);
    let (rti, first) = (rti.finish(), first.finish());
    assert_eq!(rti.code(), 143, "{rti}");
    assert_ne!(first.code(), 0, "{first}");
    first.line(&["error:", "RTI"]);
}

#[test]
fn the_exit_status_is_that_of_the_signal() {
    let programs = Lfz::build("signals", &endless());
    for (signal, status) in [(Signal::INT, 130), (Signal::TERM, 143)] {
        let (mut rti, port) = Lfz::rti(&["-n", "2", "-i", "signals"]);
        let mut command = Command::new(&programs["source"]);
        command.args(["--rti", &format!("127.0.0.1:{port}"), "--id", "signals"]);
        let source = Run::start(command);
        rti.wait_for("federate 0 has joined");
        source.signal(signal);
        let source = source.finish();
        assert_eq!(source.code(), status, "{source}");
        rti.wait_for("federate 0 is lost before the start");
        rti.signal(signal);
        let rti = rti.finish();
        assert_eq!(rti.code(), status, "{rti}");
    }
}

#[test]
fn an_interrupt_ends_everything() {
    let (run, participants) = running("interrupt", &[]);
    run.signal(Signal::INT);
    let finished = run.finish();
    assert_eq!(finished.code(), 130, "{finished}");
    wait_for_ends(&participants);
}

#[test]
fn nothing_survives_a_killed_lfz() {
    let (run, participants) = running("killed_lfz", &[]);
    run.signal(Signal::KILL);
    assert_eq!(run.finish().code(), 137);
    wait_for_ends(&participants);
}

#[test]
fn the_time_limit_ends_everything_with_its_own_status() {
    let finished = Lfz::run("time_limit", &endless(), &["--timeout", "100 ms"]).finish();
    assert_eq!(finished.code(), 124, "{finished}");
    finished.line(&["lfz", "the time limit is reached"]);
}

#[test]
fn errors_of_rustc_are_reported_in_the_lf_file() {
    let file = programs().join("WrongBody.lf");
    let finished = Lfz::run("wrong_body", &file, &[]).finish();
    assert_eq!(finished.code(), 1, "{finished}");
    finished.line(&["WrongBody.lf:9:49: error[E0308]: mismatched types"]);
    finished.line(&["WrongBody.lf:14:29: error[E0609]: no field `unknown`"]);
    let text = finished.to_string();
    assert!(text.contains("let number: u32 = text;"), "the line is shown: {text}");
    assert_eq!(text.matches("E0308").count(), 1, "each error is reported once, though two federates have it: {text}");
}

#[test]
fn a_type_that_cannot_be_sent_is_one_error_at_its_port_or_field() {
    let finished = Lfz::run("unsendable", &programs().join("Unsendable.lf"), &[]).finish();
    assert_eq!(finished.code(), 1, "{finished}");
    finished.line(&["Unsendable.lf:11:21: error[E0277]: a value of type `NonZero<u8>` cannot stand in a struct"]);
    finished.line(&["Unsendable.lf:16:20: error[E0277]: a value of type `NonZero<u8>` cannot be sent"]);
    let text = finished.to_string();
    assert_eq!(text.matches("error[").count(), 2, "{text}");
}

#[test]
fn a_type_that_a_connection_cannot_copy_is_one_error_at_its_port() {
    let finished = Lfz::run("uncopyable", &programs().join("Uncopyable.lf"), &[]).finish();
    assert_eq!(finished.code(), 1, "{finished}");
    finished
        .line(&["Uncopyable.lf:6:18: error[E0277]: the trait bound `std::sync::Mutex<u32>: Clone` is not satisfied"]);
    assert_eq!(finished.to_string().matches("error[").count(), 1, "{finished}");
}

#[test]
fn a_federate_that_fails_by_itself_decides_the_exit_status() {
    let finished = Lfz::run("bad_argument", &endless(), &["--", "--no-such-option"]).finish();
    assert_eq!(finished.code(), 2, "{finished}");
    assert_both_say(&finished, &["--no-such-option"]);
    finished.line(&["lfz", "ended with exit status 2"]);
}
