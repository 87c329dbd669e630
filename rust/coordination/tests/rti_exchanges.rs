// SPDX-License-Identifier: Apache-2.0
//! The exchanges of clock synchronization before the start: whose turn it is, and when.

use lf_coordination::Deadline;
use lf_coordination::rti::{ClockSync, Config, ConnectionId};
use lf_model::time::Interval;
use lf_testkit::rti::dialogue::{FEDERATION, config, read, wait};
use lf_testkit::rti::{Rig, Sizes};
use lf_wire::{Message, NeighborStructure, UDP_PORT_CLOCK_SYNC_INITIAL, UDP_PORT_CLOCK_SYNC_OFF};

const MS: fn(i64) -> Interval = Interval::from_millis;

fn rig(federates: usize) -> Rig {
    let config = Config { clock_sync: ClockSync::Init { trials: 2 }, ..config() };
    let mut rig = Rig::new(config, Sizes::ample(federates));
    rig.tells_times = false;
    rig
}

/// Connects a federate that waits for its turn, or for the others.
fn come(rig: &mut Rig, id: u16, udp_port: u16) -> ConnectionId {
    let connection = rig.connect();
    rig.message(connection, &Message::FedIds { federate: id, federation_id: FEDERATION });
    rig.message(connection, &Message::NeighborStructure(NeighborStructure::new(&[], &[])));
    rig.message(connection, &Message::UdpPort(udp_port));
    assert_eq!(read(rig, connection), ["ACK"]);
    connection
}

/// Time passes, and what is due then is sent.
fn pass(rig: &mut Rig, interval: Interval) -> Option<ConnectionId> {
    rig.now = rig.now + interval;
    rig.rti.poll_exchange(rig.now, &mut rig.outlet)
}

fn answer(rig: &mut Rig, connection: ConnectionId, federate: u16) {
    rig.message(connection, &Message::T3 { federate });
}

#[test]
fn a_turn_begins_when_no_handshake_has_been_heard_for_a_millisecond() {
    let mut rig = rig(3);
    assert_eq!(rig.rti.poll_exchange_timeout(), Deadline::Never);
    let first = come(&mut rig, 0, UDP_PORT_CLOCK_SYNC_INITIAL);
    assert_eq!(pass(&mut rig, Interval::from_nanos(999_999)), None);
    // A federate comes that takes no part, but may hold others up all the same.
    come(&mut rig, 1, UDP_PORT_CLOCK_SYNC_OFF);
    assert_eq!(pass(&mut rig, Interval::from_nanos(1)), None);
    assert_eq!(rig.rti.poll_exchange_timeout(), Deadline::At(rig.now + Interval::from_nanos(999_999)));
    assert_eq!(pass(&mut rig, MS(1)), Some(first));
    assert_eq!((rig.rti.exchanging(), pass(&mut rig, MS(100))), (Some(first), None));
}

/// Each message of a handshake counts, not only its connection.
#[test]
fn a_handshake_that_takes_its_time_puts_off_a_turn() {
    let mut rig = rig(2);
    come(&mut rig, 0, UDP_PORT_CLOCK_SYNC_INITIAL);
    let slow = rig.connect();
    rig.now = rig.now + Interval::from_nanos(900_000);
    rig.message(slow, &Message::FedIds { federate: 1, federation_id: FEDERATION });
    assert_eq!(rig.rti.poll_exchange_timeout(), Deadline::At(rig.now + MS(1)));
}

#[test]
fn handshakes_without_end_do_not_put_off_a_turn() {
    let mut rig = rig(2);
    let first = come(&mut rig, 0, UDP_PORT_CLOCK_SYNC_INITIAL);
    let begun = (0..100).find_map(|_| {
        let other = come(&mut rig, 1, UDP_PORT_CLOCK_SYNC_INITIAL);
        rig.close(other);
        pass(&mut rig, Interval::from_nanos(900_000))
    });
    assert_eq!(begun, Some(first));
}

#[test]
fn one_has_all_its_exchanges_before_another_begins() {
    let mut rig = rig(2);
    let connections = [0, 1].map(|id| come(&mut rig, id, UDP_PORT_CLOCK_SYNC_INITIAL));
    for (connection, id) in connections.into_iter().zip(0..) {
        assert_eq!(pass(&mut rig, MS(1)), Some(connection));
        assert_eq!(read(&mut rig, connection), ["T1"]);
        answer(&mut rig, connection, id);
        assert_eq!(read(&mut rig, connection), ["T4"]);
        // T1 has the time at which it is sent, not that of the answer before it.
        let later = rig.now + Interval::from_nanos(70_000);
        assert_eq!(pass(&mut rig, Interval::from_nanos(70_000)), Some(connection));
        let told = rig.take(connection, usize::MAX);
        assert_eq!(told[1..], later.as_nanos().to_le_bytes());
        answer(&mut rig, connection, id);
        assert_eq!(read(&mut rig, connection), ["T4"]);
        assert_eq!(rig.rti.exchanging(), None);
    }
    assert_eq!(rig.rti.poll_exchange_timeout(), Deadline::Never);
}

#[test]
fn a_federate_that_is_silent_or_gone_keeps_its_turn_for_a_moment_only() {
    let mut rig = rig(3);
    let connections = [0, 1, 2].map(|id| come(&mut rig, id, UDP_PORT_CLOCK_SYNC_INITIAL));
    assert_eq!(pass(&mut rig, MS(1)), Some(connections[0]));
    assert_eq!(pass(&mut rig, Interval::from_nanos(9_999_999)), None);
    assert_eq!(pass(&mut rig, Interval::from_nanos(1)), Some(connections[1]));
    rig.close(connections[1]);
    assert_eq!(pass(&mut rig, Interval::from_nanos(0)), Some(connections[2]));
    // Its exchanges go on beside those of the other.
    answer(&mut rig, connections[0], 0);
    assert_eq!(pass(&mut rig, Interval::from_nanos(0)), Some(connections[0]));
    assert_eq!(rig.rti.exchanging(), Some(connections[2]));
    assert_eq!(read(&mut rig, connections[0]), ["T1", "T4", "T1"]);
}

/// Its silence is not its own fault.
#[test]
fn a_federate_that_waits_for_its_turn_is_not_given_up() {
    let mut rig = rig(2);
    let silent = come(&mut rig, 0, UDP_PORT_CLOCK_SYNC_INITIAL);
    pass(&mut rig, MS(1));
    let waiting = come(&mut rig, 1, UDP_PORT_CLOCK_SYNC_INITIAL);
    wait(&mut rig, Interval::from_secs(10));
    assert!(!rig.outlet.list[silent.0].open && rig.outlet.list[waiting.0].open);
    assert_eq!(pass(&mut rig, Interval::from_nanos(0)), Some(waiting));
    wait(&mut rig, Interval::from_secs(10));
    assert!(!rig.outlet.list[waiting.0].open);
}

#[test]
fn an_answer_without_a_question_is_refused() {
    let mut rig = rig(2);
    let hasty = come(&mut rig, 0, UDP_PORT_CLOCK_SYNC_INITIAL);
    let other = come(&mut rig, 1, UDP_PORT_CLOCK_SYNC_INITIAL);
    answer(&mut rig, hasty, 0);
    assert_eq!(read(&mut rig, hasty), ["REJECT"]);
    assert_eq!(pass(&mut rig, MS(1)), Some(other));
    answer(&mut rig, other, 1);
    answer(&mut rig, other, 1);
    assert_eq!(read(&mut rig, other), ["T1", "T4", "REJECT"]);
    assert_eq!((rig.rti.poll_exchange_timeout(), rig.rti.exchanging()), (Deadline::Never, None));
}
