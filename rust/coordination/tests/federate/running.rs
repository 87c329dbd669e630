// SPDX-License-Identifier: Apache-2.0
//! Dialogues with the running federate's state machine that no recording shows, each named after what it proves.

use super::{Federate, config};
use crate::federate_support::dialogue::{DOWNSTREAM, NOW, START, UPSTREAM, drain, ms, net, started};
use lf_coordination::federate::{Disconnected, Event, FederateError, Phase, TAGS_AHEAD_MAX};
use lf_coordination::{Deadline, FederateId, to_wire};
use lf_model::time::{Instant, Interval, Microstep, Tag};
use lf_wire::Message;

fn grant(federate: &mut Federate<'_>, tag: Tag) {
    assert_eq!(federate.handle_message(NOW, Message::TagGrant(to_wire(tag))), Ok(Event::Granted(tag)));
}

fn tagged(tag: Tag, payload: &[u8]) -> Message<'_> {
    Message::TaggedMessage { port: 3, federate: 1, tag: to_wire(tag), payload }
}

#[test]
fn losing_the_rti_says_when_it_happened() {
    let mut federate = started(config(UPSTREAM, DOWNSTREAM));
    let error = federate.handle_disconnected().unwrap_err();
    assert_eq!(error, FederateError::RtiLost { phase: Phase::Running });
    assert_eq!(
        error.to_string(),
        "the connection to the RTI ended while this federate was running: check the network cables and that the RTI is \
         running, and see its output for the reason"
    );
    assert_eq!(drain(&mut federate), []);
}

#[test]
fn a_tag_needs_its_grant_and_is_begun_once() {
    let mut federate = started(config(UPSTREAM, &[]));
    assert!(!federate.next_event(NOW, ms(0)));
    assert_eq!(drain(&mut federate), [net(ms(0))]);
    grant(&mut federate, ms(5));
    assert!(federate.next_event(NOW, ms(0)));
    federate.begin(ms(0)).unwrap();
    federate.complete(false);
    assert_eq!(drain(&mut federate), []);
    assert!(matches!(federate.clone().begin(ms(0)), Err(FederateError::NotLater { .. })));
    let error = federate.begin(ms(6)).unwrap_err();
    assert!(error.to_string().contains("6 ms"), "{error}");
    assert_eq!((federate.phase(), drain(&mut federate)), (Phase::Failed, vec![Message::Failed]));
}

#[test]
fn a_message_for_a_tag_that_was_begun_is_late() {
    let mut federate = started(config(UPSTREAM, &[]));
    grant(&mut federate, ms(5));
    federate.begin(ms(5)).unwrap();
    let payload = [1, 2];
    let next = ms(5).next_microstep();
    let event = Event::Message { port: 3, tag: next, payload: &payload };
    assert_eq!(federate.handle_message(NOW, tagged(next, &payload)), Ok(event));
    let error = federate.handle_message(NOW, tagged(ms(5), &payload)).unwrap_err();
    assert!(matches!(error, FederateError::LateMessage { port: 3, .. }));
    assert!(error.to_string().contains("5 ms"), "{error}");
}

#[test]
fn a_message_from_before_the_start_is_an_error_and_so_is_one_for_another_federate() {
    let mut federate = started(config(UPSTREAM, &[]));
    for (tag, by) in [(ms(-3), Interval::from_millis(3)), (Tag::NEVER, START.since(Instant::NEVER))] {
        let early = federate.clone().handle_message(NOW, tagged(tag, &[]));
        assert_eq!(early, Err(FederateError::BeforeStart { port: 3, by }));
    }
    let message = Message::TaggedMessage { port: 0, federate: 9, tag: to_wire(ms(1)), payload: &[] };
    let wrong = FederateError::WrongDestination { federate: FederateId(9) };
    assert_eq!(federate.handle_message(NOW, message), Err(wrong));
}

#[test]
fn a_message_after_the_last_tag_is_passed_over() {
    let mut federate = started(config(UPSTREAM, &[]));
    federate.limit_stop(ms(5));
    let tag = ms(5).next_microstep();
    let event = Event::MessageAfterStop { port: 3, tag };
    assert_eq!(federate.handle_message(NOW, tagged(tag, &[])), Ok(event));
    assert!(federate.may_send(ms(5)) && !federate.may_send(tag));
    // A later tag counts as the last tag.
    federate.next_event(NOW, ms(7));
    assert_eq!(drain(&mut federate), [net(ms(5))]);
}

#[test]
fn ltc_is_sent_once_and_only_after_an_input_and_before_the_next_net() {
    let mut federate = started(config(UPSTREAM, &[]));
    grant(&mut federate, ms(9));
    federate.begin(ms(1)).unwrap();
    federate.complete(false);
    assert_eq!(drain(&mut federate), []);
    federate.begin(ms(2)).unwrap();
    federate.complete(true);
    federate.next_event(NOW, ms(20));
    assert_eq!(drain(&mut federate), [Message::LatestTagComplete(to_wire(ms(2))), net(ms(20))]);
    federate.complete(true);
    assert_eq!(drain(&mut federate), []);
}

#[test]
fn a_net_that_waited_too_long_does_not_go_out() {
    let mut federate = started(config(UPSTREAM, &[]));
    grant(&mut federate, ms(9));
    federate.next_event(NOW, ms(1));
    federate.begin(ms(2)).unwrap();
    assert_eq!(drain(&mut federate), []);
    federate.next_event(NOW, ms(3));
    federate.begin(ms(3)).unwrap();
    federate.complete(true);
    assert_eq!(drain(&mut federate), [Message::LatestTagComplete(to_wire(ms(3)))]);
}

#[test]
fn with_a_grant_in_hand_one_net_beyond_the_dnet_is_enough() {
    let mut federate = started(config(UPSTREAM, DOWNSTREAM));
    let dnet = |tag| Message::DownstreamNextEventTag(to_wire(tag));
    grant(&mut federate, ms(100));
    federate.handle_message(NOW, dnet(ms(50))).unwrap();
    let nets = |federate: &mut Federate<'static>, tag| {
        assert!(federate.next_event(NOW, tag));
        drain(federate)
    };
    assert_eq!(nets(&mut federate, ms(40)), []);
    assert_eq!(nets(&mut federate, ms(60)), [net(ms(60))]);
    assert_eq!(nets(&mut federate, ms(70)), []);
    // Those downstream want to know more after all.
    federate.handle_message(NOW, dnet(ms(65))).unwrap();
    assert_eq!(drain(&mut federate), [net(ms(70))]);
}

/// The federate that waits for this one may not be the one for which the RTI would send a DNET.
#[test]
fn a_net_beyond_the_dnet_is_not_left_out_for_ever() {
    let mut federate = started(config(UPSTREAM, DOWNSTREAM));
    grant(&mut federate, ms(100));
    federate.handle_message(NOW, Message::DownstreamNextEventTag(to_wire(ms(1)))).unwrap();
    assert!(federate.next_event(NOW, ms(2)));
    assert_eq!(drain(&mut federate), [net(ms(2))]);
    federate.begin(ms(2)).unwrap();
    federate.complete(false);
    assert!(federate.next_event(NOW, ms(3)));
    assert!(drain(&mut federate).is_empty());
    let Deadline::At(later) = federate.poll_timeout() else { panic!("it says when it breaks its silence") };
    federate.handle_timeout(later).unwrap();
    assert_eq!(drain(&mut federate), [net(ms(3))]);
    assert_eq!(federate.poll_timeout(), Deadline::Never);
}

#[test]
fn an_announcement_that_was_not_transmitted_is_replaced_by_a_later_one() {
    let mut federate = started(config(UPSTREAM, DOWNSTREAM));
    grant(&mut federate, ms(1000));
    for time in 0..500 {
        federate.next_event(NOW, ms(time));
        federate.begin(ms(time)).unwrap();
        if time % 100 == 0 {
            federate.sent();
        }
        federate.complete(true);
    }
    federate.next_event(NOW, ms(500));
    assert_eq!(drain(&mut federate), [Message::LatestTagComplete(to_wire(ms(499))), net(ms(500))]);
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
    assert_eq!(run(&mut federate, 0), i64::from(TAGS_AHEAD_MAX));
    federate.handle_message(NOW, question).unwrap();
    let more = run(&mut federate, 100);
    assert!(more > 0 && more < i64::from(TAGS_AHEAD_MAX));
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

/// As an RTI does that lets federates stop in turn.
#[test]
fn a_ptag_of_the_stop_tag_takes_earlier_grants_back() {
    let mut federate = started(config(UPSTREAM, DOWNSTREAM));
    grant(&mut federate, ms(100));
    assert!(federate.next_event(NOW, ms(50)));
    federate.handle_message(NOW, Message::StopRequest(to_wire(ms(3)))).unwrap();
    drain(&mut federate);
    federate.handle_message(NOW, Message::ProvisionalTagGrant(to_wire(ms(4)))).unwrap();
    federate.handle_message(NOW, Message::StopGranted(to_wire(ms(4)))).unwrap();
    assert!(!federate.next_event(NOW, ms(4)));
    let before = to_wire(ms(4).before());
    assert_eq!(drain(&mut federate), [Message::LatestTagComplete(before), net(ms(4))]);
    grant(&mut federate, ms(4));
    assert!(federate.may_advance(ms(4)));
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
fn physical_actions_bound_the_net_and_it_is_renewed() {
    let mut config = config(&[], DOWNSTREAM);
    config.physical_delay = Some(Interval::from_millis(3));
    let mut federate = started(config);
    let at = |after_ms| START + Interval::from_millis(after_ms);
    let bound = |after_ms| Tag::new(START + Interval::from_millis(after_ms) + Interval::from_nanos(-1), Microstep(0));
    federate.begin(ms(0)).unwrap();
    federate.complete(false);
    assert!(federate.next_event(at(0), ms(25)));
    assert_eq!(drain(&mut federate), [net(bound(3))]);
    assert_eq!(federate.poll_timeout(), Deadline::At(at(10)));
    // Asked again before the interval is over: silence.
    federate.next_event(at(5), ms(25));
    assert_eq!(drain(&mut federate), []);
    federate.handle_timeout(at(10)).unwrap();
    assert_eq!(drain(&mut federate), [net(bound(13))]);
    federate.handle_timeout(at(20)).unwrap();
    assert_eq!(drain(&mut federate), [net(bound(23))]);
    // Two ms later nothing can come before the next event any more.
    assert_eq!(federate.poll_timeout(), Deadline::At(at(22)));
    federate.handle_timeout(at(22)).unwrap();
    assert_eq!(drain(&mut federate), [net(ms(25))]);
    assert_eq!(federate.poll_timeout(), Deadline::Never);
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
fn messages_after_the_end_are_ignored() {
    let mut federate = started(config(UPSTREAM, DOWNSTREAM));
    federate.finish();
    assert_eq!(federate.handle_message(NOW, tagged(Tag::NEVER, &[])), Ok(Event::None));
    assert_eq!(drain(&mut federate), [net(Tag::FOREVER), Message::Resign]);
    assert_eq!(federate.handle_message(NOW, Message::Failed), Ok(Event::None));
    federate.fail();
    assert_eq!((federate.phase(), drain(&mut federate)), (Phase::Ended, vec![]));
}

#[test]
fn address_replies_are_ignored_and_other_strangers_are_named() {
    let mut federate = started(config(UPSTREAM, DOWNSTREAM));
    let reply = Message::AddressQueryReply { port: -1, address: [0; 4] };
    assert_eq!(federate.handle_message(NOW, reply), Ok(Event::None));
    let error = federate.handle_message(NOW, Message::Resign).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the RTI sent RESIGN while this federate was running: check that the RTI is one of the same release as this \
         federate"
    );
}

#[test]
fn a_program_that_fails_says_so_instead_of_resigning() {
    for federate in [started(config(UPSTREAM, &[])), Federate::new(config(UPSTREAM, &[])).unwrap()] {
        let connected = federate.phase() != Phase::Disconnected;
        let mut federate = federate;
        federate.fail();
        assert_eq!(federate.phase(), Phase::Failed);
        assert_eq!(drain(&mut federate), if connected { vec![Message::Failed] } else { vec![] });
    }
    // Before the start a federate cannot leave in order: the others wait for it.
    let mut federate = Federate::new(config(UPSTREAM, &[])).unwrap();
    federate.handle_connected(NOW, [0; 8]);
    federate.finish();
    assert_eq!(drain(&mut federate), [Message::Failed]);
}
