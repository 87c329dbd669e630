// SPDX-License-Identifier: Apache-2.0
//! Decentralized coordination as a whole: each program in `programs/decentralized` runs as processes of their own, and
//! the output of its federates is the expected trace beside the program. `README.md` says which of LF's own tests each
//! covers.
//!
//! `cargo xtask bless -p lf-federations decentralized::` rewrites the traces. With `LF_TEST_RTI` in
//! the environment the programs run with that RTI, which takes the stock RTI's options; the traces have to be the same.

use lf_federations::{Finished, Lfz};

fn run<'n>(names: &[&'n str]) -> Vec<(&'n str, Finished)> {
    Lfz::run_all("decentralized", names)
}

/// Runs programs whose federates wait long enough: no message is late, however busy the computer is.
fn check(names: &[&'static str]) {
    for (name, finished) in run(names) {
        compare(name, &finished.trace());
    }
}

/// Runs programs that continue without waiting for all messages; the number of late messages, which are reported, is
/// not fixed.
fn check_but_for_lateness(names: &[&'static str]) {
    for (name, finished) in run(names) {
        let trace = finished.trace();
        let lines: Vec<&str> = trace.lines().filter(|line| !line.contains(": warn: ")).collect();
        compare(name, &lines.join("\n"));
    }
}

fn compare(name: &str, trace: &str) {
    insta::with_settings!({
        snapshot_path => "../programs/decentralized",
        prepend_module_to_snapshot => false,
        omit_expression => true,
    }, {
        insta::assert_snapshot!(name, trace);
    });
}

/// `keepalive` does not keep a federate alive for which no participant can create an event: without neighbors, and
/// after all of these have left.
#[test]
fn no_federate_stays_for_events_that_cannot_come() {
    check(&["KeptForNobody"]);
}

/// A federate that waits without end for each of its inputs needs neither clocks nor bounds.
#[test]
fn a_federate_that_waits_forever_misses_nothing() {
    check(&["FourSources", "BesideTimer", "TardyInside", "StepLater", "QuickClock", "LateButInTime", "Bursts"]);
    check(&["TwoHandlers", "Kinds"]);
}

/// Delays are longer than any latency, or messages are the only events.
#[test]
fn tags_alone_can_be_enough() {
    check(&["CountAfter", "QuietEnd"]);
}

/// The stop tag is the same for all, and messages sent at it are handled there.
#[test]
fn all_federates_stop_at_one_tag_and_miss_nothing_of_it() {
    check(&["StopTwice"]);
}

/// A wait within a tag without a limit lets a cycle run at the speed of its federates.
#[test]
fn cycles_go_on_when_all_has_come() {
    check(&["Lagging"]);
    check_but_for_lateness(&["Microsteps", "Rounds", "PingPong", "PingPongDecoupled"]);
}

/// Waits can be too short: late messages are handled, and nothing is lost.
#[test]
fn messages_that_are_late_are_handled() {
    check_but_for_lateness(&["LateByDelay", "LoopersFromThreads", "LoopersInOrder", "LoopersInside"]);
    check_but_for_lateness(&["OlderParameter", "Letters", "PhysicalBursts"]);
    let [(_, finished)] = &run(&["BothWays"])[..] else { panic!("it has run") };
    // The number of messages before the end depends on their lateness.
    assert_eq!(finished.trace().lines().filter(|line| line.contains("ends after")).count(), 2, "{finished}");
}

/// Without a handler, the federate logs which message was late, and when; with one, the handler decides.
#[test]
fn a_late_message_is_reported_and_what_comes_of_it_is_tardy_too() {
    let [(_, finished)] = &run(&["TardyPassedOn"])[..] else { panic!("it has run") };
    finished.line(&["sink", "stale Some(42)"]);
    finished.line(&["sink", "fresh Some(42)"]);
    finished.line(&["sink", "warn: late message to federate 1 over source.out -> sink.x for (T0 + 0 ns = 0 ms, 0)"]);
    finished.line(&["sink", "warn: 1 late messages"]);
}

#[test]
fn clocks_are_synchronized_without_connections_too() {
    check_but_for_lateness(&["SyncedClocks"]);
}

#[test]
fn physical_connections_take_physical_time() {
    check(&["PhysicalCount"]);
    check_but_for_lateness(&["QuickClockPhysical"]);
}
