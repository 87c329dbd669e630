// SPDX-License-Identifier: Apache-2.0
//! From a federate that has been granted tags far ahead, the grants are taken back that reach an earlier stop tag; one
//! that does not ask for that keeps them, as with the stock RTI.

use lf_coordination::rti::ConnectionId;
use lf_testkit::rti::dialogue::{START, config, hello, read};
use lf_testkit::rti::{Rig, Sizes};
use lf_wire::{ADDRESS_PORT_UNKNOWN, DELAY_NONE, Message, Tag};

/// Federates 0 -> 1 -> 2 without delay, started. Their next events are far away, so that all may go far.
fn chain(ordered_stop: bool) -> (Rig, [ConnectionId; 3], impl Fn(i64) -> Tag) {
    let at = |ns: i64| Tag::new(START + ns, 0);
    let mut rig = Rig::new(config(), Sizes::ample(3));
    let connections = [0, 1, 2].map(|id: u16| {
        let upstream: Vec<_> = id.checked_sub(1).map(|from| (from, DELAY_NONE)).into_iter().collect();
        hello(&mut rig, id, &upstream)
    });
    for connection in connections {
        if ordered_stop {
            rig.message(connection, &Message::AddressAdvertisement { port: ADDRESS_PORT_UNKNOWN });
        }
        rig.message(connection, &Message::Timestamp(0));
    }
    for (connection, next) in connections.into_iter().zip([1000, 500, 400]) {
        rig.message(connection, &Message::NextEventTag(at(next)));
    }
    for connection in connections {
        read(&mut rig, connection);
    }
    (rig, connections, at)
}

fn stop(rig: &mut Rig, connections: [ConnectionId; 3], at: &impl Fn(i64) -> Tag) {
    rig.message(connections[2], &Message::StopRequest(at(10)));
    rig.message(connections[0], &Message::StopReply(at(20)));
    rig.message(connections[1], &Message::StopReply(at(10)));
}

fn leave(rig: &mut Rig, connection: ConnectionId) {
    rig.message(connection, &Message::NextEventTag(Tag::FOREVER));
    rig.message(connection, &Message::Resign);
}

#[test]
fn a_federate_that_asks_for_it_is_granted_the_stop_tag_after_those_upstream() {
    let (mut rig, connections, at) = chain(true);
    stop(&mut rig, connections, &at);
    let ptag = format!("PTAG {} 0", at(20).time - START);
    let revoked = ["STOP_REQUEST", &ptag, "STOP_GRANTED"];
    assert_eq!(read(&mut rig, connections[0]), ["STOP_REQUEST", "STOP_GRANTED"], "nobody grants it anything");
    assert_eq!(read(&mut rig, connections[1]), revoked);
    assert_eq!(read(&mut rig, connections[2]), revoked[1..]);
    // Each asks for its last tag, and says that it has done all that is before.
    for connection in &connections[1..] {
        rig.message(*connection, &Message::LatestTagComplete(at(19)));
        rig.message(*connection, &Message::NextEventTag(at(20)));
        assert!(read(&mut rig, *connection).is_empty());
    }
    // The message of the first one at its last tag comes before the grant of that tag, and so on down the chain.
    let last_words = Message::TaggedMessage { port: 0, federate: 1, tag: at(20), payload: &[7] };
    rig.message(connections[0], &last_words);
    leave(&mut rig, connections[0]);
    assert_eq!(read(&mut rig, connections[1])[1..], ["message [7]", "TAG FOREVER"]);
    assert!(read(&mut rig, connections[2]).is_empty());
    leave(&mut rig, connections[1]);
    assert_eq!(read(&mut rig, connections[2]), ["TAG FOREVER"]);
}

#[test]
fn one_that_does_not_ask_keeps_what_it_has_been_granted() {
    let (mut rig, connections, at) = chain(false);
    stop(&mut rig, connections, &at);
    for connection in connections {
        assert!(!read(&mut rig, connection).iter().any(|message| message.starts_with("PTAG")));
    }
}

/// The federates upstream may also be lost: nothing comes from them either.
#[test]
fn a_loss_upstream_lets_the_stop_tag_be_granted() {
    let (mut rig, connections, at) = chain(true);
    stop(&mut rig, connections, &at);
    rig.close(connections[1]);
    rig.message(connections[2], &Message::NextEventTag(at(20)));
    assert_eq!(read(&mut rig, connections[2]).last().map(String::as_str), Some("TAG FOREVER"));
}

/// It has announced that before it knew of the stop, and still has a message for its last tag.
#[test]
fn an_event_after_the_stop_counts_as_one_at_the_stop() {
    let (mut rig, connections, at) = chain(true);
    stop(&mut rig, connections, &at);
    for connection in connections {
        read(&mut rig, connection);
    }
    rig.message(connections[0], &Message::NextEventTag(at(1000)));
    rig.message(connections[1], &Message::NextEventTag(at(20)));
    assert!(read(&mut rig, connections[1]).is_empty());
    leave(&mut rig, connections[0]);
    assert_eq!(read(&mut rig, connections[1]), ["TAG FOREVER"]);
}
