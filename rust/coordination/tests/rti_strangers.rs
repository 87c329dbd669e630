// SPDX-License-Identifier: Apache-2.0
//! A silent peer keeps no other from joining, and no federation from starting or ending.

use lf_coordination::Deadline;
use lf_coordination::rti::{CLOCK_TIME_OUT, Outcome, START_BARRIER_TIME_OUT, Status};
use lf_model::time::Interval;
use lf_testkit::rti::dialogue::{FEDERATION, config, hello, read, started, wait};
use lf_testkit::rti::{Rig, Sizes};
use lf_wire::Message;

const CROWDED: &str = "a connection that had not said which federate it is was closed, because another one has come \
                       and all places are taken";

/// The oldest connection without an id goes first, and none with an id.
#[test]
fn the_oldest_stranger_makes_way() {
    let mut rig = Rig::new(config(), Sizes { connections: 4, ..Sizes::ample(2) });
    let joining = rig.connect();
    rig.message(joining, &Message::FedIds { federate: 0, federation_id: FEDERATION });
    let joined = hello(&mut rig, 1, &[]);
    let older = rig.connect();
    wait(&mut rig, Interval::from_millis(1));
    let newer = rig.connect();
    // Its bytes are no message yet.
    rig.send(older, &[1, 0]);
    for stranger in [older, newer] {
        assert!(rig.rti.can_evict());
        assert_eq!(rig.rti.evict(&mut rig.outlet), Some(stranger));
        assert!(rig.outlet.log_events.pop().is_some_and(|event| event.starts_with(CROWDED)));
    }
    assert!(!rig.rti.can_evict());
    assert_eq!(rig.rti.evict(&mut rig.outlet), None);
    for federate in [joining, joined] {
        assert!(rig.outlet.list[federate.0].open);
    }
}

/// A federate that joins and is then silent holds the start up for a limited time; then it is logged, and has as much
/// time to come back as any that has left.
#[test]
fn a_federate_that_does_not_tell_its_clock_loses_its_place() {
    let mut rig = Rig::new(config(), Sizes::ample(2));
    let squatter = hello(&mut rig, 0, &[]);
    let federate = hello(&mut rig, 1, &[]);
    rig.message(federate, &Message::Timestamp(0));
    wait(&mut rig, Interval::from_nanos(CLOCK_TIME_OUT.as_nanos() - 1));
    // It is looking for another federate.
    rig.message(squatter, &Message::AddressQuery { federate: 1, is_transient: None });
    assert_eq!(read(&mut rig, squatter), ["ADDRESS_QUERY_REPLY"]);
    assert_eq!(rig.rti.poll_timeout(), Deadline::At(rig.now + CLOCK_TIME_OUT));
    wait(&mut rig, CLOCK_TIME_OUT);
    assert_eq!(read(&mut rig, squatter), ["FAILED"]);
    assert!(rig.outlet.log_events.contains(
        &"federate 0 is lost before the start, its place is free again: it has joined, but was silent for too long \
          before it was ready to start"
            .to_owned()
    ));
    assert_eq!(rig.rti.poll_timeout(), Deadline::At(rig.now + START_BARRIER_TIME_OUT));
    wait(&mut rig, START_BARRIER_TIME_OUT);
    assert_eq!(rig.rti.status(), Status::Finished(Outcome::NotStarted { first: 0.into(), missing: 1 }));
}

/// Once it has sent its clock, a federate may be silent for as long as it likes, also the last one, with which all
/// start.
#[test]
fn a_federate_that_has_sent_its_clock_may_be_silent() {
    let mut rig = Rig::new(config(), Sizes::ample(2));
    for id in 0..2 {
        let federate = hello(&mut rig, id, &[]);
        assert_eq!(rig.rti.poll_timeout(), Deadline::At(rig.now + CLOCK_TIME_OUT));
        rig.message(federate, &Message::Timestamp(0));
        assert_eq!(rig.rti.poll_timeout(), Deadline::Never);
    }
    assert!(rig.rti.start_time().is_some());
}

/// The rejection does not claim that the federate is still there, and no peer waits for a slot that will not be free.
#[test]
fn no_federate_comes_back_to_a_running_federation_and_the_log_says_why() {
    let (mut rig, federates) = started(config(), Sizes::ample(2), &[vec![], vec![]]);
    let ids = Message::FedIds { federate: 0, federation_id: FEDERATION };
    for (has_left, end) in [
        (false, "(code 2)"),
        (true, "that federate has left, and a federation that runs takes nobody back: start all of it again"),
    ] {
        if has_left {
            rig.message(federates[0], &Message::Resign);
        }
        let again = rig.connect();
        rig.message(again, &ids);
        assert_eq!(read(&mut rig, again), ["REJECT"]);
        assert!(rig.outlet.log_events.last().is_some_and(|event| event.contains(end)), "{:?}", rig.outlet.log_events);
    }
}
