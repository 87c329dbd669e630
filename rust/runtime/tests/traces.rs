// SPDX-License-Identifier: Apache-2.0
//! The recordings of participants: every span that begins ends, and every message that is sent at one end is received
//! at the other.

use std::collections::BTreeMap;

use crate::support::federation::{Edge, Plan, Report, edge, run};
use crate::support::node::Behavior;
use lf_coordination::rti::Outcome;
use lf_model::time::{Instant, Interval, Tag};
use lf_runtime::Coordination;
use lf_runtime::trace::{Event, MessageType, RTI, Record, TracedMessage, Waits};
use lf_testkit::trace::with_values;
use lf_testkit::world::Conditions;
use proptest::prelude::*;

const MS: fn(i64) -> Interval = Interval::from_millis;

fn timer(period: i64) -> Behavior {
    Behavior { timer: Some((Interval::ZERO, MS(period))), ..Behavior::default() }
}

/// Returns a sender, one that forwards its messages, and a receiver of both.
fn triangle(waits: Interval) -> Plan {
    let edge = |from, to| Edge { waits: (waits, Interval::ZERO), ..edge(from, to) };
    let relay = Behavior { relay: true, ..Behavior::default() };
    let edges = vec![edge(0, 1), edge(0, 2), edge(1, 2)];
    Plan { timeout: Some(MS(40)), ..Plan::new(vec![timer(5), relay, Behavior::default()], edges) }
}

fn assert_complete(report: &Report) {
    assert_eq!(report.violation, None, "{:?}", report.results);
    assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
    assert_eq!(report.outcome, Some(Ok(Outcome::Complete)));
}

/// Checks spans: each begins once and then ends, a reaction within a tag, and nothing while the event loop waits.
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

/// The identity of a message among others of its sender and receiver, and its number.
type Messages = BTreeMap<(u8, (u16, u16), Option<(i64, u32)>), usize>;

/// Returns the messages of a participant to (`true`) or from another one.
fn messages(records: &[Record], peer: u16, sent: bool) -> Messages {
    let mut all = Messages::new();
    for Record { event, .. } in records {
        let word = match event {
            Event::Sent(word) if sent => word,
            Event::Received(word) if !sent => word,
            _ => continue,
        };
        if word.peer == peer {
            let TracedMessage { kind, to, tag, .. } = *word;
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

/// A message as a node has noted it, and as it was recorded: its tag since the start, its input, its value.
type Given = (i64, u32, usize, u32);

/// Returns the events of a federate with their values.
fn events(records: &[Record]) -> Vec<(Event, Option<u32>)> {
    let value = |bytes: Vec<u8>| u32::from_le_bytes(bytes.try_into().unwrap());
    with_values(records.iter().copied()).into_iter().map(|(it, bytes)| (it.event, bytes.map(value))).collect()
}

fn start(records: &[Record]) -> Instant {
    let mut starts = records.iter().filter_map(|record| match record.event {
        Event::Starts(start, _) => Some(start),
        _ => None,
    });
    starts.next().unwrap()
}

/// Returns the values that a federate has received at tags, according to its recording.
fn received(records: &[Record]) -> Vec<Given> {
    let start = start(records);
    let mut all: Vec<_> = events(records)
        .into_iter()
        .filter_map(|(event, value)| match event {
            Event::Received(word) if word.is_value() => {
                let tag = word.tag.unwrap();
                Some((tag.time.since(start).as_nanos(), tag.microstep.0, word.to.1.into(), value.unwrap()))
            }
            _ => None,
        })
        .collect();
    all.sort_unstable();
    all
}

fn sorted(log: &[Given]) -> Vec<Given> {
    let mut log = log.to_vec();
    log.sort_unstable();
    log
}

/// Returns the values of the physical action, each with the tag at which it happened.
fn physical(records: &[Record]) -> Vec<(i64, u32, u32)> {
    let (start, mut tag, mut all) = (start(records), Tag::NEVER, Vec::new());
    for (event, value) in events(records) {
        match event {
            Event::TagBegins(begun) => tag = begun,
            Event::Physical(_) => {
                all.push((tag.time.since(start).as_nanos(), tag.microstep.0, value.unwrap()));
            }
            _ => {}
        }
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// The stream holds all that a federate was given: each value with its tag and input, whatever way it came.
    #[test]
    fn a_stream_holds_the_values_that_a_federate_was_given(
        seed: u64,
        capacity in 1usize..3,
        pipe_bytes in 1usize..200,
        decentralized: bool,
    ) {
        let coordination = if decentralized { Coordination::Decentralized } else { Coordination::Centralized };
        let plan = Plan { capacity, coordination, ..triangle(MS(20)) };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_complete(&report);
        for (records, log) in report.records[1..].iter().zip(&report.logs) {
            prop_assert_eq!(received(records), sorted(log));
        }
        prop_assert_eq!(report.logs.iter().map(Vec::len).sum::<usize>(), 27);
    }

    /// It holds what threads have scheduled, at which tag, and with which value.
    #[test]
    fn a_stream_holds_physical_actions_with_their_values(seed: u64) {
        let source = Behavior { physical: true, ..timer(5) };
        let plan = Plan { timeout: Some(MS(40)), ..Plan::new(vec![source, Behavior::default()], vec![edge(0, 1)]) };
        let report = run(&plan, Conditions::seeded(seed));
        assert_complete(&report);
        // What happens at the source is seen at the sink, at the same tag.
        let seen = report.logs[1].iter().map(|(time, microstep, _, value)| (*time, *microstep, *value));
        let seen: Vec<_> = seen.collect();
        prop_assert!(!seen.is_empty());
        prop_assert_eq!(physical(&report.records[1]), seen);
        prop_assert_eq!(physical(&report.records[2]), []);
    }

    /// It holds the grants without which no tag begins, and the stop at which all end.
    #[test]
    fn a_stream_holds_grants_and_the_stop(seed: u64) {
        let nodes = vec![Behavior { stop_at: Some(4), ..timer(5) }, Behavior::default()];
        let plan = Plan { timeout: None, ..Plan::new(nodes, vec![edge(0, 1)]) };
        let report = run(&plan, Conditions::seeded(seed));
        assert_complete(&report);
        let requests = |records: &[Record]| records.iter().filter(|it| matches!(
            it.event,
            Event::Sent(TracedMessage { kind: MessageType::StopRequest, .. })
        )).count();
        prop_assert_eq!(requests(&report.records[1]), 1);
        let mut stops = Vec::new();
        for (id, records) in report.records.iter().enumerate().skip(1) {
            let (mut granted, mut stop, mut last) = (Tag::NEVER, None, Tag::NEVER);
            for Record { event, .. } in records {
                match event {
                    Event::Received(TracedMessage { kind: MessageType::TagGrant, tag: Some(tag), .. }) => {
                        granted = *tag;
                    }
                    Event::Received(TracedMessage { kind: MessageType::StopGranted, tag, .. }) => stop = *tag,
                    Event::TagBegins(tag) => {
                        // Only the second has others upstream; the last tag is granted with the stop.
                        prop_assert!(id == 1 || *tag <= granted || Some(*tag) == stop);
                        last = *tag;
                    }
                    _ => {}
                }
            }
            prop_assert_eq!(stop, Some(last));
            stops.push(stop.unwrap().time.since(start(records)));
        }
        prop_assert_eq!(stops[0], stops[1]);
    }
}

/// Values are recorded only where they are asked for, and nothing at all where nothing is.
#[test]
fn a_recorder_gets_what_is_asked_for() {
    for (asked, has_values) in [(None, false), (Some(false), false), (Some(true), true)] {
        let source = Behavior { physical: true, ..timer(5) };
        let nodes = vec![source, Behavior::default()];
        let plan = Plan { timeout: Some(MS(40)), records: asked, ..Plan::new(nodes, vec![edge(0, 1)]) };
        let report = run(&plan, Conditions::seeded(1));
        assert_complete(&report);
        let records = report.records.concat();
        assert_eq!(records.is_empty(), asked.is_none());
        let is_value = |record: &Record| matches!(record.event, Event::Data(_) | Event::Physical(_));
        assert_eq!(records.iter().any(is_value), has_values);
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
