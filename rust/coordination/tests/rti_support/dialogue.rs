// SPDX-License-Identifier: Apache-2.0
//! Federations of testers, for dialogues with an RTI.

use lf_coordination::IpAddress;
use lf_coordination::rti::{ClockSync, Config, ConnectionId};
use lf_model::time::Interval;
use lf_wire::{DELAY_NONE, Decoded, Limits, Message, NeighborStructure, Tag, decode};

use super::{Sizes, World};

pub const FEDERATION: &[u8] = b"dialogue";
/// Federates and delays.
pub type Upstream<'a> = &'a [(u16, i64)];

pub const START: i64 = 1_000_000_000;

pub fn config() -> Config<'static> {
    Config { clock_sync: ClockSync::Off, ..Config::new(FEDERATION, 100) }
}

pub fn at(ns: i64) -> Tag {
    Tag::new(START + ns, 0)
}

/// What has come on a connection, in words.
pub fn read(world: &mut World, connection: ConnectionId) -> Vec<String> {
    let bytes = world.take(connection, usize::MAX);
    let mut rest = &bytes[..];
    let mut messages = Vec::new();
    while let Ok(Decoded::Complete { message, len }) = decode(rest, &Limits::NONE) {
        messages.push(match message {
            Message::TagGrant(tag) if tag == Tag::FOREVER => "TAG FOREVER".to_owned(),
            Message::TagGrant(Tag { time, microstep }) => format!("TAG {} {microstep}", time - START),
            Message::ProvisionalTagGrant(Tag { time, microstep }) => format!("PTAG {} {microstep}", time - START),
            Message::TaggedMessage { payload, .. } => format!("message {payload:?}"),
            other => other.name().to_owned(),
        });
        rest = &rest[len..];
    }
    assert!(rest.is_empty());
    messages
}

pub fn hello(world: &mut World, id: u16, upstream: Upstream<'_>) -> ConnectionId {
    let connection = world.connect();
    introduce(world, connection, id, upstream);
    connection
}

/// The same, without upstream federates, from this address.
pub fn hello_from(world: &mut World, id: u16, address: IpAddress) -> ConnectionId {
    let connection = world.connect_from(address);
    introduce(world, connection, id, &[]);
    connection
}

fn introduce(world: &mut World, connection: ConnectionId, id: u16, upstream: Upstream<'_>) {
    world.message(connection, &Message::FedIds { federate: id, federation_id: FEDERATION });
    world.message(connection, &Message::NeighborStructure(NeighborStructure::new(upstream, &[])));
    world.message(connection, &Message::UdpPort(u16::MAX));
    assert_eq!(read(world, connection), ["ACK"]);
}

/// Federates 0 → 1 → 2 …, started, with nothing to be read.
pub fn chain(config: Config<'static>, sizes: Sizes) -> (World, Vec<ConnectionId>) {
    let ids = 0..u16::try_from(sizes.federates).expect("there are few");
    let upstream: Vec<_> = ids.map(|id| id.checked_sub(1).map_or(vec![], |from| vec![(from, DELAY_NONE)])).collect();
    started(config, sizes, &upstream)
}

/// A federation with these connections into each federate, started, with nothing to be read.
pub fn started(config: Config<'static>, sizes: Sizes, upstream: &[Vec<(u16, i64)>]) -> (World, Vec<ConnectionId>) {
    let mut world = World::new(config, sizes);
    let connections: Vec<_> = upstream.iter().zip(0..).map(|(list, id)| hello(&mut world, id, list)).collect();
    for connection in &connections {
        world.message(*connection, &Message::Timestamp(0));
    }
    for connection in &connections {
        assert_eq!(read(&mut world, *connection), ["TIMESTAMP"]);
    }
    (world, connections)
}

pub fn wait(world: &mut World, interval: Interval) {
    world.now = world.now + interval;
    let now = world.now;
    world.rti.handle_timeout(now, &mut world.outlet);
}

pub fn message(to: u16, ns: i64, payload: &[u8]) -> Message<'_> {
    Message::TaggedMessage { port: 0, federate: to, tag: at(ns), payload }
}
