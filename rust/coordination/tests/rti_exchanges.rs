// SPDX-License-Identifier: Apache-2.0
//! The exchanges of clock synchronization before the start: whose turn it is, and when.

mod rti_support;

use lf_coordination::Deadline;
use lf_coordination::rti::{ClockSync, Config, ConnectionId};
use lf_model::time::Interval;
use lf_wire::{Message, NeighborStructure, UDP_PORT_CLOCK_SYNC_INITIAL, UDP_PORT_CLOCK_SYNC_OFF};
use rti_support::dialogue::{FEDERATION, config, read, wait};
use rti_support::{Sizes, World};

const MS: fn(i64) -> Interval = Interval::from_millis;

fn world(federates: usize) -> World {
    let config = Config { clock_sync: ClockSync::Init { trials: 2 }, ..config() };
    let mut world = World::new(config, Sizes::ample(federates));
    world.tells_times = false;
    world
}

/// A federate that waits for its turn, or for the others.
fn come(world: &mut World, id: u16, udp_port: u16) -> ConnectionId {
    let connection = world.connect();
    world.message(connection, &Message::FedIds { federate: id, federation_id: FEDERATION });
    world.message(connection, &Message::NeighborStructure(NeighborStructure::new(&[], &[])));
    world.message(connection, &Message::UdpPort(udp_port));
    assert_eq!(read(world, connection), ["ACK"]);
    connection
}

/// Time passes, and what is due then is sent.
fn pass(world: &mut World, interval: Interval) -> Option<ConnectionId> {
    world.now = world.now + interval;
    world.rti.poll_exchange(world.now, &mut world.outlet)
}

fn answer(world: &mut World, connection: ConnectionId, federate: u16) {
    world.message(connection, &Message::T3 { federate });
}

#[test]
fn a_turn_begins_when_no_handshake_has_been_heard_for_a_millisecond() {
    let mut world = world(3);
    assert_eq!(world.rti.poll_exchange_timeout(), Deadline::Never);
    let first = come(&mut world, 0, UDP_PORT_CLOCK_SYNC_INITIAL);
    assert_eq!(pass(&mut world, Interval::from_nanos(999_999)), None);
    // A federate comes that takes no part, but may hold others up all the same.
    come(&mut world, 1, UDP_PORT_CLOCK_SYNC_OFF);
    assert_eq!(pass(&mut world, Interval::from_nanos(1)), None);
    assert_eq!(world.rti.poll_exchange_timeout(), Deadline::At(world.now + Interval::from_nanos(999_999)));
    assert_eq!(pass(&mut world, MS(1)), Some(first));
    assert_eq!((world.rti.exchanging(), pass(&mut world, MS(100))), (Some(first), None));
}

#[test]
fn handshakes_without_end_do_not_put_off_a_turn() {
    let mut world = world(2);
    let first = come(&mut world, 0, UDP_PORT_CLOCK_SYNC_INITIAL);
    let begun = (0..100).find_map(|_| {
        let other = come(&mut world, 1, UDP_PORT_CLOCK_SYNC_INITIAL);
        world.close(other);
        pass(&mut world, Interval::from_nanos(900_000))
    });
    assert_eq!(begun, Some(first));
}

#[test]
fn one_has_all_its_exchanges_before_another_begins() {
    let mut world = world(2);
    let connections = [0, 1].map(|id| come(&mut world, id, UDP_PORT_CLOCK_SYNC_INITIAL));
    for (connection, id) in connections.into_iter().zip(0..) {
        assert_eq!(pass(&mut world, MS(1)), Some(connection));
        assert_eq!(read(&mut world, connection), ["T1"]);
        answer(&mut world, connection, id);
        assert_eq!(read(&mut world, connection), ["T4"]);
        // T1 has the time at which it is sent, not that of the answer before it.
        let later = world.now + Interval::from_nanos(70_000);
        assert_eq!(pass(&mut world, Interval::from_nanos(70_000)), Some(connection));
        let told = world.take(connection, usize::MAX);
        assert_eq!(told[1..], later.as_nanos().to_le_bytes());
        answer(&mut world, connection, id);
        assert_eq!(read(&mut world, connection), ["T4"]);
        assert_eq!(world.rti.exchanging(), None);
    }
    assert_eq!(world.rti.poll_exchange_timeout(), Deadline::Never);
}

#[test]
fn who_is_silent_or_gone_keeps_its_turn_for_a_moment_only() {
    let mut world = world(3);
    let connections = [0, 1, 2].map(|id| come(&mut world, id, UDP_PORT_CLOCK_SYNC_INITIAL));
    assert_eq!(pass(&mut world, MS(1)), Some(connections[0]));
    assert_eq!(pass(&mut world, Interval::from_nanos(9_999_999)), None);
    assert_eq!(pass(&mut world, Interval::from_nanos(1)), Some(connections[1]));
    world.close(connections[1]);
    assert_eq!(pass(&mut world, Interval::from_nanos(0)), Some(connections[2]));
    // Its exchanges go on beside those of the other.
    answer(&mut world, connections[0], 0);
    assert_eq!(pass(&mut world, Interval::from_nanos(0)), Some(connections[0]));
    assert_eq!(world.rti.exchanging(), Some(connections[2]));
    assert_eq!(read(&mut world, connections[0]), ["T1", "T4", "T1"]);
}

/// Its silence is not its own fault.
#[test]
fn who_waits_for_its_turn_is_not_given_up() {
    let mut world = world(2);
    let silent = come(&mut world, 0, UDP_PORT_CLOCK_SYNC_INITIAL);
    pass(&mut world, MS(1));
    let waiting = come(&mut world, 1, UDP_PORT_CLOCK_SYNC_INITIAL);
    wait(&mut world, Interval::from_secs(10));
    assert!(!world.outlet.list[silent.0].open && world.outlet.list[waiting.0].open);
    assert_eq!(pass(&mut world, Interval::from_nanos(0)), Some(waiting));
    wait(&mut world, Interval::from_secs(10));
    assert!(!world.outlet.list[waiting.0].open);
}

#[test]
fn an_answer_without_a_question_is_refused() {
    let mut world = world(2);
    let hasty = come(&mut world, 0, UDP_PORT_CLOCK_SYNC_INITIAL);
    let other = come(&mut world, 1, UDP_PORT_CLOCK_SYNC_INITIAL);
    answer(&mut world, hasty, 0);
    assert_eq!(read(&mut world, hasty), ["REJECT"]);
    assert_eq!(pass(&mut world, MS(1)), Some(other));
    answer(&mut world, other, 1);
    answer(&mut world, other, 1);
    assert_eq!(read(&mut world, other), ["T1", "T4", "REJECT"]);
    assert_eq!((world.rti.poll_exchange_timeout(), world.rti.exchanging()), (Deadline::Never, None));
}
