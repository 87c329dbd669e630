// SPDX-License-Identifier: Apache-2.0
//! Federations with decentralized coordination: as long as all waits are long enough, they do what the program does
//! without any federation; and when they are not, each message that comes late is known.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use crate::support::federation::{self, Edge, Plan, Report, run};
use crate::support::node::{Behavior, Log};
use lf_coordination::rti::{AfterLoss, Outcome};
use lf_model::time::{Interval, Tag};
use lf_model::{Instant, Microstep};
use lf_runtime::trace::{Event, MessageType, Record};
use lf_runtime::{Coordination, RunError};
use lf_testkit::world::{Conditions, Fault};
use proptest::prelude::*;

const MS: fn(i64) -> Interval = Interval::from_millis;
const US: fn(i64) -> Interval = Interval::from_micros;

fn edge(from: u16, to: u16, delay: Option<Interval>) -> Edge {
    Edge { delay, ..federation::edge(from, to) }
}

fn timer(offset: i64, period: i64) -> Behavior {
    Behavior { timer: Some((MS(offset), MS(period))), ..Behavior::default() }
}

fn relay() -> Behavior {
    Behavior { relay: true, ..Behavior::default() }
}

/// Returns the physical times of the federation at which a federate has sent or received values past the RTI.
fn times_of_direct_values(report: &Report, federate: usize) -> Vec<Duration> {
    let mut ahead = None;
    let mut times = Vec::new();
    for Record { at, event } in &report.records[1 + federate] {
        match event {
            Event::Clock(time) => ahead = Some((*time, *at)),
            Event::Sent(value) | Event::Received(value) if value.kind == MessageType::P2pTaggedMessage => {
                let (time, before) = ahead.expect("a recording begins with the clock");
                times.push((time - Instant::from_nanos(0)) + (*at - before));
            }
            _ => {}
        }
    }
    times
}

fn decentralized(nodes: Vec<Behavior>, edges: Vec<Edge>) -> Plan {
    Plan { coordination: Coordination::Decentralized, capacity: 16, ..Plan::new(nodes, edges) }
}

/// Returns the logs of nodes without cycles of edges without delay when they run in one program, until a last tag.
fn unfederated(plan: &Plan, last: Interval) -> Vec<Log> {
    let count = plan.nodes.len();
    let mut logs = vec![Log::new(); count];
    let mut fired = vec![0u32; count];
    let port_of = |index: usize| {
        let to = plan.edges[index].to;
        plan.edges[..index].iter().filter(|edge| edge.to == to).count()
    };
    // By tag: timers of nodes, and values of edges.
    let mut timers: BTreeMap<Tag, Vec<usize>> = BTreeMap::new();
    let mut values: BTreeMap<Tag, BTreeMap<usize, u32>> = BTreeMap::new();
    for (node, behavior) in plan.nodes.iter().enumerate() {
        if let Some((offset, _)) = behavior.timer {
            timers.entry(Tag::at(Instant::from_nanos(0) + offset)).or_default().push(node);
        }
    }
    loop {
        let next = [timers.keys().next(), values.keys().next()].into_iter().flatten().min().copied();
        let Some(tag) = next.filter(|tag| *tag <= Tag::at(Instant::from_nanos(0) + last)) else { return logs };
        let due = timers.remove(&tag).unwrap_or_default();
        let mut present = values.remove(&tag).unwrap_or_default();
        // Edges without delay lead to nodes of higher numbers.
        for node in 0..count {
            let behavior = plan.nodes[node];
            let mut output = None;
            if due.contains(&node) {
                fired[node] += 1;
                output = Some(fired[node]);
                let (_, period) = behavior.timer.unwrap();
                if period > Interval::ZERO {
                    timers.entry(Tag::at(tag.time + period)).or_default().push(node);
                }
            }
            for (index, _) in plan.edges.iter().enumerate().filter(|(_, edge)| usize::from(edge.to) == node) {
                if let Some(value) = present.remove(&index) {
                    logs[node].push((tag.time.as_nanos(), tag.microstep.0, port_of(index), value));
                    output = if behavior.relay { Some(value.wrapping_add(1)) } else { output };
                }
            }
            let Some(value) = output else { continue };
            for (index, edge) in plan.edges.iter().enumerate().filter(|(_, edge)| usize::from(edge.from) == node) {
                if edge.delay.is_none() {
                    present.insert(index, value);
                    continue;
                }
                let mut at = tag.delayed(edge.delay);
                while values.entry(at).or_default().contains_key(&index) {
                    at = at.next_microstep();
                }
                values.entry(at).or_default().insert(index, value);
            }
        }
    }
}

fn assert_complete(report: &Report) {
    assert_eq!(report.violation, None, "{:?}", report.results);
    assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
    assert_eq!(report.outcome, Some(Ok(Outcome::Complete)));
}

/// Returns the wait of each node when a message takes no longer than `hop`, clock error included: the longest path of
/// others' waits and hops to it, less the delays on it.
fn sufficient_waits(count: usize, edges: &[Edge], hop: Interval) -> Vec<Interval> {
    let mut waits = vec![Interval::ZERO; count];
    // Cycles have more delay than hops, so the longest path visits no node twice.
    for _ in 0..=count {
        for edge in edges {
            let lag = waits[usize::from(edge.from)].as_nanos() + hop.as_nanos();
            let needed = lag - edge.delay.map_or(0, Interval::as_nanos);
            let to = &mut waits[usize::from(edge.to)];
            *to = (*to).max(Interval::from_nanos(needed));
        }
    }
    waits
}

/// Returns programs: timers and relays, edges without delay to higher numbers, edges with a long delay anywhere.
fn programs() -> impl Strategy<Value = (Vec<Behavior>, Vec<Edge>)> {
    let node = prop_oneof![
        3 => (0..4i64, 3..12i64).prop_map(|(offset, period)| timer(offset, period)),
        2 => (0..4i64, 3..12i64).prop_map(|(offset, period)| Behavior { relay: true, ..timer(offset, period) }),
        2 => Just(relay()),
        1 => Just(Behavior::default()),
    ];
    prop::collection::vec(node, 2..5).prop_flat_map(|nodes| {
        let count = u16::try_from(nodes.len()).unwrap();
        let edges = prop::collection::vec((0..count, 0..count, any::<bool>(), 20..40i64), 1..6);
        (Just(nodes), edges).prop_map(move |(nodes, edges)| {
            let edges = edges.into_iter().filter(|(from, to, ..)| from != to);
            let edges =
                edges.map(|(from, to, delayed, delay)| edge(from, to, (delayed || from > to).then_some(MS(delay))));
            (nodes, edges.collect::<Vec<_>>())
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// With waits as long as the network and the clocks need, all happens as in one program, and nothing is late.
    #[test]
    fn with_bounds_kept_it_is_the_same_program(
        seed: u64,
        (nodes, mut edges) in programs(),
        pipe_bytes in 40usize..200,
        within in any::<bool>(),
        spare_bytes in 0..64usize,
    ) {
        let waits = sufficient_waits(nodes.len(), &edges, MS(2));
        for edge in &mut edges {
            let wait = waits[usize::from(edge.to)];
            // The wait can be before the tag, or within it.
            edge.waits = if within { (Interval::ZERO, wait) } else { (wait, Interval::ZERO) };
        }
        let last = MS(60);
        let plan = Plan { timeout: Some(last), spare_bytes, ..decentralized(nodes, edges) };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_complete(&report);
        if within {
            // The message of a past tag can come when a tag without waits has begun.
            return Ok(());
        }
        prop_assert_eq!(&report.late_messages, &vec![0; plan.nodes.len()]);
        prop_assert_eq!(&report.logs, &unfederated(&plan, last));
        prop_assert!(report.late.iter().all(Vec::is_empty));
    }

    /// A federate that waits forever for every input is never late, however long a message takes, as long as all inputs
    /// send.
    #[test]
    fn waiting_for_ever_needs_no_bounds(seed: u64, latency_ns_max in 0..30_000_000u64, periods in [2..9i64, 2..9i64]) {
        let nodes = vec![timer(0, periods[0]), timer(1, periods[1]), relay(), Behavior::default()];
        let mut edges = vec![edge(0, 2, None), edge(1, 2, Some(MS(3))), edge(2, 3, None), edge(0, 3, Some(MS(1)))];
        for edge in &mut edges {
            edge.waits = (Interval::FOREVER, Interval::ZERO);
        }
        // The sources stop, and that they have left is word enough of what they would still have sent.
        let timeouts = BTreeMap::from([(2, None), (3, None)]);
        let last = MS(60);
        let plan = Plan { timeout: Some(last), timeouts, ..decentralized(nodes, edges) };
        let report = run(&plan, Conditions { latency_ns_max, ..Conditions::seeded(seed) });
        assert_complete(&report);
        prop_assert_eq!(&report.late_messages, &vec![0; 4]);
        let alone = unfederated(&plan, last);
        prop_assert!(report.logs[2].starts_with(&alone[2]) && report.logs[3].starts_with(&alone[3]));
    }

    /// With waits that are too short, each value still happens exactly once and in order, and each that does not happen
    /// at its tag is known and counted, by handlers and without.
    #[test]
    fn with_bounds_broken_nothing_goes_unnoticed(
        seed: u64,
        wait in 0..4i64,
        latency_ns_max in 1_000_000..40_000_000u64,
        periods in [1..9i64, 1..9i64],
        delays in [prop::option::of(0..9i64), prop::option::of(0..9i64)],
        capacity in prop_oneof![Just(1usize), Just(2), Just(16)],
        pipe_bytes in 25usize..200,
        handles_tardy: bool,
    ) {
        let receiver = Behavior { handles_tardy, ..timer(0, 2) };
        let nodes = vec![timer(0, periods[0]), timer(0, periods[1]), receiver];
        let mut edges: Vec<_> = (0..2u16).map(|from| edge(from, 2, delays[usize::from(from)].map(MS))).collect();
        for edge in &mut edges {
            edge.waits = (MS(wait), Interval::ZERO);
        }
        let timeouts = BTreeMap::from([(2, Some(MS(3_000)))]);
        let plan = Plan { timeout: Some(MS(60)), timeouts, capacity, ..decentralized(nodes, edges) };
        let report = run(&plan, Conditions { pipe_bytes, latency_ns_max, ..Conditions::seeded(seed) });
        assert_complete(&report);
        let log = &report.logs[2];
        let late = report.late[2].iter().map(|(at, meant, handled)| (*at, (*meant, *handled)));
        let late: BTreeMap<_, _> = late.collect();
        prop_assert_eq!(report.late_messages[2], late.len() as u64);
        for (input, (period, delay)) in periods.into_iter().zip(delays).enumerate() {
            let own: Vec<_> = log.iter().enumerate().filter(|(_, entry)| entry.2 == input).collect();
            let at = |time: i64| Tag::at(Instant::from_nanos(MS(time).as_nanos()));
            let tag_of = |number: i64| at(number * period).delayed(delay.map(MS));
            // Messages for after the sender's last tag are not sent.
            let sent = (0..=60 / period).filter(|number| tag_of(*number) <= at(60));
            prop_assert_eq!(own.len(), sent.count(), "{:?}", log);
            for (number, (at, (time, microstep, _, value))) in (0..).zip(own) {
                prop_assert_eq!(i64::from(*value), number + 1);
                let sent = tag_of(number);
                let happened = Tag::new(Instant::from_nanos(*time), Microstep(*microstep));
                prop_assert!(happened >= sent);
                let meant = late.get(&at).map(|(meant, handled)| {
                    assert_eq!(*handled, handles_tardy);
                    *meant
                });
                let expected = (happened > sent).then_some((sent.time.as_nanos(), sent.microstep.0));
                prop_assert_eq!(meant, expected);
            }
        }
    }
}

/// A cycle without delay: word of absence lets both go on though they would wait much longer within each tag.
#[test]
fn absences_go_from_federate_to_federate_in_cycles() {
    for seed in 0..20 {
        let first = Behavior { level: 0, answers: Some((0, 20)), ..timer(0, 5) };
        let second = Behavior { level: 10, relay: true, ..timer(0, 5) };
        let mut edges = vec![edge(0, 1, None), edge(1, 0, None)];
        for edge in &mut edges {
            edge.waits = (Interval::ZERO, MS(5_000));
        }
        let plan = Plan { timeout: Some(MS(50)), ..decentralized(vec![first, second], edges) };
        let report = run(&plan, Conditions::seeded(seed));
        assert_complete(&report);
        assert_eq!(report.late_messages, [0, 0]);
        assert_eq!((report.logs[0].len(), report.logs[1].len()), (11, 11), "{:?}", report.logs);
        assert!(report.ended.iter().all(|ended| *ended < MS(3_000)), "{:?}", report.ended);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// At the last tag, inputs are waited for as at any other, whether a time-out or a request ends the program: what
    /// is sent there happens there, however long it takes.
    #[test]
    fn messages_sent_at_the_last_tag_happen_there(
        seed: u64,
        stops: bool,
        within: bool,
        is_forever: bool,
        latency_ns_max in 0..30_000_000u64,
        pipe_bytes in 25usize..200,
    ) {
        let wait = if is_forever { Interval::FOREVER } else { MS(20_000) };
        let mut edges = vec![edge(0, 1, None), edge(1, 2, None)];
        for edge in &mut edges {
            edge.waits = (wait, if within { MS(10) } else { Interval::ZERO });
        }
        let source = Behavior { stop_at: stops.then_some(5), farewell: true, ..timer(0, 10) };
        let plan = decentralized(vec![source, relay(), Behavior::default()], edges);
        let plan = Plan { timeout: (!stops).then_some(MS(45)), ..plan };
        let report = run(&plan, Conditions { pipe_bytes, latency_ns_max, ..Conditions::seeded(seed) });
        assert_complete(&report);
        prop_assert_eq!(&report.late_messages, &vec![0; 3]);
        prop_assert_eq!(report.shut_down.clone(), vec![true; 3]);
        // The source counts to five, and says a last word; the relay adds one.
        let last = if stops { (40_000_000, 1) } else { (45_000_000, 0) };
        for (log, value) in [(&report.logs[1], u32::MAX), (&report.logs[2], 0)] {
            prop_assert_eq!(log.len(), 6, "{:?}", log);
            let (time, microstep, _, found) = log[5];
            prop_assert_eq!(((time, microstep), found), (last, value));
        }
        prop_assert!(report.ended.iter().all(|ended| *ended < MS(5_000)), "{:?}", report.ended);
    }

    /// Those of a cycle with delays say at their last tag that nothing more comes, and wait for nothing else.
    #[test]
    fn those_of_a_cycle_with_delays_do_not_wait_for_each_others_end(seed: u64, is_forever: bool, stops: bool) {
        let wait = if is_forever { Interval::FOREVER } else { MS(20_000) };
        let mut edges = vec![edge(0, 1, Some(MS(1))), edge(1, 0, Some(MS(1)))];
        for edge in &mut edges {
            edge.waits = (Interval::ZERO, wait);
        }
        // Each sends before it looks at what has come.
        let mut nodes = vec![Behavior { answers: Some((0, 20)), ..timer(0, 10) }; 2];
        nodes[0].stop_at = stops.then_some(5);
        let plan = Plan { timeout: (!stops).then_some(MS(45)), ..decentralized(nodes, edges) };
        let report = run(&plan, Conditions::seeded(seed));
        assert_complete(&report);
        prop_assert_eq!(&report.late_messages, &vec![0; 2]);
        prop_assert!(report.ended.iter().all(|ended| *ended < MS(3_000)), "{:?}", report.ended);
    }
}

/// A stop goes through the RTI, and all stop at one tag.
#[test]
fn all_stop_at_one_tag() {
    for seed in 0..20 {
        let mut edges = vec![edge(0, 1, None), edge(1, 2, None)];
        for edge in &mut edges {
            edge.waits = (MS(4), MS(10_000));
        }
        let nodes = vec![Behavior { stop_at: Some(5), ..timer(0, 10) }, relay(), Behavior::default()];
        let plan = Plan { keepalive: true, ..decentralized(nodes, edges) };
        let report = run(&plan, Conditions::seeded(seed));
        assert_complete(&report);
        assert_eq!(report.shut_down, [true; 3]);
        assert!(report.ended.iter().all(|ended| *ended < MS(3_000)), "{:?}", report.ended);
    }
}

/// A message to a receiver that has completed its last tag is late as well, down to the last one.
#[test]
fn messages_after_the_last_tag_are_counted() {
    let mut after_the_end = 0;
    for seed in 0..20 {
        let nodes = vec![timer(0, 1), Behavior::default()];
        let plan = Plan { timeout: Some(MS(60)), ..decentralized(nodes, vec![edge(0, 1, None)]) };
        let report = run(&plan, Conditions { latency_ns_max: 40_000_000, pipe_bytes: 60, ..Conditions::seeded(seed) });
        assert_complete(&report);
        let late = report.late[1].len() as u64;
        let in_time = report.logs[1].len() as u64 - late;
        assert_eq!(in_time + report.late_messages[1], 61, "seed {seed}: {:?}", report.logs[1]);
        assert_eq!(report.lost_messages, [0, 0]);
        after_the_end += report.late_messages[1] - late;
    }
    assert!(after_the_end > 0);
}

/// Two that send to each other and end at the same tag read each other's last messages, and do not wait for each other
/// forever.
#[test]
fn federates_in_a_cycle_end_together() {
    for seed in 0..20 {
        let nodes = vec![timer(0, 1), timer(0, 1)];
        let edges = vec![edge(0, 1, None), edge(1, 0, Some(MS(1)))];
        let plan = Plan { timeout: Some(MS(30)), ..decentralized(nodes, edges) };
        let report = run(&plan, Conditions { latency_ns_max: 20_000_000, ..Conditions::seeded(seed) });
        assert_complete(&report);
        assert!(report.ended.iter().all(|ended| *ended < MS(4_000)), "{:?}", report.ended);
        for (federate, sent) in [(0, 30), (1, 31)] {
            let in_time = report.logs[federate].len() - report.late[federate].len();
            assert_eq!(in_time as u64 + report.late_messages[federate], sent);
        }
    }
}

/// A message is written before the next tag runs, unless its sender is late already. Then those of one turn go
/// together, and none waits longer than the turn and its last tag take: the late sender runs ten tags in a turn, and
/// writes twice.
#[test]
fn messages_of_a_sender_that_is_late_go_together() {
    const SENT: usize = 501;
    let conditions = Conditions { latency_ns_max: 0, whole: true, ..Conditions::seeded(1) };
    for (period, delay_max, reads_max) in [(1_000, 0, SENT), (5, 110, 110)] {
        let sender = Behavior { timer: Some((Interval::ZERO, US(period))), work: US(10), ..Behavior::default() };
        let edge = Edge { waits: (MS(1_000), Interval::ZERO), ..edge(0, 1, None) };
        let timeout = Some(US(500 * period));
        let plan = Plan { timeout, ..decentralized(vec![sender, Behavior::default()], vec![edge]) };
        let report = run(&plan, conditions);
        assert_complete(&report);
        let (sent, received) = (times_of_direct_values(&report, 0), times_of_direct_values(&report, 1));
        assert_eq!((sent.len(), received.len()), (SENT, SENT));
        let delay = sent.iter().zip(&received).map(|(sent, received)| received.abs_diff(*sent)).max();
        assert!(delay <= Some(Duration::from_micros(delay_max)), "{delay:?}");
        let reads = received.iter().collect::<BTreeSet<_>>().len();
        assert!(reads <= reads_max, "{reads}");
    }
}

/// A federate that sends to one that has left goes on, and knows the number of lost messages.
#[test]
fn messages_to_one_that_has_left_are_counted_by_their_sender() {
    for seed in 0..10 {
        let nodes = vec![timer(0, 10), Behavior::default(), Behavior::default()];
        let edges = vec![edge(0, 1, None), edge(0, 2, None)];
        let faults = vec![(MS(2_500), 2, Fault::Kill)];
        let plan =
            Plan { timeout: Some(MS(3_000)), faults, after_loss: AfterLoss::GoOn, ..decentralized(nodes, edges) };
        let report = run(&plan, Conditions::seeded(seed));
        assert_eq!(report.violation, None);
        assert_eq!((&report.results[0], &report.results[2]), (&Ok(()), &Ok(())));
        assert!((10..301).contains(&report.lost_messages[0]), "{:?}", report.lost_messages);
    }
}

/// A federate does not wait forever for one that goes on for long after the last tag of its receiver, as one that is
/// cut off may.
#[test]
fn a_peer_that_does_not_end_is_left() {
    let nodes = vec![timer(0, 1_000), Behavior::default()];
    let timeouts = BTreeMap::from([(0, Some(MS(300_000)))]);
    let plan = Plan { timeout: Some(MS(60)), timeouts, ..decentralized(nodes, vec![edge(0, 1, None)]) };
    let report = run(&plan, Conditions::seeded(1));
    assert_complete(&report);
    assert!((MS(61_000)..MS(64_000)).contains(&report.ended[1]), "{:?}", report.ended);
    assert!(report.lost_messages[0] > 200, "{:?}", report.lost_messages);
}

/// The messages of one connection are far ahead, and fill queue and buffer for good, while an absence for another input
/// of that sender lies behind them, for which the receiver waits forever.
#[test]
fn a_wait_that_would_last_for_ever_is_an_error() {
    let nodes = vec![timer(0, 1), Behavior::default()];
    let mut edges = vec![edge(0, 1, None), edge(0, 1, Some(Interval::from_secs(10)))];
    for edge in &mut edges {
        edge.waits = (Interval::FOREVER, Interval::ZERO);
    }
    let plan = Plan { capacity: 1, timeout: Some(MS(20_000)), ..decentralized(nodes, edges) };
    let report = run(&plan, Conditions::seeded(1));
    assert_eq!(report.violation, None, "{:?}", report.results);
    assert_eq!(report.results[1], Err(RunError::InputFull { input: "node.in" }));
}
