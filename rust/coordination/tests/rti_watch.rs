// SPDX-License-Identifier: Apache-2.0
//! The RTI logs which federates others wait for: before the start after a while, and later if the configuration asks
//! for it.

mod rti_support;

use lf_coordination::Deadline;
use lf_coordination::rti::{Config, ConnectionId, START_REPORT};
use lf_model::time::Interval;
use lf_wire::{DELAY_NONE, Message};
use rti_support::dialogue::{FEDERATION, at, config, hello, message, read, started, wait};
use rti_support::{Sizes, World};

/// Lets the time pass until the RTI wants to be called, and returns its log events.
fn next_report(world: &mut World) -> (Interval, Vec<String>) {
    let before = world.now;
    let Deadline::At(due) = world.rti.poll_timeout() else { panic!("nothing is due") };
    world.outlet.notices.clear();
    wait(world, due.since(before));
    (due.since(before), std::mem::take(&mut world.outlet.notices))
}

#[test]
fn the_start_says_who_is_missing_and_how_far_the_others_are() {
    let reporting = Config { start_report: Some(START_REPORT), start_barrier_time_out: None, ..config() };
    let mut world = World::new(reporting, Sizes { connections: 20, ..Sizes::ample(12) });
    wait(&mut world, Interval::ZERO);
    let ready = hello(&mut world, 0, &[]);
    world.message(ready, &Message::Timestamp(0));
    let joined = hello(&mut world, 1, &[]);
    let joining = world.connect();
    world.message(joining, &Message::FedIds { federate: 2, federation_id: FEDERATION });
    let _stranger = world.connect();

    let (after, said) = next_report(&mut world);
    assert_eq!(after, START_REPORT);
    assert_eq!(said[0], "the start waits for 11 of 12 federates; 1 connections have not said which federates they are");
    assert!(said[1].starts_with("federate 1 has joined, but is not ready: it says so (TIMESTAMP) when"), "{said:?}");
    assert_eq!(said[2], "federate 2 has connected; NEIGHBOR_STRUCTURE of it is to come");
    assert_eq!(said[3].split(':').next(), Some("federate 3 has not connected"));
    assert!(said[8].starts_with("federate 8 has not connected: start it or"), "{said:?}");
    assert_eq!((said[9].as_str(), said.len()), ("and 3 more", 10));

    // The pauses become longer, and what has changed meanwhile is said.
    for connection in [joined, joining] {
        world.message(connection, &Message::Resign);
    }
    let pauses: Vec<_> = (0..5)
        .map(|_| {
            let mut passed = Interval::ZERO;
            loop {
                let (pause, said) = next_report(&mut world);
                passed = passed.saturating_add(pause);
                if said.first().is_some_and(|said| said.starts_with("the start waits")) {
                    return passed.as_nanos() / 1_000_000_000;
                }
            }
        })
        .collect();
    assert_eq!(pauses, [10, 20, 40, 60, 60]);
}

/// Two federates, the second downstream of the first, whose waits are logged after a second.
fn chain() -> (World, [ConnectionId; 2]) {
    let watching = Config { log_waits: Some(Interval::from_secs(1)), ..config() };
    let (mut world, connections) = started(watching, Sizes::ample(2), &[vec![], vec![(0, DELAY_NONE)]]);
    wait(&mut world, Interval::from_secs(1));
    (world, [connections[0], connections[1]])
}

/// All that is said until so much time has passed.
fn said_within(world: &mut World, seconds: i64) -> Vec<String> {
    let end = world.now + Interval::from_secs(seconds);
    let mut all = Vec::new();
    while let Deadline::At(due) = world.rti.poll_timeout()
        && due <= end
    {
        all.extend(next_report(world).1);
    }
    all
}

#[test]
fn a_federate_that_waits_for_a_grant_is_told_with_the_one_that_holds_it_up() {
    let (mut world, [up, down]) = chain();
    world.message(up, &Message::NextEventTag(at(5_000_000)));
    world.message(down, &Message::NextEventTag(at(7_000_000)));
    let words = |said: &[String]| said.first().cloned().unwrap_or_default();
    let said = said_within(&mut world, 10);
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
    world.message(up, &Message::NextEventTag(at(8_000_000)));
    world.message(down, &Message::NextEventTag(at(9_000_000)));
    assert_eq!(said_within(&mut world, 10).len(), 1);
}

#[test]
fn who_waits_for_its_time_only_is_not_told() {
    let (mut world, [up, down]) = chain();
    for connection in [up, down] {
        world.message(connection, &Message::NextEventTag(at(60_000_000_000)));
    }
    assert_eq!(said_within(&mut world, 50), Vec::<String>::new());
    assert_eq!(said_within(&mut world, 20).len(), 1);
}

#[test]
fn a_stop_says_whose_answer_is_missing() {
    let (mut world, [up, _]) = chain();
    world.message(up, &Message::StopRequest(at(1)));
    let said = said_within(&mut world, 5);
    assert_eq!(said, ["the stop waits for federate 1, which has not answered the request"]);
}

/// Without the option nothing is logged, and no time is awaited for it.
#[test]
fn nothing_is_told_without_being_asked_for() {
    let (mut world, connections) = started(config(), Sizes::ample(2), &[vec![], vec![(0, DELAY_NONE)]]);
    world.message(connections[1], &Message::NextEventTag(at(1)));
    world.message(connections[0], &message(1, 5, &[1]));
    assert_eq!(world.rti.poll_timeout(), Deadline::Never);
    assert!(!read(&mut world, connections[1]).is_empty());
}
