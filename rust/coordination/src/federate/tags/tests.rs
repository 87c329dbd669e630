// SPDX-License-Identifier: Apache-2.0
//! The contract of the state of tags, step by step and with arbitrary input.

use std::vec;

use lf_model::time::Microstep;
use proptest::prelude::*;

use super::*;
use crate::federate::All;

const START: Instant = Instant::from_nanos(1_000);

fn tag(time: i64, microstep: u32) -> Tag {
    Tag::new(START + Interval::from_nanos(time), Microstep(microstep))
}

fn started() -> Tags<All> {
    started_with(true)
}

fn started_with(has_upstream: bool) -> Tags<All> {
    let mut tags = Tags::new(has_upstream, true);
    tags.start(START);
    tags
}

/// Begins and completes a tag that is granted provisionally.
fn run_provisionally(tags: &mut Tags<All>, tag: Tag) {
    tags.grant_provisionally(tag, false);
    tags.begin(tag);
    tags.complete(false);
}

/// Announces a next event without physical actions.
fn announce(tags: &mut Tags<All>, next: Tag) {
    assert!(tags.next_event(next));
    tags.announce(START, None, |_| unreachable!("nothing bounds the next event"));
}

#[test]
fn a_provisional_grant_allows_its_tag_and_what_is_before_and_has_it_confirmed() {
    let mut tags = started();
    tags.grant_provisionally(tag(5, 0), false);
    let allowed = [tag(4, 9), tag(5, 0), tag(5, 1)].map(|tag| tags.allows(tag));
    assert_eq!((allowed, tags.demanded_tag()), ([true, true, false], Some(tag(5, 0))));
    tags.begin(tag(5, 0));
    assert!(!tags.knows_all_inputs() && tags.demanded_tag().is_none());
    assert_eq!(tags.message_received(tag(5, 0)), Arrival::InTime);
    tags.complete(false);
    assert_eq!((tags.ltc(), tags.message_received(tag(5, 0))), (Some(tag(5, 0)), Arrival::Late));
}

#[test]
fn a_provisional_grant_that_comes_too_late_is_confirmed_at_once_or_when_the_tag_is_complete() {
    let mut tags = started();
    tags.grant(tag(9, 0));
    tags.begin(tag(5, 0));
    tags.grant_provisionally(tag(3, 0), false);
    assert_eq!(tags.ltc(), Some(tag(3, 0)));
    tags.ltc_transmitted();
    tags.grant_provisionally(tag(5, 0), false);
    assert_eq!(tags.ltc(), None);
    tags.complete(false);
    assert_eq!(tags.ltc(), Some(tag(5, 0)));
}

#[test]
fn grants_that_a_stop_takes_back_have_to_be_requested_again() {
    let mut tags = started();
    tags.grant(Tag::FOREVER);
    tags.begin(tag(1, 0));
    tags.complete(false);
    tags.grant_provisionally(tag(5, 0), true);
    assert!(tags.allows(tag(4, 0)) && !tags.allows(tag(5, 0)) && tags.demanded_tag().is_none());
    announce(&mut tags, tag(5, 0));
    assert_eq!((tags.ltc(), tags.net()), (Some(tag(5, 0).before()), Some(tag(5, 0))));
    assert!(tags.grant(tag(5, 0)) && tags.allows(tag(5, 0)));
}

#[test]
fn suppressed_announcements_are_sent_after_a_while() {
    let mut tags = started();
    announce(&mut tags, tag(1, 0));
    tags.net_transmitted();
    // No NET up to there matters downstream, so the RTI knows more than it has asked for.
    tags.handle_dnet(tag(0, 0));
    tags.grant(tag(9, 0));
    tags.begin(tag(1, 0));
    tags.complete(false);
    announce(&mut tags, tag(7, 0));
    let due = Deadline::At(START + SILENCE);
    assert_eq!((tags.net(), tags.poll_timeout()), (None, due));
    tags.handle_timeout(START + SILENCE + Interval::from_nanos(-1));
    assert_eq!((tags.net(), tags.poll_timeout()), (None, due));
    tags.handle_timeout(START + SILENCE);
    assert_eq!((tags.net(), tags.poll_timeout()), (Some(tag(7, 0)), Deadline::Never));
}

#[test]
fn a_bound_is_told_once_until_it_is_renewed() {
    let mut tags = started();
    assert!(tags.next_event(Tag::FOREVER));
    let at = |time: i64| START + Interval::from_nanos(time);
    let bound = |tags: &mut Tags<All>, now: i64| tags.announce(at(now), Some(at(now + 2)), |_| at(now + 10));
    bound(&mut tags, 0);
    assert_eq!((tags.net(), tags.poll_timeout()), (Some(tag(1, 0)), Deadline::At(at(10))));
    tags.net_transmitted();
    bound(&mut tags, 9);
    assert_eq!((tags.net(), tags.is_renewal_due(at(9))), (None, false));
    bound(&mut tags, 10);
    assert_eq!((tags.net(), tags.poll_timeout()), (Some(tag(11, 0)), Deadline::At(at(20))));
    tags.finish();
    assert_eq!((tags.net(), tags.poll_timeout()), (Some(Tag::FOREVER), Deadline::Never));
}

#[test]
fn a_tag_that_has_begun_is_not_taken_back() {
    let mut tags = started();
    tags.grant(tag(9, 0));
    tags.begin(tag(5, 0));
    tags.grant_provisionally(tag(5, 0), true);
    assert_eq!((tags.granted(), tags.knows_all_inputs()), (tag(9, 0), true));
}

#[test]
fn an_event_at_the_demanded_tag_is_announced_and_a_later_one_is_not() {
    for (next, announced) in [(tag(5, 0), Some(tag(5, 0))), (tag(5, 1), None)] {
        let mut tags = started();
        announce(&mut tags, tag(1, 0));
        tags.net_transmitted();
        tags.grant_provisionally(tag(5, 0), false);
        announce(&mut tags, next);
        assert_eq!(tags.net(), announced);
    }
}

/// Announces a next event while a physical action can cause an output from `earliest` on.
fn announce_bounded(tags: &mut Tags<All>, next: Tag, earliest: i64) {
    assert!(tags.next_event(next));
    tags.announce(START, Some(START + Interval::from_nanos(earliest)), |_| START + Interval::from_nanos(100));
}

#[test]
fn nothing_physical_comes_before_the_next_microstep() {
    let mut tags = started();
    tags.grant(tag(5, 0));
    tags.begin(tag(5, 0));
    tags.complete(false);
    announce_bounded(&mut tags, tag(5, 1), 2);
    assert_eq!((tags.net(), tags.poll_timeout()), (Some(tag(5, 1)), Deadline::Never));
}

#[test]
fn after_a_tag_the_bound_is_told_at_once() {
    for is_demanded in [false, true] {
        let mut tags = started();
        if is_demanded {
            tags.grant_provisionally(tag(5, 0), false);
        } else {
            tags.grant(tag(9, 0));
        }
        // A message can come for an earlier tag than the next event.
        announce_bounded(&mut tags, tag(if is_demanded { 5 } else { 20 }, 0), 2);
        assert_eq!(tags.net(), Some(tag(1, 0)));
        tags.net_transmitted();
        tags.begin(tag(5, 0));
        tags.complete(false);
        announce_bounded(&mut tags, tag(20, 0), 9);
        assert_eq!(tags.net(), Some(tag(8, 0)), "{is_demanded}");
    }
}

#[test]
fn a_bound_is_owed_until_it_is_granted_though_an_earlier_tag_is_demanded() {
    let mut tags = started();
    run_provisionally(&mut tags, tag(1, 0));
    announce_bounded(&mut tags, tag(20, 0), 10);
    assert_eq!(tags.net(), Some(tag(9, 0)));
    tags.net_transmitted();
    run_provisionally(&mut tags, tag(5, 0));
    announce(&mut tags, tag(20, 0));
    assert_eq!(tags.net(), None);
    tags.grant(tag(9, 0));
    announce(&mut tags, tag(20, 0));
    assert_eq!(tags.net(), Some(tag(20, 0)));
}

#[test]
fn a_message_takes_the_place_of_a_bound() {
    let mut tags = started();
    run_provisionally(&mut tags, tag(1, 0));
    announce_bounded(&mut tags, tag(20, 0), 10);
    tags.net_transmitted();
    assert_eq!(tags.message_received(tag(5, 0)), Arrival::InTime);
    announce(&mut tags, tag(5, 0));
    tags.net_transmitted();
    tags.grant(tag(5, 0));
    tags.begin(tag(5, 0));
    tags.complete(true);
    announce(&mut tags, tag(20, 0));
    assert_eq!(tags.net(), Some(tag(20, 0)));
}

/// A DNET says that nothing up to its tag matters, and nothing is told later either.
#[test]
fn an_event_at_the_tag_of_a_dnet_is_left_out() {
    for has_upstream in [false, true] {
        let mut tags = started_with(has_upstream);
        tags.grant(tag(9, 0));
        tags.handle_dnet(tag(7, 0));
        announce(&mut tags, tag(7, 0));
        assert_eq!((tags.net(), tags.poll_timeout()), (None, Deadline::Never));
        tags.begin(tag(7, 0));
        tags.complete(false);
        announce(&mut tags, tag(8, 0));
        assert_eq!(tags.net(), Some(tag(8, 0)));
    }
}

#[test]
fn without_a_grant_an_event_at_the_tag_of_a_dnet_matters_to_those_with_inputs() {
    for has_upstream in [false, true] {
        let mut tags = started_with(has_upstream);
        tags.handle_dnet(tag(7, 0));
        announce(&mut tags, tag(7, 0));
        assert_eq!(tags.net(), has_upstream.then_some(tag(7, 0)));
    }
}

#[test]
fn a_bound_is_told_if_a_grant_of_it_or_somebody_downstream_needs_it() {
    for (dnet, granted, is_told) in [(8, 20, true), (9, 20, false), (50, 20, false), (50, 9, false), (50, 8, true)] {
        let mut tags = started();
        tags.handle_dnet(tag(dnet, 0));
        tags.grant(tag(granted, 0));
        announce_bounded(&mut tags, tag(30, 0), 10);
        assert_eq!(tags.net(), is_told.then_some(tag(9, 0)), "{dnet} {granted}");
    }
}

#[test]
fn a_net_that_promises_more_does_not_go_out_while_a_tag_is_owed() {
    let mut tags = started();
    announce(&mut tags, tag(1, 0));
    tags.net_transmitted();
    announce(&mut tags, tag(20, 0));
    tags.grant_provisionally(tag(5, 0), false);
    assert_eq!(tags.net(), Some(tag(20, 0)));
    announce(&mut tags, tag(15, 0));
    assert_eq!(tags.net(), None);
}

/// Neither one that is due nor one that was left out; later ones stay.
#[test]
fn no_net_of_a_completed_tag_goes_out() {
    for (next, left) in [(5, None), (20, Some(tag(20, 0)))] {
        for is_left_out in [false, true] {
            let mut tags = started();
            if is_left_out {
                tags.handle_dnet(tag(50, 0));
                tags.grant(tag(20, 0));
            }
            announce(&mut tags, tag(next, 0));
            assert_eq!(tags.net().is_none(), is_left_out);
            tags.grant(tag(5, 0));
            tags.begin(tag(5, 0));
            tags.complete(true);
            tags.handle_dnet(tag(1, 0));
            assert_eq!((tags.ltc(), tags.net()), (Some(tag(5, 0)), left), "{next} {is_left_out}");
        }
    }
}

#[cfg(feature = "transients")]
#[test]
fn what_is_before_the_announced_event_is_known_to_be_over() {
    let mut tags = started();
    announce(&mut tags, tag(7, 0));
    assert_eq!(
        [(6, 9), (7, 0), (7, 1)].map(|(time, microstep)| tags.has_announced_beyond(tag(time, microstep))),
        [true, false, false]
    );
}

#[derive(Clone, Debug)]
enum Step {
    Grant(Tag),
    GrantProvisionally(Tag),
    TakeBack(Tag),
    Dnet(Tag),
    Receive(Tag),
    Next(Tag, Option<i64>),
    Begin(Tag),
    Send,
    Complete(bool),
    Transmit,
    Pass(i64),
}

fn step() -> impl Strategy<Value = Step> {
    let tags = || (0..40i64, 0..3u32).prop_map(|(time, microstep)| tag(time, microstep));
    prop_oneof![
        2 => tags().prop_map(Step::Grant),
        2 => tags().prop_map(Step::GrantProvisionally),
        1 => tags().prop_map(Step::TakeBack),
        1 => tags().prop_map(Step::Dnet),
        2 => tags().prop_map(Step::Receive),
        4 => (tags(), prop::option::of(0..40i64)).prop_map(|(tag, physical)| Step::Next(tag, physical)),
        4 => tags().prop_map(Step::Begin),
        1 => Just(Step::Send),
        3 => any::<bool>().prop_map(Step::Complete),
        3 => Just(Step::Transmit),
        1 => (0..SILENCE.as_nanos()).prop_map(Step::Pass),
    ]
}

proptest! {
    /// For any input in any order: a tag that may begin has been granted and not been revoked, tags rise, no LTC is
    /// sent twice or becomes due before its tag is complete, and a NET is neither of a tag that is over nor later than
    /// the next event.
    #[test]
    fn no_promise_is_broken(steps in prop::collection::vec(step(), 0..120)) {
        let mut tags = started();
        let (mut granted, mut provisional) = (Tag::NEVER, Tag::NEVER);
        let (mut ltc, mut now) = (Tag::NEVER, START);
        // The minimum of what was announced since a tag was begun, with what bounded it.
        let mut next = Tag::FOREVER;
        // Physical time does not run backwards, so neither does the bound that it sets.
        let mut physical_min = 0;
        for step in steps {
            let (before, ltc_before) = (tags.current(), tags.ltc());
            match step {
                Step::Grant(tag) => {
                    prop_assert_eq!(tags.grant(tag), tag > granted);
                    granted = granted.max(tag);
                }
                Step::GrantProvisionally(tag) => {
                    tags.grant_provisionally(tag, false);
                    granted = granted.max(tag.before());
                    provisional = provisional.max(tag);
                }
                Step::TakeBack(tag) => {
                    if tag > tags.current() && tag <= granted {
                        granted = tag.before();
                        provisional = if provisional < tag { provisional } else { Tag::NEVER };
                        tags.grant_provisionally(tag, true);
                        prop_assert!(!tags.allows(tag) && tags.demanded_tag().is_none_or(|demanded| demanded < tag));
                    }
                }
                Step::Dnet(tag) => tags.handle_dnet(tag),
                Step::Receive(tag) => {
                    let late = tags.message_received(tag) == Arrival::Late;
                    let may_be_known = tag == before && granted < tag;
                    prop_assert_eq!(late, tag <= before && !(may_be_known && tags.open));
                }
                Step::Next(tag, physical) => {
                    let was_open = tags.open;
                    prop_assert_eq!(tags.next_event(tag), !was_open && tag > before);
                    if !was_open && tag > before {
                        next = tag;
                        physical_min = physical.unwrap_or_default().max(physical_min);
                        let physical = physical.map(|_| START + Interval::from_nanos(physical_min));
                        tags.announce(now, physical, |_| now + Interval::from_nanos(5));
                    }
                }
                Step::Begin(tag) => {
                    let may = tag > before && (tag <= granted || tag == provisional);
                    prop_assert_eq!(tags.allows(tag), may);
                    if may && !tags.open {
                        tags.begin(tag);
                        next = Tag::FOREVER;
                    }
                }
                Step::Send => tags.message_sent(),
                Step::Complete(had_input) => {
                    let confirms = tags.open && (had_input || provisional == before) && before > tags.confirmed;
                    tags.complete(had_input);
                    prop_assert!(!confirms || tags.ltc() == Some(before));
                }
                Step::Transmit => {
                    if let Some(tag) = tags.ltc() {
                        prop_assert!(tag > ltc);
                        ltc = tag;
                        tags.ltc_transmitted();
                    }
                    if let Some(tag) = tags.net() {
                        prop_assert!(tag >= tags.current() && tag <= next);
                        tags.net_transmitted();
                    }
                }
                Step::Pass(time) => {
                    now = now + Interval::from_nanos(time);
                    tags.handle_timeout(now);
                }
            }
            prop_assert!(tags.current() >= before);
            if let Some(tag) = tags.ltc().filter(|tag| Some(*tag) != ltc_before) {
                prop_assert!(tag <= tags.current().max(next.before()));
            }
            prop_assert_eq!(tags.granted(), granted);
            prop_assert!(tags.demanded_tag().is_none_or(|demanded| tags.allows(demanded)));
        }
    }
}
