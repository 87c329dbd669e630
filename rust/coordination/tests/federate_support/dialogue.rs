// SPDX-License-Identifier: Apache-2.0
//! The parts of dialogues with a federate: federate 1 before and at its start, tags, and its messages about them.

use lf_coordination::federate::{ClockSync, Config, Event, Federate, Needs};
use lf_coordination::{FederateId, to_wire};
use lf_model::time::{Instant, Interval, Tag};
use lf_wire::{ADDRESS_PORT_UNKNOWN, DELAY_NONE, Message};

pub(crate) const NOW: Instant = Instant::from_nanos(1_000_000);
pub(crate) const START: Instant = Instant::from_nanos(10_000_000_000);
pub(crate) const UPSTREAM: &[(u16, i64)] = &[(0, DELAY_NONE)];
pub(crate) const DOWNSTREAM: &[u16] = &[2];

/// Federate 1 with these neighbors, without clock synchronization.
pub(crate) fn config<N: Needs>(upstream: &'static [(u16, i64)], downstream: &'static [u16]) -> Config<'static, N> {
    Config { upstream, downstream, clock_sync: ClockSync::Off, ..Config::with_needs(FederateId(1), b"federation") }
}

/// Returns the tag this many ms after the start.
pub(crate) fn ms(ms: i64) -> Tag {
    Tag::at(START + Interval::from_millis(ms))
}

pub(crate) fn net(tag: Tag) -> Message<'static> {
    Message::NextEventTag(to_wire(tag))
}

pub(crate) fn ltc(tag: Tag) -> Message<'static> {
    Message::LatestTagComplete(to_wire(tag))
}

/// Returns the message by which a federate requests an ordered stop, if the RTI grants it tags.
pub(crate) const fn in_turn<N: Needs>() -> &'static [Message<'static>] {
    if N::CENTRALIZED { &[Message::AddressAdvertisement { port: ADDRESS_PORT_UNKNOWN }] } else { &[] }
}

/// Returns all messages of the federate.
pub(crate) fn drain<'a, N: Needs>(federate: &mut Federate<'a, N>) -> Vec<Message<'a>> {
    std::iter::from_fn(|| federate.poll_transmit(usize::MAX)).collect()
}

/// Returns a connected federate with nothing left to transmit.
pub(crate) fn connected<N: Needs>(config: Config<'static, N>) -> Federate<'static, N> {
    let mut federate = Federate::new(config).unwrap();
    federate.handle_connected(NOW, [0; 8]);
    drain(&mut federate);
    federate
}

/// Returns a federate that the RTI has accepted, with nothing left to transmit.
pub(crate) fn accepted<N: Needs>(config: Config<'static, N>) -> Federate<'static, N> {
    let mut federate = connected(config);
    assert_eq!(federate.handle_message(NOW, Message::Ack), Ok(Event::Accepted));
    drain(&mut federate);
    federate
}

/// Returns a federate that has been started, with nothing left to transmit.
pub(crate) fn started<N: Needs>(config: Config<'static, N>) -> Federate<'static, N> {
    let mut federate = accepted(config);
    let event = federate.handle_message(NOW, Message::Timestamp(START.as_nanos()));
    assert_eq!(event, Ok(Event::Started(START)));
    federate
}
