// SPDX-License-Identifier: Apache-2.0
//! The state that the RTI keeps up to date, so that a message costs only what it affects, agrees with the plain rules.

mod plain;

use lf_coordination::rti::{ClockSync, Config, ConnectionId};
use lf_testkit::rti::dialogue::START;
use lf_testkit::rti::{Rig, Sizes};
use lf_wire::{DELAY_NONE, Decoded, Limits, Message, NeighborStructure, Tag, decode};
use plain::{Plain, RtiMessage};
use proptest::prelude::*;

const FEDERATION: &[u8] = b"plain";

#[derive(Clone, Copy, Debug)]
enum Event {
    Announce(Tag),
    Complete(Tag),
    Message(u16, Tag),
    Stop(Tag),
    Leave,
}

fn tag() -> impl Strategy<Value = Tag> {
    prop_oneof![
        40 => (0..12i64, 0..3u32).prop_map(|(time, microstep)| Tag::new(START + time, microstep)),
        2 => Just(Tag::FOREVER),
        1 => Just(Tag::NEVER),
    ]
}

fn event() -> impl Strategy<Value = (prop::sample::Index, Event)> {
    let event = prop_oneof![
        30 => tag().prop_map(Event::Announce),
        20 => tag().prop_map(Event::Complete),
        // A sender of a message for the end of time breaks the protocol.
        10 => (any::<u16>(), tag().prop_filter("an end of time", |tag| !matches!(tag.time, i64::MIN | i64::MAX)))
            .prop_map(|(to, tag)| Event::Message(to, tag)),
        1 => tag().prop_map(Event::Stop),
        1 => Just(Event::Leave),
    ];
    (any::<prop::sample::Index>(), event)
}

/// Returns the number of federates, and the connections between them.
fn graph() -> impl Strategy<Value = (u16, Vec<(u16, u16, i64)>)> {
    (1..8u16).prop_flat_map(|count| {
        let delay = prop_oneof![4 => Just(DELAY_NONE), 1 => Just(0), 2 => 1..5i64];
        // Of parallel connections, only one is announced.
        let edges = proptest::collection::btree_map((0..count, 0..count), delay, 0..usize::from(2 * count));
        (Just(count), edges.prop_map(|edges| edges.into_iter().map(|((from, to), delay)| (from, to, delay)).collect()))
    })
}

fn start(count: u16, edges: &[(u16, u16, i64)], dnet: bool) -> (Rig, Vec<ConnectionId>) {
    let config = Config { clock_sync: ClockSync::Off, dnet, ..Config::new(FEDERATION, 8) };
    let mut rig = Rig::new(config, Sizes::ample(count.into()));
    let connections: Vec<_> = (0..count).map(|_| rig.connect()).collect();
    for (id, connection) in (0..count).zip(&connections) {
        let into = edges.iter().filter(|edge| edge.1 == id);
        let upstream: Vec<_> = into.map(|(from, _, delay)| (*from, *delay)).collect();
        rig.message(*connection, &Message::FedIds { federate: id, federation_id: FEDERATION });
        rig.message(*connection, &Message::NeighborStructure(NeighborStructure::new(&upstream, &[])));
        rig.message(*connection, &Message::UdpPort(u16::MAX));
    }
    for connection in &connections {
        rig.message(*connection, &Message::Timestamp(0));
    }
    for connection in &connections {
        rig.take(*connection, usize::MAX);
    }
    (rig, connections)
}

fn said(rig: &mut Rig, connection: ConnectionId) -> Vec<RtiMessage> {
    let bytes = rig.take(connection, usize::MAX);
    let mut rest = &bytes[..];
    let mut said = Vec::new();
    while let Ok(Decoded::Complete { message, len }) = decode(rest, &Limits::NONE) {
        rest = &rest[len..];
        said.extend(match message {
            Message::TagGrant(tag) => Some(RtiMessage::Tag(tag)),
            Message::ProvisionalTagGrant(tag) => Some(RtiMessage::Ptag(tag)),
            Message::DownstreamNextEventTag(tag) => Some(RtiMessage::Dnet(tag)),
            Message::TaggedMessage { tag, .. } => Some(RtiMessage::Message(tag)),
            Message::StopRequest(_) | Message::StopGranted(_) => None,
            other => panic!("{other:?} should not come"),
        });
    }
    assert!(rest.is_empty());
    said
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the federates say, and whether they keep the rules or not.
    #[test]
    fn messages_are_those_of_the_plain_rules(
        (count, edges) in graph(),
        dnet in any::<bool>(),
        events in proptest::collection::vec(event(), 0..80),
    ) {
        let (mut rig, connections) = start(count, &edges, dnet);
        let mut plain = Plain::new(count.into(), &edges, dnet);
        let mut there: Vec<usize> = (0..count.into()).collect();
        for (who, event) in events {
            if there.is_empty() {
                break;
            }
            let place = who.index(there.len());
            let federate = there[place];
            let connection = connections[federate];
            match event {
                Event::Announce(tag) => {
                    rig.message(connection, &Message::NextEventTag(tag));
                    plain.on_next_event(federate, tag);
                }
                Event::Complete(tag) => {
                    rig.message(connection, &Message::LatestTagComplete(tag));
                    plain.on_complete(federate, tag);
                }
                Event::Message(to, tag) => {
                    let to = to % count;
                    rig.message(connection, &Message::TaggedMessage { port: 0, federate: to, tag, payload: b"x" });
                    plain.on_message(to.into(), tag);
                }
                Event::Stop(tag) => {
                    rig.message(connection, &Message::StopRequest(tag));
                    plain.on_stop(federate, tag);
                }
                Event::Leave => {
                    rig.message(connection, &Message::Resign);
                    there.remove(place);
                    plain.on_departure(federate);
                }
            }
            for (id, connection) in connections.iter().enumerate() {
                let expected = std::mem::take(&mut plain.said[id]);
                let found = said(&mut rig, *connection);
                prop_assert_eq!(found, expected, "to federate {} after {:?} of {}", id, event, federate);
            }
        }
    }
}
