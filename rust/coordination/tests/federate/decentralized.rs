// SPDX-License-Identifier: Apache-2.0
//! Dialogues with a federate under decentralized coordination, which begins tags without grants.

use lf_coordination::federate::{Coordination, Event, FederateError, Phase};
use lf_coordination::{Deadline, to_wire};
use lf_wire::{Message, MessageType};

use super::{Config, Federate, config};
use crate::federate_support::dialogue::{DOWNSTREAM, NOW, UPSTREAM, accepted, drain, ms, started};

fn decentralized() -> Config<'static> {
    Config { coordination: Coordination::Decentralized, ..config(UPSTREAM, DOWNSTREAM) }
}

fn run(federate: &mut Federate<'static>, at: i64) {
    federate.begin(ms(at)).unwrap();
    federate.complete(true);
}

#[test]
fn the_rti_learns_of_no_neighbor_and_orders_no_stop() {
    let mut federate = accepted(decentralized());
    assert_eq!((federate.phase(), drain(&mut federate)), (Phase::Starting, vec![]));
    let mut federate = Federate::new(decentralized()).unwrap();
    federate.handle_connected(NOW, [0; 8]);
    drain(&mut federate);
    federate.handle_message(NOW, Message::Ack).unwrap();
    let names: Vec<_> = drain(&mut federate).iter().map(Message::name).collect();
    assert_eq!(names, ["NEIGHBOR_STRUCTURE", "UDP_PORT", "TIMESTAMP"]);
}

#[test]
fn tags_need_no_grant_and_are_announced_to_nobody() {
    let mut federate = started(decentralized());
    for at in 0..100 {
        assert!(federate.may_advance(ms(at)));
        run(&mut federate, at);
        assert_eq!((drain(&mut federate), federate.poll_timeout()), (vec![], Deadline::Never));
        assert!(!federate.may_advance(ms(at)));
    }
    federate.finish();
    assert_eq!(drain(&mut federate), [Message::Resign]);
}

#[test]
fn grants_say_nothing() {
    let mut federate = started(decentralized());
    let tag = to_wire(ms(7));
    for message in [Message::TagGrant(tag), Message::DownstreamNextEventTag(tag)] {
        assert_eq!(federate.handle_message(NOW, message), Ok(Event::None));
    }
    assert!(federate.may_advance(ms(1)));
    assert_eq!(drain(&mut federate), []);
}

#[test]
fn messages_do_not_come_through_the_rti() {
    let tag = to_wire(ms(1));
    for message in [
        Message::TaggedMessage { port: 0, federate: 1, tag, payload: b"1" },
        Message::PortAbsent { port: 0, federate: 1, tag },
        // The answer to a question that only a federate with grants asks.
        Message::PortAbsent { port: u16::MAX, federate: 1, tag: lf_wire::Tag::NEVER },
    ] {
        let (phase, message_type): (_, MessageType) = (Phase::Running, message.message_type());
        let refused = started(decentralized()).handle_message(NOW, message);
        assert_eq!(refused, Err(FederateError::Unexpected { message: message_type, phase }));
    }
}

#[test]
fn all_stop_at_the_tag_that_the_rti_names() {
    let mut federate = started(decentralized());
    run(&mut federate, 1);
    federate.request_stop(ms(2));
    assert_eq!(drain(&mut federate), [Message::StopRequest(to_wire(ms(2)))]);
    assert!(!federate.may_advance(ms(2)));
    assert_eq!(federate.handle_message(NOW, Message::StopGranted(to_wire(ms(3)))), Ok(Event::StopGranted(ms(3))));
    assert!(federate.may_advance(ms(2)) && federate.may_advance(ms(3)) && !federate.may_advance(ms(4)));
}
