// SPDX-License-Identifier: Apache-2.0
//! A federate that has been granted tags far ahead is told of an earlier stop only when nothing can come for it any
//! more; one that does not ask for that is told at once, as by the stock RTI.

mod rti_support;

use lf_coordination::in_turn;
use lf_coordination::rti::ConnectionId;
use lf_model::time::Instant;
use lf_wire::Tag;
use lf_wire::june_2026::{DELAY_NONE, Message};
use rti_support::dialogue::{START, config, hello, read};
use rti_support::{Sizes, World};

/// Federates 0 -> 1 -> 2 without delay, started. Their next events are far away, so that all may go far.
fn chain(clock: Instant) -> (World, [ConnectionId; 3], impl Fn(i64) -> Tag) {
    let start = clock.as_nanos() + START;
    let at = move |ns: i64| Tag::new(start + ns, 0);
    let mut world = World::new(config(), Sizes::ample(3));
    let connections = [0, 1, 2].map(|id: u16| {
        let upstream: Vec<_> = id.checked_sub(1).map(|from| (from, DELAY_NONE)).into_iter().collect();
        hello(&mut world, id, &upstream)
    });
    for connection in connections {
        world.message(connection, &Message::Timestamp(clock.as_nanos()));
    }
    for (connection, next) in connections.into_iter().zip([1000, 500, 400]) {
        world.message(connection, &Message::NextEventTag(at(next)));
    }
    for connection in connections {
        read(&mut world, connection);
    }
    (world, connections, at)
}

fn stop(world: &mut World, connections: [ConnectionId; 3], at: &impl Fn(i64) -> Tag) {
    world.message(connections[2], &Message::StopRequest(at(10)));
    world.message(connections[0], &Message::StopReply(at(20)));
    world.message(connections[1], &Message::StopReply(at(10)));
}

fn leave(world: &mut World, connection: ConnectionId) {
    world.message(connection, &Message::NextEventTag(Tag::FOREVER));
    world.message(connection, &Message::Resign);
}

#[test]
fn a_federate_that_asks_for_it_stops_after_those_upstream() {
    let (mut world, connections, at) = chain(in_turn::ask(Instant(0)));
    stop(&mut world, connections, &at);
    let asked = "STOP_REQUEST";
    assert_eq!(read(&mut world, connections[0]), [asked, "STOP_GRANTED"]);
    assert_eq!(read(&mut world, connections[1]), [asked]);
    assert!(read(&mut world, connections[2]).is_empty());
    // What the first one sends at its last tag comes before the stop.
    let last_words = Message::TaggedMessage { port: 0, federate: 1, tag: at(20), payload: &[7] };
    world.message(connections[0], &last_words);
    leave(&mut world, connections[0]);
    let told = read(&mut world, connections[1]);
    assert_eq!(told.first().map(String::as_str), Some("message [7]"));
    assert!(told.iter().any(|message| message == "STOP_GRANTED"), "{told:?}");
    assert!(!read(&mut world, connections[2]).iter().any(|message| message == "STOP_GRANTED"));
    leave(&mut world, connections[1]);
    assert!(read(&mut world, connections[2]).iter().any(|message| message == "STOP_GRANTED"));
}

#[test]
fn one_that_does_not_ask_is_told_at_once() {
    let (mut world, connections, at) = chain(Instant(0));
    stop(&mut world, connections, &at);
    for connection in connections {
        assert!(read(&mut world, connection).iter().any(|message| message == "STOP_GRANTED"));
    }
}

/// The federates upstream may also be lost: nothing comes from them either.
#[test]
fn a_loss_upstream_tells_of_the_stop() {
    let (mut world, connections, at) = chain(in_turn::ask(Instant(0)));
    stop(&mut world, connections, &at);
    world.close(connections[1]);
    assert!(read(&mut world, connections[2]).iter().any(|message| message == "STOP_GRANTED"));
}
