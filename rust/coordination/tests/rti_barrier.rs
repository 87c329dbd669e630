// SPDX-License-Identifier: Apache-2.0
//! The start waits for a federate that was there and has left, but not forever.

use lf_coordination::Deadline;
use lf_coordination::rti::{CLOCK_TIME_OUT, Config, ConnectionId, Outcome, START_BARRIER_TIME_OUT, Status};
use lf_model::time::{Instant, Interval};
use lf_testkit::rti::dialogue::{FEDERATION, config, hello, read, wait};
use lf_testkit::rti::{Rig, Sizes};
use lf_wire::Message;

/// Three federates, of which the first two have come and sent their clocks.
fn waiting(config: Config<'static>) -> (Rig, [ConnectionId; 2]) {
    let mut rig = Rig::new(config, Sizes::ample(3));
    let connections = [0, 1].map(|id| hello(&mut rig, id, &[]));
    for connection in connections {
        rig.message(connection, &Message::Timestamp(0));
    }
    assert_eq!(rig.rti.poll_timeout(), Deadline::Never);
    (rig, connections)
}

/// Checks the result of all ways to leave before the start.
fn assert_given_up(rig: &mut Rig, left: ConnectionId, first: u16, missing: u16) {
    let limit = Deadline::At(rig.now + START_BARRIER_TIME_OUT);
    assert_eq!(rig.rti.poll_timeout(), limit);
    wait(rig, Interval::from_nanos(START_BARRIER_TIME_OUT.as_nanos() - 1));
    assert_eq!(rig.rti.status(), Status::Running);
    wait(rig, Interval::from_nanos(1));
    assert_eq!(rig.rti.status(), Status::Finished(Outcome::NotStarted { first: first.into(), missing }));
    let words = format!("federate {first} is missing: the federation ends without having started");
    assert!(rig.outlet.log_events.contains(&words), "{:?}", rig.outlet.log_events);
    assert_eq!(read(rig, left), ["FAILED"]);
    assert_eq!(rig.rti.poll_timeout(), Deadline::Never);
}

#[test]
fn all_that_are_missing_are_named_when_the_time_is_over() {
    let (mut rig, [first, second]) = waiting(config());
    rig.close(first);
    assert_given_up(&mut rig, second, 0, 2);
    let named = |id| rig.outlet.log_events.iter().any(|event| event.starts_with(&format!("federate {id} is missing")));
    assert_eq!([0, 1, 2].map(named), [true, false, true]);
}

#[test]
fn every_way_to_leave_before_the_start_counts() {
    for how in [Message::Failed, Message::Resign, Message::NextEventTag(lf_wire::Tag::new(0, 0))] {
        let (mut rig, [first, second]) = waiting(config());
        rig.message(second, &how);
        if how == Message::Resign {
            rig.close(second);
        }
        assert_given_up(&mut rig, first, 1, 2);
    }
}

#[test]
fn a_connection_that_ends_in_the_handshake_counts_once_it_has_said_who_it_is() {
    let (mut rig, [first, _]) = waiting(config());
    let silent = rig.connect();
    rig.close(silent);
    assert_eq!(rig.rti.poll_timeout(), Deadline::Never);
    let third = rig.connect();
    rig.message(third, &Message::FedIds { federate: 2, federation_id: FEDERATION });
    rig.close(third);
    assert_given_up(&mut rig, first, 2, 1);
}

#[test]
fn a_federate_that_comes_back_lifts_the_limit() {
    let (mut rig, [first, second]) = waiting(config());
    rig.close(first);
    wait(&mut rig, Interval::from_secs(30));
    // A later loss does not prolong the time.
    rig.close(second);
    let since_first = Deadline::At(Instant::from_nanos(1_000) + START_BARRIER_TIME_OUT);
    assert_eq!(rig.rti.poll_timeout(), since_first);
    let first = hello(&mut rig, 0, &[]);
    assert_eq!(rig.rti.poll_timeout(), since_first);
    let second = hello(&mut rig, 1, &[]);
    // There is no limit any more but that for telling their clocks.
    assert_eq!(rig.rti.poll_timeout(), Deadline::At(rig.now + CLOCK_TIME_OUT));
    for connection in [first, second] {
        rig.message(connection, &Message::Timestamp(0));
    }
    assert_eq!(rig.rti.poll_timeout(), Deadline::Never);
    let third = hello(&mut rig, 2, &[]);
    rig.message(third, &Message::Timestamp(0));
    assert_eq!(read(&mut rig, third), ["TIMESTAMP"]);
}

#[test]
fn without_a_limit_the_others_wait() {
    let (mut rig, [first, _]) = waiting(Config { start_barrier_time_out: None, ..config() });
    rig.close(first);
    assert_eq!(rig.rti.poll_timeout(), Deadline::Never);
    assert_eq!(rig.rti.status(), Status::Running);
}
