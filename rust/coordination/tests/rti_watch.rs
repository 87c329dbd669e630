// SPDX-License-Identifier: Apache-2.0
//! The RTI logs which federates others wait for: before the start after a while, and later if the configuration asks
//! for it.

use lf_coordination::Deadline;
use lf_coordination::rti::{Config, ConnectionId, START_REPORT};
use lf_model::time::Interval;
use lf_testkit::messages::introduction;
use lf_testkit::rti::dialogue::{FEDERATION, at, config, hello, message, read, started, wait};
use lf_testkit::rti::{Rig, Sizes};
use lf_wire::{DELAY_NONE, Message};

/// Lets the time pass until the RTI wants to be called, and returns its log events.
fn next_report(rig: &mut Rig) -> (Interval, Vec<String>) {
    let before = rig.now;
    let Deadline::At(due) = rig.rti.poll_timeout() else { panic!("nothing is due") };
    rig.outlet.log_events.clear();
    wait(rig, due.since(before));
    (due.since(before), std::mem::take(&mut rig.outlet.log_events))
}

#[test]
fn the_start_says_who_is_missing_and_how_far_the_others_are() {
    let reporting = Config { start_report: Some(START_REPORT), start_barrier_time_out: None, ..config() };
    let mut rig = Rig::new(reporting, Sizes { connections: 20, ..Sizes::ample(12) });
    wait(&mut rig, Interval::ZERO);
    let ready = hello(&mut rig, 0, &[]);
    rig.message(ready, &Message::Timestamp(0));
    let joined = hello(&mut rig, 1, &[]);
    let joining = rig.connect();
    rig.message(joining, &Message::FedIds { federate: 2, federation_id: FEDERATION });
    let _stranger = rig.connect();

    let (after, said) = next_report(&mut rig);
    assert_eq!(after, START_REPORT);
    assert_eq!(said[0], "the start waits for 11 of 12 federates; 1 connections have not said which federates they are");
    assert!(said[1].starts_with("federate 1 has joined, but is not ready: it says so (TIMESTAMP) when"), "{said:?}");
    assert_eq!(said[2], "federate 2 has connected; NEIGHBOR_STRUCTURE of it is to come");
    assert_eq!(said[3].split(':').next(), Some("federate 3 has not connected"));
    assert!(said[8].starts_with("federate 8 has not connected: start it or"), "{said:?}");
    assert_eq!((said[9].as_str(), said.len()), ("and 3 more", 10));

    // The pauses become longer, and what has changed meanwhile is said.
    for connection in [joined, joining] {
        rig.message(connection, &Message::Resign);
    }
    let pauses: Vec<_> = (0..5)
        .map(|_| {
            let mut passed = Interval::ZERO;
            loop {
                let (pause, said) = next_report(&mut rig);
                passed = passed.saturating_add(pause);
                if said.first().is_some_and(|said| said.starts_with("the start waits")) {
                    return passed.as_nanos() / 1_000_000_000;
                }
            }
        })
        .collect();
    assert_eq!(pauses, [10, 20, 40, 60, 60]);
}

#[test]
fn all_are_named_if_there_are_eight() {
    let reporting = Config { start_report: Some(START_REPORT), start_barrier_time_out: None, ..config() };
    let mut rig = Rig::new(reporting, Sizes::ample(9));
    wait(&mut rig, Interval::ZERO);
    let ready = hello(&mut rig, 0, &[]);
    rig.message(ready, &Message::Timestamp(0));
    let joining = rig.connect();
    for message in &introduction(1, FEDERATION, &[], &[])[..2] {
        rig.message(joining, message);
    }
    let (_, said) = next_report(&mut rig);
    assert_eq!(said[0], "the start waits for 8 of 9 federates");
    assert_eq!(said[1], "federate 1 has connected; UDP_PORT of it is to come");
    assert_eq!(said.len(), 9);
    assert!(said[8].starts_with("federate 8 has not connected"), "{said:?}");
}

/// Two federates, the second downstream of the first, whose waits are logged after a second.
fn chain() -> (Rig, [ConnectionId; 2]) {
    let watching = Config { log_waits: Some(Interval::from_secs(1)), ..config() };
    let (mut rig, connections) = started(watching, Sizes::ample(2), &[vec![], vec![(0, DELAY_NONE)]]);
    wait(&mut rig, Interval::from_secs(1));
    (rig, [connections[0], connections[1]])
}

/// Returns all messages until this much time has passed.
fn said_within(rig: &mut Rig, seconds: i64) -> Vec<String> {
    let end = rig.now + Interval::from_secs(seconds);
    let mut all = Vec::new();
    while let Deadline::At(due) = rig.rti.poll_timeout()
        && due <= end
    {
        all.extend(next_report(rig).1);
    }
    all
}

#[test]
fn a_federate_that_waits_for_a_grant_is_told_with_the_one_that_holds_it_up() {
    let (mut rig, [up, down]) = chain();
    rig.message(up, &Message::NextEventTag(at(5_000_000)));
    rig.message(down, &Message::NextEventTag(at(7_000_000)));
    let words = |said: &[String]| said.first().cloned().unwrap_or_default();
    let said = said_within(&mut rig, 10);
    assert!(words(&said).starts_with("federate 1 has been waiting for "), "{said:?}");
    assert!(
        words(&said).ends_with(
            "ms for a grant of (T0 + 7000000 ns = 7 ms, 0), because federate 0 may still send something: it has not \
             got beyond (T0 + 5000000 ns = 5 ms, 0)"
        ),
        "{said:?}"
    );
    assert_eq!(said.len(), 1, "it is told once: {said:?}");
    // Another tag is another wait.
    rig.message(up, &Message::NextEventTag(at(8_000_000)));
    rig.message(down, &Message::NextEventTag(at(9_000_000)));
    assert_eq!(said_within(&mut rig, 10).len(), 1);
}

#[test]
fn the_one_with_the_earliest_event_holds_a_federate_up() {
    let watching = Config { log_waits: Some(Interval::from_secs(1)), ..config() };
    let upstream = [vec![], vec![], vec![(0, DELAY_NONE), (1, DELAY_NONE)]];
    let (mut rig, connections) = started(watching, Sizes::ample(3), &upstream);
    wait(&mut rig, Interval::from_secs(1));
    for (connection, ns) in connections.iter().zip([9, 5, 7]) {
        rig.message(*connection, &Message::NextEventTag(at(ns)));
    }
    let said = said_within(&mut rig, 5);
    assert!(said.len() == 1 && said[0].contains("because federate 1 may still"), "{said:?}");
}

/// It waits for no grant, though its next event is not known either.
#[test]
fn a_silent_source_is_not_said_to_wait() {
    let (mut rig, [_, down]) = chain();
    rig.message(down, &Message::NextEventTag(at(7)));
    let said = said_within(&mut rig, 5);
    assert!(said.len() == 1 && said[0].starts_with("federate 1 has been waiting for 1000 ms"), "{said:?}");
}

/// An abort ends the search, too.
#[test]
fn nobody_looks_for_waits_once_a_stop_is_granted() {
    let (mut rig, [up, down]) = chain();
    assert_ne!(rig.rti.poll_timeout(), Deadline::Never);
    rig.message(up, &Message::StopRequest(at(1)));
    rig.message(down, &Message::StopReply(at(1)));
    assert_eq!(rig.rti.poll_timeout(), Deadline::Never);
    let (mut rig, _) = chain();
    rig.rti.abort(&mut rig.outlet);
    assert_eq!(rig.rti.poll_timeout(), Deadline::Never);
}

#[test]
fn a_federate_that_waits_for_physical_time_only_is_not_logged() {
    let (mut rig, [up, down]) = chain();
    for connection in [up, down] {
        rig.message(connection, &Message::NextEventTag(at(60_000_000_000)));
    }
    assert_eq!(said_within(&mut rig, 50), Vec::<String>::new());
    assert_eq!(said_within(&mut rig, 20).len(), 1);
}

#[test]
fn a_stop_says_whose_answer_is_missing() {
    let (mut rig, [up, _]) = chain();
    rig.message(up, &Message::StopRequest(at(1)));
    let said = said_within(&mut rig, 5);
    assert_eq!(said, ["the stop waits for federate 1, which has not answered the request"]);
}

/// It gets that grant with the stop.
#[test]
fn a_federate_that_waits_for_a_grant_and_a_stop_is_not_told() {
    let (mut rig, [_, down]) = chain();
    rig.message(down, &Message::NextEventTag(at(1)));
    rig.message(down, &Message::StopRequest(at(1)));
    let said = said_within(&mut rig, 5);
    assert_eq!(said, ["the stop waits for federate 0, which has not answered the request"]);
}

/// Without the option nothing is logged, and no time is awaited for it.
#[test]
fn nothing_is_told_without_being_asked_for() {
    let (mut rig, connections) = started(config(), Sizes::ample(2), &[vec![], vec![(0, DELAY_NONE)]]);
    rig.message(connections[1], &Message::NextEventTag(at(1)));
    rig.message(connections[0], &message(1, 5, &[1]));
    assert_eq!(rig.rti.poll_timeout(), Deadline::Never);
    assert!(!read(&mut rig, connections[1]).is_empty());
}
