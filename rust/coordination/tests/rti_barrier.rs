// SPDX-License-Identifier: Apache-2.0
//! The start waits for a federate that was there and has left, but not forever.

mod rti_support;

use lf_coordination::Deadline;
use lf_coordination::rti::{CLOCK_TIME_OUT, Config, ConnectionId, Outcome, START_BARRIER_TIME_OUT, Status};
use lf_model::time::{Instant, Interval};
use lf_wire::Message;
use rti_support::dialogue::{FEDERATION, config, hello, read, wait};
use rti_support::{Sizes, World};

/// Three federates, of which the first two have come and sent their clocks.
fn waiting(config: Config<'static>) -> (World, [ConnectionId; 2]) {
    let mut world = World::new(config, Sizes::ample(3));
    let connections = [0, 1].map(|id| hello(&mut world, id, &[]));
    for connection in connections {
        world.message(connection, &Message::Timestamp(0));
    }
    assert_eq!(world.rti.poll_timeout(), Deadline::Never);
    (world, connections)
}

/// Checks the result of all ways to leave before the start.
fn assert_given_up(world: &mut World, left: ConnectionId, first: u16, missing: u16) {
    let limit = Deadline::At(world.now + START_BARRIER_TIME_OUT);
    assert_eq!(world.rti.poll_timeout(), limit);
    wait(world, Interval::from_nanos(START_BARRIER_TIME_OUT.as_nanos() - 1));
    assert_eq!(world.rti.status(), Status::Running);
    wait(world, Interval::from_nanos(1));
    assert_eq!(world.rti.status(), Status::Finished(Outcome::NotStarted { first: first.into(), missing }));
    let words = format!("federate {first} is missing: the federation ends without having started");
    assert!(world.outlet.notices.contains(&words), "{:?}", world.outlet.notices);
    assert_eq!(read(world, left), ["FAILED"]);
    assert_eq!(world.rti.poll_timeout(), Deadline::Never);
}

#[test]
fn all_that_are_missing_are_named_when_the_time_is_over() {
    let (mut world, [first, second]) = waiting(config());
    world.close(first);
    assert_given_up(&mut world, second, 0, 2);
    let named = |id| world.outlet.notices.iter().any(|notice| notice.starts_with(&format!("federate {id} is missing")));
    assert_eq!([0, 1, 2].map(named), [true, false, true]);
}

#[test]
fn every_way_to_leave_before_the_start_counts() {
    for how in [Message::Failed, Message::Resign, Message::NextEventTag(lf_wire::Tag::new(0, 0))] {
        let (mut world, [first, second]) = waiting(config());
        world.message(second, &how);
        if how == Message::Resign {
            world.close(second);
        }
        assert_given_up(&mut world, first, 1, 2);
    }
}

#[test]
fn a_connection_that_ends_in_the_handshake_counts_once_it_has_said_who_it_is() {
    let (mut world, [first, _]) = waiting(config());
    let silent = world.connect();
    world.close(silent);
    assert_eq!(world.rti.poll_timeout(), Deadline::Never);
    let third = world.connect();
    world.message(third, &Message::FedIds { federate: 2, federation_id: FEDERATION });
    world.close(third);
    assert_given_up(&mut world, first, 2, 1);
}

#[test]
fn whoever_comes_back_lifts_the_limit() {
    let (mut world, [first, second]) = waiting(config());
    world.close(first);
    wait(&mut world, Interval::from_secs(30));
    // A later loss does not prolong the time.
    world.close(second);
    let since_first = Deadline::At(Instant::from_nanos(1_000) + START_BARRIER_TIME_OUT);
    assert_eq!(world.rti.poll_timeout(), since_first);
    let first = hello(&mut world, 0, &[]);
    assert_eq!(world.rti.poll_timeout(), since_first);
    let second = hello(&mut world, 1, &[]);
    // There is no limit any more but that for telling their clocks.
    assert_eq!(world.rti.poll_timeout(), Deadline::At(world.now + CLOCK_TIME_OUT));
    for connection in [first, second] {
        world.message(connection, &Message::Timestamp(0));
    }
    assert_eq!(world.rti.poll_timeout(), Deadline::Never);
    let third = hello(&mut world, 2, &[]);
    world.message(third, &Message::Timestamp(0));
    assert_eq!(read(&mut world, third), ["TIMESTAMP"]);
}

#[test]
fn without_a_limit_the_others_wait() {
    let (mut world, [first, _]) = waiting(Config { start_barrier_time_out: None, ..config() });
    world.close(first);
    assert_eq!(world.rti.poll_timeout(), Deadline::Never);
    assert_eq!(world.rti.status(), Status::Running);
}
