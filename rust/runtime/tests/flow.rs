// SPDX-License-Identifier: Apache-2.0
//! Whole federations in virtual time: messages arrive in order for any pieces of their bytes, and full queues lose
//! nothing and hold no federate up forever.

use crate::support::federation::{Edge, Plan, Report, edge, run};
use crate::support::node::{Behavior, Log};
use lf_coordination::rti::{AfterLoss, Outcome};
use lf_model::time::Interval;
use lf_runtime::RunError;
use lf_testkit::world::Conditions;
use proptest::prelude::*;

const MS: fn(i64) -> Interval = Interval::from_millis;

fn timer(period: i64) -> Behavior {
    Behavior { timer: Some((Interval::ZERO, MS(period))), ..Behavior::default() }
}

fn assert_complete(report: &Report) {
    assert_eq!(report.violation, None, "{:?}", report.results);
    assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
    assert_eq!(report.outcome, Some(Ok(Outcome::Complete)));
}

/// Returns the log of a receiver of one timer.
fn from_timer(period: i64, delay: i64, until: i64, input: usize) -> Log {
    let times = (0..=until - delay).step_by(usize::try_from(period).unwrap());
    (1..).zip(times).map(|(count, ms)| ((ms + delay) * 1_000_000, 0, input, count)).collect()
}

/// Returns the expected messages of several senders, in order of tag and input.
fn merged(logs: &[Log]) -> Log {
    let mut all = logs.concat();
    all.sort_unstable();
    all
}

/// Returns a sender and a receiver.
fn pair() -> Plan {
    Plan { timeout: Some(MS(50)), ..Plan::new(vec![timer(5), Behavior::default()], vec![edge(0, 1)]) }
}

/// Returns a fast sender, one whose reaction takes time, and a receiver of both.
fn fan_in(delay: Option<Interval>, work: Interval) -> Plan {
    let slow = Behavior { work, ..timer(25) };
    let edges = vec![Edge { delay, ..edge(0, 2) }, edge(1, 2)];
    Plan { timeout: Some(MS(100)), ..Plan::new(vec![timer(1), slow, Behavior::default()], edges) }
}

fn any_capacity() -> impl Strategy<Value = usize> {
    prop_oneof![Just(1usize), Just(2), Just(16)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Whatever the pieces, the pipes and the queues.
    #[test]
    fn all_messages_arrive_in_order(seed: u64, pipe_bytes in 1usize..200, capacity in any_capacity(), fast: bool) {
        let plan = Plan { capacity, fast, ..pair() };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_complete(&report);
        prop_assert_eq!(&report.logs[1], &from_timer(5, 0, 50, 0));
    }

    /// Relays hold back what their queues cannot take, and all comes through at the tags of its senders.
    #[test]
    fn a_chain_hands_everything_on(seed: u64, pipe_bytes in 1usize..200, capacity in any_capacity(), fast: bool) {
        let relay = Behavior { relay: true, ..Behavior::default() };
        let edges = vec![edge(0, 1), Edge { delay: Some(MS(3)), ..edge(1, 2) }, edge(2, 3)];
        let plan = Plan {
            capacity,
            fast,
            timeout: Some(MS(40)),
            ..Plan::new(vec![timer(2), relay, relay, Behavior::default()], edges)
        };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_complete(&report);
        let passed_on = |(at, step, input, n)| (at, step, input, n + 2);
        let expected: Log = from_timer(2, 3, 40, 0).into_iter().map(passed_on).collect();
        prop_assert_eq!(&report.logs[3], &expected);
    }

    /// Queues of any length, with as much of a receive buffer as a burst needs: nothing is lost, and no federate is
    /// held up.
    #[test]
    fn a_fast_and_a_slow_sender_meet(
        seed: u64,
        capacity in any_capacity(),
        pipe_bytes in prop_oneof![Just(50usize), Just(1 << 16)],
        after in prop_oneof![Just(None), Just(Some(0)), Just(Some(10))],
        work in 0i64..25,
        fast: bool,
    ) {
        let plan = Plan { capacity, fast, spare_bytes: 8192, ..fan_in(after.map(MS), MS(work)) };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_complete(&report);
        let seen: Vec<_> = report.logs[2].iter().map(|(at, _, input, value)| (*at, *input, *value)).collect();
        // With `after 0` the last message would come a microstep after the end.
        let (delay, until) = (after.unwrap_or(0), if after == Some(0) { 99 } else { 100 });
        let expected = merged(&[from_timer(1, delay, until, 0), from_timer(25, 0, 100, 1)]);
        let mut seen_sorted = seen.clone();
        seen_sorted.sort_unstable();
        prop_assert!(seen.is_sorted_by_key(|(at, ..)| *at));
        let due: Vec<_> = expected.iter().map(|(at, _, input, value)| (*at, *input, *value)).collect();
        prop_assert_eq!(seen_sorted, due);
    }

    /// With the smallest buffers a burst may be too long. Then that is an error; nothing is lost in silence, and no
    /// federate waits forever.
    #[test]
    fn a_burst_that_nothing_can_hold_is_an_error(seed: u64, capacity in any_capacity(), work in 0i64..25, fast: bool) {
        let plan = Plan { capacity, fast, after_loss: AfterLoss::StopAll, ..fan_in(None, MS(work)) };
        let report = run(&plan, Conditions::seeded(seed));
        prop_assert_eq!(report.violation, None);
        match &report.results[2] {
            Ok(()) => assert_complete(&report),
            error => prop_assert_eq!(error, &Err(RunError::InputFull { input: "node.in" })),
        }
    }

    /// If queues are smaller than what delays keep in transit, federates can wait in a circle, for room and for each
    /// other's tags. Then one of them ends with an error that names the input, and none waits forever.
    #[test]
    fn a_circle_that_waits_for_room_ends_with_an_error(
        seed: u64,
        delays in prop::array::uniform6(prop_oneof![Just(1i64), 1..30i64]),
        pipe_bytes in 12usize..60,
        capacity in any_capacity(),
        fast: bool,
    ) {
        let relay = Behavior { relay: true, ..timer(1) };
        let pairs = [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)];
        let edges = pairs.iter().zip(delays).map(|((from, to), ms)| Edge { delay: Some(MS(ms)), ..edge(*from, *to) });
        let plan = Plan {
            capacity,
            fast,
            timeout: Some(MS(80)),
            ..Plan::new(vec![relay, relay, timer(1)], edges.collect())
        };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        prop_assert_eq!(report.violation, None, "{:?}", report.results);
        let full = Err(RunError::InputFull { input: "node.in" });
        prop_assert!(report.results.iter().all(|result| result.is_ok() || *result == full), "{:?}", report.results);
    }
}
