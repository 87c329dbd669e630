// SPDX-License-Identifier: Apache-2.0
//! Quick senders and slow receivers, with the queues that the compiler makes and the smallest buffers: everything comes
//! in order, no queue is ever too small, and nobody waits for ever.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

mod support;

use lf_coordination::rti::Outcome;
use lf_model::time::Interval;
use proptest::prelude::*;
use support::federation::{Edge, PLANNED, Plan, Report, run};
use support::network::Conditions;
use support::node::Behavior;

const US: fn(i64) -> Interval = Interval::from_micros;

fn source(period_us: i64) -> Behavior {
    Behavior { timer: Some((Interval::ZERO, US(period_us))), ..Behavior::default() }
}

fn slow(input_work_us: i64) -> Behavior {
    Behavior { input_work: US(input_work_us), ..Behavior::default() }
}

fn edge(from: u16, to: u16, delay_us: Option<i64>) -> Edge {
    Edge { from, to, delay: delay_us.map(US) }
}

/// As the compiler plans it, for as many periods of 100 us.
fn plan(nodes: Vec<Behavior>, edges: Vec<Edge>, periods: i64) -> Plan {
    Plan { capacity: PLANNED, timeout: Some(US(100 * periods)), ..Plan::new(nodes, edges) }
}

fn assert_bounded(report: &Report) {
    assert_eq!(report.trouble, None, "{:?}", report.results);
    assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
    assert_eq!(report.outcome, Some(Ok(Outcome::Complete)));
    assert!(report.filled.iter().all(|filled| !filled), "{:?}", report.filled);
}

/// Whether the values that came over one input are 1, 2, 3, ….
fn is_gapless(report: &Report, node: usize, input: usize, count: usize) -> bool {
    let values = report.logs[node].iter().filter(|entry| entry.2 == input).map(|entry| entry.3);
    values.eq(1..=u32::try_from(count).unwrap())
}

#[test]
fn a_hundred_thousand_messages_of_a_sender_ten_times_as_quick_as_the_receiver() {
    let plan = Plan { turns_max: 10_000_000, ..plan(vec![source(100), slow(1000)], vec![edge(0, 1, None)], 100_000) };
    let report = run(&plan, Conditions { whole: true, ..Conditions::seeded(7) });
    assert_bounded(&report);
    assert!(is_gapless(&report, 1, 0, 100_001));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// With any delay, in real time or as fast as possible, with any pieces and pipes.
    #[test]
    fn a_quick_sender_waits_for_a_slow_receiver(
        seed: u64,
        pipe_bytes in prop_oneof![Just(60usize), Just(1 << 16)],
        delay_us in prop_oneof![Just(None), Just(Some(0)), Just(Some(100)), Just(Some(200))],
        fast: bool,
    ) {
        let plan = Plan { fast, ..plan(vec![source(100), slow(1000)], vec![edge(0, 1, delay_us)], 300) };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_bounded(&report);
        // What would come after the end is not sent.
        let lost = match delay_us {
            None => 0,
            Some(0) => 1,
            Some(delay) => usize::try_from(delay / 100).unwrap(),
        };
        prop_assert!(is_gapless(&report, 1, 0, 301 - lost));
    }

    /// Two senders of very different speed; the quick one's messages wait for the slow one's word.
    #[test]
    fn a_quick_and_a_slow_sender_meet_at_a_slow_receiver(
        seed: u64,
        pipe_bytes in prop_oneof![Just(60usize), Just(1 << 16)],
        period in 20..200i64,
        work_us in prop_oneof![Just(0i64), Just(30_000)],
        fast: bool,
    ) {
        let sluggish = Behavior { work: US(work_us), ..source(100 * period) };
        let nodes = vec![source(100), sluggish, slow(1000)];
        let plan = Plan { fast, ..plan(nodes, vec![edge(0, 2, None), edge(1, 2, None)], 400) };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_bounded(&report);
        prop_assert!(is_gapless(&report, 2, 0, 401));
        prop_assert!(is_gapless(&report, 2, 1, usize::try_from(400 / period + 1).unwrap()));
        prop_assert!(report.logs[2].is_sorted_by_key(|entry| entry.0));
    }

    /// What comes back to the sender, through one or two others, does not block the way.
    #[test]
    fn a_cycle_with_a_slow_federate_goes_on(
        seed: u64,
        pipe_bytes in prop_oneof![Just(60usize), Just(1 << 16)],
        delay_us in prop_oneof![Just(0i64), Just(100), Just(200)],
        longer: bool,
        fast: bool,
    ) {
        let relay = Behavior { relay: true, ..slow(1000) };
        let (nodes, edges) = if longer {
            let quick = Behavior { relay: true, ..Behavior::default() };
            let edges = vec![edge(0, 1, None), edge(1, 2, None), edge(2, 0, Some(delay_us))];
            (vec![source(100), relay, quick], edges)
        } else {
            (vec![source(100), relay], vec![edge(0, 1, None), edge(1, 0, Some(delay_us))])
        };
        let report = run(
            &Plan { fast, ..plan(nodes, edges, 200) },
            Conditions { pipe_bytes, ..Conditions::seeded(seed) },
        );
        assert_bounded(&report);
        prop_assert!(is_gapless(&report, 1, 0, 201));
        let lost = usize::try_from(if delay_us == 0 { 1 } else { delay_us / 100 }).unwrap();
        prop_assert_eq!(report.logs[0].len(), 201 - lost);
    }

    /// A stop, whoever asks, while many messages are held.
    #[test]
    fn a_stop_gets_past_what_is_held(
        seed: u64,
        pipe_bytes in prop_oneof![Just(60usize), Just(1 << 16)],
        by_receiver: bool,
        stop_at in 1..60u32,
        fast: bool,
    ) {
        let mut nodes = vec![source(100), Behavior { timer: Some((Interval::ZERO, US(100))), ..slow(1000) }];
        nodes[usize::from(by_receiver)].stop_at = Some(stop_at);
        let plan = Plan { fast, timeout: None, ..plan(nodes, vec![edge(0, 1, None)], 0) };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_bounded(&report);
        prop_assert!(is_gapless(&report, 1, 0, report.logs[1].len()));
        prop_assert!(report.shut_down.iter().all(|shut_down| *shut_down));
    }
}
