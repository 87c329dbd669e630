// SPDX-License-Identifier: Apache-2.0
//! Dialogues with the running federate's state machine that no recording shows, each named after what it proves.

use super::{Federate, config};
use crate::federate_support::dialogue::{DOWNSTREAM, NOW, START, UPSTREAM, drain, ms, net, started};
use lf_coordination::federate::{Event, FederateError, Phase};
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
fn messages_after_the_end_are_ignored() {
    let mut federate = started(config(UPSTREAM, DOWNSTREAM));
    federate.finish();
    federate.finish();
    assert_eq!(federate.handle_message(NOW, tagged(Tag::NEVER, &[])), Ok(Event::None));
    assert_eq!(drain(&mut federate), [net(Tag::FOREVER), Message::Resign]);
    assert_eq!(federate.handle_message(NOW, Message::Failed), Ok(Event::None));
    federate.fail();
    assert_eq!((federate.phase(), drain(&mut federate)), (Phase::Ended, vec![]));
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
