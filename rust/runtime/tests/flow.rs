// SPDX-License-Identifier: Apache-2.0
//! Whole federations in virtual time: messages arrive in order whatever becomes of their bytes, and queues that are
//! full lose nothing and hold nobody up for ever.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

mod support;

use lf_coordination::rti::Outcome;
use lf_model::time::Interval;
use proptest::prelude::*;
use support::federation::{Edge, Plan, Report, run};
use support::network::Conditions;
use support::node::Behavior;

const MS: fn(i64) -> Interval = Interval::from_millis;

fn timer(period: i64) -> Behavior {
    Behavior { timer: Some((Interval::ZERO, MS(period))), ..Behavior::default() }
}

fn edge(from: u16, to: u16) -> Edge {
    Edge { from, to, delay: None }
}

fn assert_complete(report: &Report) {
    assert_eq!(report.trouble, None, "{:?}", report.results);
    assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
    assert_eq!(report.outcome, Some(Ok(Outcome::Complete)));
}

/// What a receiver of one timer notes.
fn every(period: i64, until: i64) -> Vec<(i64, u32, usize, u32)> {
    (0..)
        .zip((0..=until).step_by(usize::try_from(period).unwrap()))
        .map(|(n, ms)| (ms * 1_000_000, 0, 0, n + 1))
        .collect()
}

/// A sender and a receiver.
fn pair() -> Plan {
    Plan { timeout: Some(MS(50)), ..Plan::new(vec![timer(5), Behavior::default()], vec![edge(0, 1)]) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn all_messages_arrive_in_order(seed: u64, pipe_bytes in 1usize..200, capacity in prop_oneof![Just(1usize), Just(2), Just(16)], fast: bool) {
        let plan = Plan { capacity, fast, ..pair() };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_complete(&report);
        prop_assert_eq!(&report.logs[1], &every(5, 50));
    }
}
