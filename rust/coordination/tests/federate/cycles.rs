// SPDX-License-Identifier: Apache-2.0
//! Dialogues with a federate in a cycle without delay: provisional grants, the level up to which a tag may be run,
//! announcements to the RTI, and late messages.

use super::{Config, Federate, config};
use crate::federate_support::dialogue::{NOW, START, UPSTREAM, drain, ltc, ms, net, started};
use lf_coordination::federate::{Awaited, AwaitedInput, Event, FederateError, Phase};
use lf_coordination::{Deadline, to_wire};
use lf_model::time::{Interval, Tag};
use lf_wire::Message;
use proptest::collection::vec;
use proptest::prelude::*;

/// Of a federate that sends to and receives from federate 0.
fn in_cycle() -> Config<'static> {
    config(UPSTREAM, &[0])
}

fn running() -> Federate<'static> {
    started(in_cycle())
}

fn handle<'m>(federate: &mut Federate<'static>, message: Message<'m>) -> Event<'m> {
    federate.handle_message(NOW, message).unwrap()
}

fn provisional(federate: &mut Federate<'static>, tag: Tag) {
    let event = handle(federate, Message::ProvisionalTagGrant(to_wire(tag)));
    assert_eq!(event, Event::GrantedProvisionally(tag));
}

fn grant(federate: &mut Federate<'static>, tag: Tag) {
    handle(federate, Message::TagGrant(to_wire(tag)));
}

/// Runs an empty tag.
fn run(federate: &mut Federate<'static>, tag: Tag) {
    federate.begin(tag).unwrap();
    federate.complete(false);
}

#[test]
fn a_provisional_grant_is_for_its_tag_and_for_all_that_is_before() {
    let mut federate = running();
    provisional(&mut federate, ms(4));
    assert_eq!((federate.granted_provisionally(), federate.granted()), (Some(ms(4)), ms(4).before()));
    assert!(federate.may_advance(ms(3)) && federate.may_advance(ms(4)));
    assert!(!federate.may_advance(ms(4).next_microstep()));
    grant(&mut federate, ms(4));
    assert_eq!(federate.granted_provisionally(), None);
    assert!(federate.may_advance(ms(4)));
}

/// Also while it waits within a tag for what comes from there.
#[test]
fn a_federate_hears_who_has_left_upstream_of_it() {
    let mut federate = running();
    provisional(&mut federate, ms(4));
    federate.begin(ms(4)).unwrap();
    let left = handle(&mut federate, Message::UpstreamDisconnected { federate: 0 });
    assert_eq!(left, Event::UpstreamLeft(0.into()));
}

#[test]
fn a_provisional_grant_calls_the_federate_to_its_tag() {
    let mut federate = running();
    assert!(!federate.next_event(NOW, ms(9)));
    assert_eq!(drain(&mut federate), [net(ms(9))]);
    provisional(&mut federate, ms(4));
    assert_eq!(federate.demanded_tag(), Some(ms(4)));
    run(&mut federate, ms(2));
    assert_eq!((federate.demanded_tag(), drain(&mut federate)), (Some(ms(4)), vec![]), "an earlier event comes first");
    grant(&mut federate, ms(4));
    assert_eq!(federate.demanded_tag(), Some(ms(4)), "others may wait for it still");
    run(&mut federate, ms(4));
    assert_eq!((federate.demanded_tag(), drain(&mut federate)), (None, vec![ltc(ms(4))]));
    federate.next_event(NOW, ms(9));
    assert_eq!(drain(&mut federate), [], "the RTI knows the next event");
}

/// LF 0.13's RTI demands the start of a federate that has announced nothing yet. The other federate of the cycle, whose
/// next event is later, has nothing to say there.
#[test]
fn the_first_net_is_sent_though_a_provisional_grant_demands_an_earlier_tag() {
    let mut federate = running();
    provisional(&mut federate, Tag::at(START));
    federate.next_event(NOW, ms(1));
    assert_eq!(drain(&mut federate), [net(ms(1))]);
    federate.begin(Tag::at(START)).unwrap();
    provisional(&mut federate, ms(1));
    assert_eq!(federate.granted(), ms(1).before(), "nothing more comes at the start");
}

#[test]
fn a_later_provisional_grant_ends_the_wait_within_an_earlier_tag() {
    let mut federate = running();
    let inputs = [AwaitedInput { port: 0, level: 3 }];
    let mut known = [Tag::FOREVER; 1];
    let awaited = Awaited::new(&inputs, &mut known).unwrap();
    provisional(&mut federate, ms(4));
    federate.begin(ms(4)).unwrap();
    assert_eq!(awaited.max_level(&federate), Some(3));
    provisional(&mut federate, ms(6));
    assert_eq!((awaited.max_level(&federate), federate.demanded_tag()), (None, Some(ms(6))));
    federate.complete(false);
    run(&mut federate, ms(6));
    assert_eq!(drain(&mut federate), [ltc(ms(6))], "which says that the earlier tag is complete too");
}

#[test]
fn a_provisional_grant_for_a_tag_that_is_over_is_answered_at_once() {
    let mut federate = running();
    grant(&mut federate, ms(5));
    run(&mut federate, ms(5));
    assert_eq!(drain(&mut federate), []);
    provisional(&mut federate, ms(3));
    assert_eq!((federate.demanded_tag(), drain(&mut federate)), (None, vec![ltc(ms(3))]));
    provisional(&mut federate, ms(5));
    assert_eq!(drain(&mut federate), [ltc(ms(5))]);
    provisional(&mut federate, ms(4));
    assert_eq!(drain(&mut federate), [], "an LTC never goes back");
    grant(&mut federate, ms(7));
    federate.begin(ms(7)).unwrap();
    provisional(&mut federate, ms(7));
    assert_eq!(drain(&mut federate), [], "the tag is open");
    federate.complete(false);
    assert_eq!(drain(&mut federate), [ltc(ms(7))]);
}

#[test]
fn no_tag_beyond_the_last_one_is_demanded() {
    let mut federate = running();
    federate.limit_stop(ms(5));
    provisional(&mut federate, ms(5).next_microstep());
    assert_eq!(federate.demanded_tag(), None);
    provisional(&mut federate, Tag::FOREVER);
    assert_eq!(federate.demanded_tag(), None);
    assert!(federate.may_advance(ms(5)));
}

#[test]
fn a_tag_under_a_named_stop_waits_for_the_decision() {
    let mut federate = running();
    run_to(&mut federate, ms(1));
    assert_eq!(handle(&mut federate, Message::StopRequest(to_wire(ms(3)))), Event::StopRequested(ms(3)));
    provisional(&mut federate, ms(4));
    assert!(!federate.may_advance(ms(4)));
    assert_eq!(handle(&mut federate, Message::StopGranted(to_wire(ms(4)))), Event::StopGranted(ms(4)));
    assert!(federate.may_advance(ms(4)));
    assert_eq!(federate.demanded_tag(), Some(ms(4)));
}

fn run_to(federate: &mut Federate<'static>, tag: Tag) {
    grant(federate, tag);
    run(federate, tag);
}

#[test]
fn a_message_for_the_open_tag_is_in_time_as_long_as_not_all_is_known() {
    let mut federate = running();
    let message = |tag| Message::TaggedMessage { port: 2, federate: 1, tag: to_wire(tag), payload: &[] };
    provisional(&mut federate, ms(4));
    federate.begin(ms(4)).unwrap();
    assert_eq!(handle(&mut federate, message(ms(4))), Event::Message { port: 2, tag: ms(4), payload: &[] });
    let late = |result: Result<Event<'_>, FederateError>| matches!(result, Err(FederateError::LateMessage { .. }));
    assert!(late(federate.clone().handle_message(NOW, message(ms(4).before()))), "for an earlier tag");
    let mut granted = federate.clone();
    grant(&mut granted, ms(4));
    assert!(late(granted.handle_message(NOW, message(ms(4)))), "the RTI has said that nothing more comes");
    federate.complete(true);
    assert!(late(federate.handle_message(NOW, message(ms(4)))), "the tag is complete");
    assert_eq!(federate.phase(), Phase::Failed);
}

#[test]
fn without_delay_every_net_is_wanted_when_a_dnet_says_never() {
    let mut federate = running();
    handle(&mut federate, Message::DownstreamNextEventTag(lf_wire::Tag::NEVER));
    grant(&mut federate, ms(20));
    for at in 1..4 {
        assert!(federate.next_event(NOW, ms(at)));
        assert_eq!(drain(&mut federate), [net(ms(at))], "others of the cycle wait for it");
        run(&mut federate, ms(at));
    }
}

#[test]
fn a_tag_for_others_only_does_not_renew_the_bound_of_physical_time() {
    let mut config = in_cycle();
    config.physical_delay = Some(Interval::ZERO);
    let mut federate = started(config);
    let at = |after_ms| START + Interval::from_millis(after_ms);
    let bound = |after_ms| Tag::at(at(after_ms) + Interval::from_nanos(-1));
    assert!(!federate.next_event(at(1), ms(90)));
    assert_eq!(drain(&mut federate), [net(bound(1))]);
    provisional(&mut federate, bound(1));
    run(&mut federate, bound(1));
    assert!(!federate.next_event(at(2), ms(90)));
    assert_eq!(drain(&mut federate), [ltc(bound(1))], "another bound would call all to another tag at once");
    assert_eq!(federate.poll_timeout(), Deadline::At(at(11)));
    federate.handle_timeout(at(11)).unwrap();
    assert_eq!(drain(&mut federate), [net(bound(11))]);
    provisional(&mut federate, bound(11));
    federate.begin(bound(11)).unwrap();
    federate.handle_timeout(at(21)).unwrap();
    assert_eq!((federate.poll_timeout(), drain(&mut federate)), (Deadline::Never, vec![]), "a tag is open");
    federate.complete(false);
    assert!(!federate.next_event(at(22), ms(90)));
    assert_eq!(drain(&mut federate), [ltc(bound(11)), net(bound(22))]);
}

#[test]
fn storage_that_is_too_small_is_refused() {
    let inputs = [AwaitedInput { port: 0, level: 3 }; 2];
    assert!(Awaited::new(&inputs, &mut [Tag::NEVER; 1]).is_none());
    assert!(Awaited::new(&inputs, &mut [Tag::NEVER; 3]).is_some());
}

proptest! {
    /// Reactions wait for the inputs of which nothing is known at the current tag, from the least of their levels on;
    /// for none of them once the RTI has granted the tag.
    #[test]
    fn the_level_is_the_least_of_the_unknown(
        levels in vec(0..9u16, 0..5),
        news in vec((0..5u16, 0..9i64), 0..12),
        at in 1..9i64,
        granted in 0..9i64,
    ) {
        let inputs: Vec<_> = (0..).zip(&levels).map(|(port, level)| AwaitedInput { port, level: *level }).collect();
        let mut storage = vec![Tag::FOREVER; inputs.len()];
        let mut awaited = Awaited::new(&inputs, &mut storage).unwrap();
        let mut federate = running();
        provisional(&mut federate, ms(at));
        federate.begin(ms(at)).unwrap();
        for (port, tag) in &news {
            awaited.learn(*port, ms(*tag));
        }
        grant(&mut federate, ms(granted));
        let unknown = |port: u16| news.iter().all(|(to, tag)| *to != port || *tag < at);
        let least = inputs.iter().filter(|input| unknown(input.port)).map(|input| input.level).min();
        prop_assert_eq!(awaited.max_level(&federate), least.filter(|_| granted < at));
    }
}

/// A stock federate takes a late absence for an absence at its current tag: so nothing later is announced while a PTAG
/// may still demand an announced bound of the others, or a tag of this federate.
#[test]
fn a_bound_that_others_may_be_called_to_is_not_passed_before_it_is_granted() {
    let mut config = in_cycle();
    config.physical_delay = Some(Interval::ZERO);
    let mut federate = started(config);
    provisional(&mut federate, Tag::at(START));
    run(&mut federate, Tag::at(START));
    assert_eq!(drain(&mut federate), [ltc(Tag::at(START))]);
    let at = |ms: i64| START + Interval::from_millis(ms);
    let bound = Tag::at(at(2) + Interval::from_nanos(-1));
    federate.next_event(at(2), ms(9));
    assert_eq!(drain(&mut federate), [net(bound)]);
    // Time goes on, and an own event comes.
    for (now, event) in [(13, 19), (14, 14)] {
        federate.next_event(at(now), ms(event));
        assert_eq!((drain(&mut federate), federate.poll_timeout()), (vec![], Deadline::Never), "{now}");
    }
    provisional(&mut federate, bound);
    federate.next_event(at(15), ms(14));
    assert_eq!((drain(&mut federate), federate.demanded_tag()), (vec![], Some(bound)));
    run(&mut federate, bound);
    federate.next_event(at(15), ms(14));
    assert_eq!(drain(&mut federate), [ltc(bound), net(ms(14))]);
    // A grant ends it, too.
    run_to(&mut federate, ms(14));
    let bound = Tag::at(at(16) + Interval::from_nanos(-1));
    federate.next_event(at(16), ms(19));
    assert_eq!(drain(&mut federate), [net(bound)]);
    federate.next_event(at(20), ms(19));
    assert_eq!(drain(&mut federate), []);
    grant(&mut federate, bound);
    federate.next_event(at(20), ms(19));
    assert_eq!(drain(&mut federate), [net(ms(19))]);
}
