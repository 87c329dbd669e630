// SPDX-License-Identifier: Apache-2.0
//! Federations of testers, for dialogues with an RTI.

use lf_coordination::IpAddress;
use lf_coordination::rti::{ClockSync, Config, ConnectionId};
use lf_model::time::Interval;
use lf_wire::{DELAY_NONE, Decoded, Limits, Message, Tag, decode};

use super::{Rig, Sizes};
use crate::messages::{encoded, introduction};

/// The federation that the testers join.
pub const FEDERATION: &[u8] = b"dialogue";
/// Upstream federates and the delays from them.
pub type Upstream<'a> = &'a [(u16, i64)];

/// The start time of a federation whose federates all join at once.
pub const START: i64 = 1_000_000_000;

/// Returns a configuration without clock synchronization.
pub fn config() -> Config<'static> {
    Config { clock_sync: ClockSync::Off, ..Config::new(FEDERATION, 100) }
}

/// Returns the tag this number of nanoseconds after the start.
pub fn at(ns: i64) -> Tag {
    Tag::new(START + ns, 0)
}

/// Takes the messages that arrived on a connection, as text.
///
/// # Panics
/// If the bytes are not whole messages.
pub fn read(rig: &mut Rig, connection: ConnectionId) -> Vec<String> {
    let bytes = rig.take(connection, usize::MAX);
    let mut rest = &bytes[..];
    let mut messages = Vec::new();
    while let Ok(Decoded::Complete { message, len }) = decode(rest, &Limits::NONE) {
        messages.push(match message {
            Message::TagGrant(tag) if tag == Tag::FOREVER => "TAG FOREVER".to_owned(),
            Message::TagGrant(Tag { time, microstep }) => format!("TAG {} {microstep}", time - START),
            Message::ProvisionalTagGrant(Tag { time, microstep }) => format!("PTAG {} {microstep}", time - START),
            Message::DownstreamNextEventTag(Tag::NEVER) => "DNET NEVER".to_owned(),
            Message::DownstreamNextEventTag(Tag::FOREVER) => "DNET FOREVER".to_owned(),
            Message::DownstreamNextEventTag(Tag { time, microstep }) => format!("DNET {} {microstep}", time - START),
            Message::TaggedMessage { payload, .. } => format!("message {payload:?}"),
            other => other.name().to_owned(),
        });
        rest = &rest[len..];
    }
    assert!(rest.is_empty());
    messages
}

/// Connects a federate with these upstream federates, which joins.
pub fn hello(rig: &mut Rig, id: u16, upstream: Upstream<'_>) -> ConnectionId {
    let connection = rig.connect();
    introduce(rig, connection, id, upstream);
    connection
}

/// Connects a federate without upstream federates from this address, which joins.
pub fn hello_from(rig: &mut Rig, id: u16, address: IpAddress) -> ConnectionId {
    let connection = rig.connect_from(address);
    introduce(rig, connection, id, &[]);
    connection
}

fn introduce(rig: &mut Rig, connection: ConnectionId, id: u16, upstream: Upstream<'_>) {
    for message in introduction(id, FEDERATION, upstream, &[]) {
        rig.message(connection, &message);
    }
    assert_eq!(read(rig, connection), ["ACK"]);
}

/// Starts the federates 0 → 1 → 2 …, with nothing left to read.
///
/// # Panics
/// If the federation does not start.
pub fn chain(config: Config<'static>, sizes: Sizes) -> (Rig, Vec<ConnectionId>) {
    let ids = 0..u16::try_from(sizes.federates).expect("there are few");
    let upstream: Vec<_> = ids.map(|id| id.checked_sub(1).map_or(vec![], |from| vec![(from, DELAY_NONE)])).collect();
    started(config, sizes, &upstream)
}

/// Starts a federation with these connections into each federate, with nothing left to read.
///
/// # Panics
/// If the federation does not start.
pub fn started(config: Config<'static>, sizes: Sizes, upstream: &[Vec<(u16, i64)>]) -> (Rig, Vec<ConnectionId>) {
    let mut rig = Rig::new(config, sizes);
    let connections: Vec<_> = upstream.iter().zip(0..).map(|(list, id)| hello(&mut rig, id, list)).collect();
    for connection in &connections {
        rig.message(*connection, &Message::Timestamp(0));
    }
    for connection in &connections {
        assert_eq!(read(&mut rig, *connection), ["TIMESTAMP"]);
    }
    (rig, connections)
}

/// Lets time pass.
pub fn wait(rig: &mut Rig, interval: Interval) {
    rig.now = rig.now + interval;
    let now = rig.now;
    rig.rti.handle_timeout(now, &mut rig.outlet);
}

/// Returns a message of one of the testers.
pub fn message(to: u16, ns: i64, payload: &[u8]) -> Message<'_> {
    Message::TaggedMessage { port: 0, federate: to, tag: at(ns), payload }
}

/// Returns a message by which a federate offers the RTI a window, for the port [`u16::MAX`], or the RTI answers with
/// that of the federation, for the port before it.
pub fn flow(port: u16, federate: u16, window: u32) -> Message<'static> {
    Message::PortAbsent { port, federate, tag: Tag { microstep: window, ..Tag::NEVER } }
}

/// Offers a window, when nothing else is to be read; returns that of the federation, which the RTI names at once.
///
/// # Panics
/// If it does not, or says anything else.
pub fn offered(rig: &mut Rig, connection: ConnectionId, federate: u16, window: u32) -> u32 {
    rig.message(connection, &flow(u16::MAX, federate, window));
    let said = rig.take(connection, usize::MAX);
    match decode(&said, &Limits::NONE) {
        Ok(Decoded::Complete { message: Message::PortAbsent { tag, .. }, len }) if len == said.len() => {
            assert_eq!(said, encoded(&flow(u16::MAX - 1, federate, tag.microstep)));
            tag.microstep
        }
        other => panic!("{other:?} is no answer"),
    }
}
