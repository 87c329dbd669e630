// SPDX-License-Identifier: Apache-2.0
//! Dialogues with a federate that is transient, or has transient neighbors.

use lf_coordination::federate::{Event, FederateError, Phase};
use lf_coordination::{FederateId, to_wire};
use lf_model::time::Tag;
use lf_wire::{KIND_TRANSIENT, Message, MessageType, RejectCode};

use super::{Config, Federate, config};
use crate::federate_support::dialogue::{
    DOWNSTREAM, NOW, START, UPSTREAM, accepted, connected, drain, ltc, ms, net, started,
};

/// Federate 1, which is transient, between 0 and 2.
fn transient() -> Config<'static> {
    Config { transients: &[1], ..config(UPSTREAM, DOWNSTREAM) }
}

/// Federate 1 between the transient federates 0 and 2.
fn between_transients() -> Config<'static> {
    Config { transients: &[0, 2], ..config(UPSTREAM, DOWNSTREAM) }
}

fn joined(config: Config<'static>, tag: Tag) -> Federate<'static> {
    let mut federate = accepted(config);
    let start = Message::EffectiveStart { start: START.as_nanos(), tag: to_wire(tag) };
    assert_eq!(federate.handle_message(NOW, start), Ok(Event::Joined { start: START, tag }));
    federate
}

fn message(tag: Tag) -> Message<'static> {
    Message::TaggedMessage { port: 0, federate: 1, tag: to_wire(tag), payload: b"x" }
}

#[test]
fn a_transient_federate_says_so() {
    let mut federate = Federate::new(transient()).unwrap();
    federate.handle_connected(NOW, [0; 8]);
    let ids = Message::TransientFedIds { federate: 1, kind: KIND_TRANSIENT, federation_id: b"federation" };
    assert_eq!(drain(&mut federate), [ids]);
    federate.handle_message(NOW, Message::Ack).unwrap();
    let names: Vec<_> = drain(&mut federate).iter().map(Message::name).collect();
    assert_eq!(names, ["NEIGHBOR_STRUCTURE", "UDP_PORT", "ADDRESS_ADVERTISEMENT", "TIMESTAMP"]);
}

#[test]
fn it_begins_with_the_tag_that_the_rti_has_chosen() {
    let first = ms(50).next_microstep();
    let mut federate = joined(transient(), first);
    assert_eq!((federate.phase(), federate.start_time()), (Phase::Running, Some(START)));
    // Messages that a stock RTI lets through are not for this incarnation.
    assert_eq!(federate.handle_message(NOW, message(ms(50))), Ok(Event::None));
    assert!(!federate.next_event(NOW, first));
    assert_eq!(drain(&mut federate), [net(first)]);
    federate.handle_message(NOW, Message::TagGrant(to_wire(first))).unwrap();
    assert!(!federate.may_advance(ms(50)), "a tag before it is over");
    federate.begin(first).unwrap();
    let next = first.next_microstep();
    assert_eq!(federate.handle_message(NOW, message(next)), Ok(Event::Message { port: 0, tag: next, payload: b"x" }));
    federate.complete(true);
    assert_eq!(drain(&mut federate), [ltc(first)]);
    // After its first tag it is like any other.
    assert!(matches!(federate.handle_message(NOW, message(first)), Err(FederateError::LateMessage { .. })));
}

#[test]
fn it_can_join_at_the_start() {
    let mut federate = joined(transient(), Tag::at(START));
    assert!(!federate.next_event(NOW, Tag::at(START)));
    assert_eq!(drain(&mut federate), [net(Tag::at(START))]);
}

/// The RTI gives its clock no other answer than the effective start, which no other federate understands.
#[test]
fn only_a_transient_federate_has_an_effective_start() {
    let start = Message::EffectiveStart { start: START.as_nanos(), tag: to_wire(ms(1)) };
    let unexpected = |phase| Err(FederateError::Unexpected { message: MessageType::Timestamp, phase });
    assert_eq!(accepted(config(UPSTREAM, DOWNSTREAM)).handle_message(NOW, start), unexpected(Phase::Starting));
    assert_eq!(joined(transient(), ms(5)).handle_message(NOW, start), unexpected(Phase::Running));
}

#[test]
fn one_that_comes_too_late_or_while_another_runs_learns_why() {
    let mut federate = accepted(transient());
    let late = Message::Reject(RejectCode::JoinsTooLate);
    assert_eq!(federate.handle_message(NOW, late), Err(FederateError::Rejected(RejectCode::JoinsTooLate)));
    let mut federate = connected(transient());
    assert_eq!(federate.handle_message(NOW, Message::Reject(RejectCode::IdInUse)), Ok(Event::IdInUse));
}

#[test]
fn a_federate_that_is_replaced_stops_alone_and_resigns() {
    let mut federate = joined(transient(), ms(5));
    assert_eq!(federate.handle_message(NOW, Message::Stop), Ok(Event::Replaced));
    federate.finish();
    assert_eq!(drain(&mut federate), [net(Tag::FOREVER), Message::Resign]);
    // One that waits for its start has nothing to complete.
    let mut federate = accepted(transient());
    assert_eq!(federate.handle_message(NOW, Message::Stop), Ok(Event::Replaced));
    federate.finish();
    assert_eq!((drain(&mut federate), federate.phase()), (vec![Message::Resign], Phase::Ended));
    // The RTI replaces no other.
    let unexpected = FederateError::Unexpected { message: MessageType::Stop, phase: Phase::Running };
    assert_eq!(started(config(UPSTREAM, DOWNSTREAM)).handle_message(NOW, Message::Stop), Err(unexpected));
}

#[test]
fn neighbors_that_come_and_go_are_reported_before_the_start_and_after_it() {
    let (came, left) = (Message::UpstreamConnected { federate: 0 }, Message::UpstreamDisconnected { federate: 0 });
    for mut federate in [accepted(between_transients()), started(between_transients())] {
        for _ in 0..2 {
            assert_eq!(federate.handle_message(NOW, came), Ok(Event::UpstreamCame(FederateId(0))));
            assert_eq!(federate.handle_message(NOW, left), Ok(Event::UpstreamLeft(FederateId(0))));
        }
        assert_eq!(federate.handle_message(NOW, Message::OutboundConnected { federate: 2 }), Ok(came_to(2)));
        let left = federate.handle_message(NOW, Message::OutboundDisconnected { federate: 2 });
        assert_eq!(left, Ok(Event::PeerLeft(FederateId(2))));
    }
}

fn came_to(federate: u16) -> Event<'static> {
    Event::PeerCame(FederateId(federate))
}
