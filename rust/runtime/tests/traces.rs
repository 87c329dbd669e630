// SPDX-License-Identifier: Apache-2.0
//! What participants record of themselves: all that begins ends, and what goes at one end comes at the other.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

mod support;

use std::collections::BTreeMap;

use lf_coordination::rti::Outcome;
use lf_model::time::{Interval, Tag};
use lf_runtime::Coordination;
use lf_runtime::trace::{Event, MessageType, RTI, Record, Waits, Word};
use proptest::prelude::*;
use support::federation::{Edge, Plan, Report, edge, run};
use support::network::Conditions;
use support::node::Behavior;

const MS: fn(i64) -> Interval = Interval::from_millis;

fn timer(period: i64) -> Behavior {
    Behavior { timer: Some((Interval::ZERO, MS(period))), ..Behavior::default() }
}

/// A sender, one that passes on what comes from it, and a receiver of both.
fn triangle(waits: Interval) -> Plan {
    let edge = |from, to| Edge { waits: (waits, Interval::ZERO), ..edge(from, to) };
    let relay = Behavior { relay: true, ..Behavior::default() };
    let edges = vec![edge(0, 1), edge(0, 2), edge(1, 2)];
    Plan { timeout: Some(MS(40)), ..Plan::new(vec![timer(5), relay, Behavior::default()], edges) }
}

fn assert_complete(report: &Report) {
    assert_eq!(report.trouble, None, "{:?}", report.results);
    assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
    assert_eq!(report.outcome, Some(Ok(Outcome::Complete)));
}

/// What lasts: each begins once and then ends, a reaction within a tag, and nothing while the event loop waits.
fn assert_all_that_begins_ends(records: &[Record]) {
    let (mut tag, mut reaction, mut waits) = (None, None, false);
    for Record { event, .. } in records {
        match *event {
            Event::TagBegins(begun) => assert_eq!((tag.replace(begun), waits), (None, false)),
            Event::TagEnds(ended) => assert_eq!((tag.take(), reaction), (Some(ended), None)),
            Event::ReactionBegins(begun, _, 0) => {
                assert_eq!((reaction.replace(begun), waits), (None, false));
                assert!(tag.is_some());
            }
            Event::ReactionEnds(ended, 0) => assert_eq!(reaction.take(), Some(ended)),
            Event::WaitBegins(_) => assert!(!std::mem::replace(&mut waits, true)),
            Event::WaitEnds => assert!(std::mem::take(&mut waits)),
            _ => {}
        }
    }
    assert_eq!((tag, reaction, waits), (None, None, false));
    assert!(matches!(records.last(), Some(Record { event: Event::Ends(false), .. })), "{:?}", records.last());
}

/// What tells a message from others of its sender and receiver, and how often it was.
type Messages = BTreeMap<(u8, (u16, u16), Option<(i64, u32)>), usize>;

/// The messages of a participant to (`true`) or from another one.
fn messages(records: &[Record], peer: u16, sent: bool) -> Messages {
    let mut all = Messages::new();
    for Record { event, .. } in records {
        let word = match event {
            Event::Sent(word) if sent => word,
            Event::Received(word) if !sent => word,
            _ => continue,
        };
        if word.peer == peer {
            let Word { kind, to, tag, .. } = *word;
            *all.entry((kind.byte(), to, tag.map(|Tag { time, microstep }| (time.as_nanos(), microstep.0))))
                .or_default() += 1;
        }
    }
    all
}

fn values(of: Messages) -> Messages {
    let kinds = [MessageType::TaggedMessage, MessageType::P2pTaggedMessage, MessageType::P2pMessage];
    of.into_iter().filter(|((kind, ..), _)| kinds.iter().any(|value| value.byte() == *kind)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// With an RTI: what a federate sends comes to the RTI, what the RTI sends comes to it as long as it takes part,
    /// and each value goes all the way.
    #[test]
    fn a_federation_records_both_ends_of_each_message(seed: u64, pipe_bytes in 1usize..200, fast: bool) {
        let plan = Plan { fast, ..triangle(Interval::ZERO) };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_complete(&report);
        let (rti, federates) = report.records.split_first().unwrap();
        assert_all_that_begins_ends(rti);
        for (id, records) in (0..).zip(federates) {
            assert_all_that_begins_ends(records);
            prop_assert!(records.iter().any(|record| matches!(record.event, Event::Starts(..))));
            prop_assert_eq!(messages(records, RTI, true), messages(rti, id, false));
            let (sent, received) = (messages(rti, id, true), messages(records, RTI, false));
            prop_assert_eq!(values(sent.clone()), values(received.clone()));
            for (message, count) in &received {
                prop_assert!(sent.get(message) >= Some(count), "{:?} was never sent", message);
            }
        }
        let passed = |sent| values((0..3).flat_map(|id| messages(rti, id, sent)).collect());
        prop_assert_eq!(passed(true), passed(false));
        // Nine tags of the sender, each of which reaches two others, one of which passes it on.
        prop_assert_eq!(passed(true).values().sum::<usize>(), 27);
    }

    /// Past the RTI, values are recorded at both ends, too.
    #[test]
    fn federates_without_grants_record_both_ends_of_each_message(seed: u64) {
        let plan = Plan { coordination: Coordination::Decentralized, ..triangle(MS(20)) };
        let report = run(&plan, Conditions::seeded(seed));
        assert_complete(&report);
        let federates = &report.records[1..];
        for (from, to) in [(0, 1), (0, 2), (1, 2)] {
            let sent = values(messages(&federates[usize::from(from)], to, true));
            prop_assert_eq!(&sent, &values(messages(&federates[usize::from(to)], from, false)));
            prop_assert_eq!(sent.len(), 9);
        }
        for records in federates {
            assert_all_that_begins_ends(records);
        }
    }
}

/// The receiver of a slow federate is recorded as waiting for a grant, and one without an RTI as waiting for the input.
#[test]
fn the_reason_of_a_wait_is_recorded() {
    let edge = Edge { waits: (MS(100), Interval::ZERO), ..edge(0, 1) };
    let plan = Plan { timeout: Some(MS(30)), ..Plan::new(vec![timer(10), timer(1)], vec![edge]) };
    let waits = |coordination| {
        let report = run(&Plan { coordination, ..plan.clone() }, Conditions::seeded(7));
        assert_complete(&report);
        let waits = report.records[2].iter().filter_map(|record| match record.event {
            Event::WaitBegins(waits) => Some(waits),
            _ => None,
        });
        waits.collect::<Vec<_>>()
    };
    let granted = waits(Coordination::Centralized);
    assert!(granted.iter().any(|waits| matches!(waits, Waits::Grant(_))), "{granted:?}");
    assert!(granted.contains(&Waits::Start) && granted.contains(&Waits::End), "{granted:?}");
    let alone = waits(Coordination::Decentralized);
    assert!(alone.iter().any(|waits| matches!(waits, Waits::Input(_, 0, _))), "{alone:?}");
}
