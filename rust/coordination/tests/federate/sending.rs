// SPDX-License-Identifier: Apache-2.0
//! Dialogues with a running federate that needs no inputs for them, each named after what it proves.

use super::{Federate, config};
use crate::federate_support::dialogue::{DOWNSTREAM, NOW, accepted, drain, ms, net, started};
use lf_coordination::WINDOW;
use lf_coordination::federate::{Disconnected, Event, FederateError, Phase};
use lf_coordination::to_wire;
use lf_model::time::Tag;
use lf_wire::Message;

#[test]
fn losing_the_rti_says_when_it_happened() {
    let mut federate = started(config(&[], DOWNSTREAM));
    let error = federate.handle_disconnected().unwrap_err();
    assert_eq!(error, FederateError::RtiLost { phase: Phase::Running });
    assert_eq!(
        error.to_string(),
        "the connection to the RTI ended while this federate was running: check the network cables and that the RTI is \
         running, and see its output for the reason"
    );
    assert_eq!(drain(&mut federate), []);
}

/// A source of messages begins tags until the limit, and goes on when the RTI has said that it has taken them.
#[test]
fn a_source_waits_until_the_rti_has_taken_its_messages() {
    let mut federate = started(config(&[], DOWNSTREAM));
    let question = Message::PortAbsent { port: u16::MAX, federate: 1, tag: lf_wire::Tag::NEVER };
    let mut questions = 0;
    let mut run = |federate: &mut Federate<'static>, from: i64| {
        let mut tags = 0;
        while federate.next_event(NOW, ms(from + tags)) {
            federate.begin(ms(from + tags)).unwrap();
            federate.sent();
            federate.complete(false);
            questions += drain(federate).iter().filter(|message| **message == question).count();
            tags += 1;
        }
        tags
    };
    assert_eq!(run(&mut federate, 0), i64::from(WINDOW));
    federate.handle_message(NOW, question).unwrap();
    let more = run(&mut federate, 100);
    assert!(more > 0 && more < i64::from(WINDOW));
    assert_eq!(questions, 2);
}

#[test]
fn a_dnet_at_the_skipped_net_is_not_earlier() {
    let mut federate = started(config(&[], DOWNSTREAM));
    let dnet = |tag| Message::DownstreamNextEventTag(to_wire(tag));
    federate.handle_message(NOW, dnet(Tag::FOREVER)).unwrap();
    assert!(federate.next_event(NOW, ms(10)));
    assert_eq!(drain(&mut federate), []);
    federate.handle_message(NOW, dnet(ms(10))).unwrap();
    assert_eq!(drain(&mut federate), []);
    federate.handle_message(NOW, dnet(ms(10).before())).unwrap();
    assert_eq!(drain(&mut federate), [net(ms(10))]);
    federate.handle_message(NOW, dnet(Tag::NEVER)).unwrap();
    assert_eq!(drain(&mut federate), []);
}

/// The RTI knows what the receiver of a message needs as soon as it forwards it, and asks for that; nothing else does.
#[test]
fn an_announcement_suppressed_behind_a_message_is_sent_when_the_rti_asks_for_it() {
    let mut federate = started(config(&[], DOWNSTREAM));
    federate.handle_message(NOW, Message::DownstreamNextEventTag(to_wire(Tag::FOREVER))).unwrap();
    let step = |federate: &mut Federate<'static>, at: i64| {
        assert!(federate.next_event(NOW, ms(at)));
        let said = drain(federate);
        federate.begin(ms(at)).unwrap();
        said
    };
    assert_eq!(step(&mut federate, 0), []);
    // With an `after` of 25 ms.
    federate.sent();
    federate.complete(false);
    // It always announces that it has left the tag of the message.
    assert_eq!(step(&mut federate, 10), [net(ms(10))]);
    for at in [20, 30] {
        federate.complete(false);
        assert_eq!(step(&mut federate, at), []);
    }
    federate.handle_message(NOW, Message::DownstreamNextEventTag(to_wire(ms(25)))).unwrap();
    assert_eq!(drain(&mut federate), [net(ms(30))]);
}

#[test]
fn two_that_ask_to_stop_at_once_agree_without_a_reply() {
    let mut federate = started(config(&[], DOWNSTREAM));
    federate.begin(ms(0)).unwrap();
    federate.request_stop(ms(0));
    federate.complete(false);
    let named = ms(0).next_microstep();
    assert_eq!(drain(&mut federate), [Message::StopRequest(to_wire(named))]);
    let request = Message::StopRequest(to_wire(ms(3)));
    assert_eq!(federate.handle_message(NOW, request), Ok(Event::None));
    assert_eq!(drain(&mut federate), []);
    // Neither the named tag nor a later one, until the RTI has decided.
    assert!(!federate.may_advance(named) && !federate.may_advance(ms(1)));
    let granted = Message::StopGranted(to_wire(ms(3)));
    assert_eq!(federate.handle_message(NOW, granted), Ok(Event::StopGranted(ms(3))));
    assert!(federate.may_advance(ms(3)) && !federate.may_advance(ms(3).next_microstep()));
    federate.request_stop(ms(3));
    assert_eq!(drain(&mut federate), []);
}

#[test]
fn a_federate_asked_to_stop_may_go_on_before_the_tag_that_it_named() {
    let mut federate = started(config(&[], DOWNSTREAM));
    let event = federate.handle_message(NOW, Message::StopRequest(to_wire(ms(3))));
    assert_eq!(event, Ok(Event::StopRequested(ms(3))));
    assert_eq!(drain(&mut federate), [Message::StopReply(to_wire(ms(3)))]);
    assert!(federate.may_advance(ms(3).before()) && !federate.may_advance(ms(3)));
    federate.request_stop(ms(1));
    assert_eq!(drain(&mut federate), []);
}

#[test]
fn a_stop_in_the_past_is_taken_as_soon_as_possible() {
    let mut federate = started(config(&[], DOWNSTREAM));
    federate.begin(ms(8)).unwrap();
    let granted = Message::StopGranted(to_wire(ms(3)));
    let last = ms(8).next_microstep();
    assert_eq!(federate.handle_message(NOW, granted), Ok(Event::StopGranted(last)));
    assert_eq!(federate.stop_tag(), Some(last));
}

#[test]
fn a_federate_without_neighbors_only_resigns() {
    let mut federate = started(config(&[], &[]));
    assert!(federate.next_event(NOW, ms(0)));
    federate.begin(ms(0)).unwrap();
    federate.complete(false);
    federate.finish();
    assert_eq!(drain(&mut federate), [Message::Resign]);
    assert_eq!((federate.phase(), federate.handle_disconnected()), (Phase::Ended, Ok(Disconnected::Ended)));
}

#[test]
fn address_replies_are_ignored_and_other_strangers_are_named() {
    let mut federate = started(config(&[], DOWNSTREAM));
    for reply in [
        Message::AddressQueryReply { port: -1, address: [0; 4] },
        Message::AddressQueryReplyIpv6 { port: -1, address: [0; 16], scope: 0 },
    ] {
        assert_eq!(federate.handle_message(NOW, reply), Ok(Event::None));
    }
    let error = federate.handle_message(NOW, Message::Resign).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the RTI sent RESIGN while this federate was running: check that the RTI is one of the same release as this \
         federate"
    );
}

#[test]
fn a_program_that_fails_says_so_instead_of_resigning() {
    for federate in [started(config(&[], DOWNSTREAM)), Federate::new(config(&[], DOWNSTREAM)).unwrap()] {
        let connected = federate.phase() != Phase::Disconnected;
        let mut federate = federate;
        federate.fail();
        assert_eq!(federate.phase(), Phase::Failed);
        assert_eq!(drain(&mut federate), if connected { vec![Message::Failed] } else { vec![] });
    }
    // Before the start a federate cannot leave in order: the others wait for it.
    let mut connected = Federate::new(config(&[], DOWNSTREAM)).unwrap();
    connected.handle_connected(NOW, [0; 8]);
    for mut federate in [connected, accepted(config(&[], DOWNSTREAM))] {
        federate.finish();
        assert_eq!(drain(&mut federate), [Message::Failed]);
    }
}

#[test]
fn a_stop_before_the_first_tag_is_at_the_start() {
    let mut federate = started(config(&[], DOWNSTREAM));
    assert!(!federate.awaits_stop_tag());
    federate.request_stop(ms(-1));
    assert_eq!(drain(&mut federate), [Message::StopRequest(to_wire(ms(0)))]);
    assert!(federate.awaits_stop_tag());
    let granted = Message::StopGranted(to_wire(ms(0)));
    assert_eq!(federate.handle_message(NOW, granted), Ok(Event::StopGranted(ms(0))));
    assert!(!federate.awaits_stop_tag());
}
