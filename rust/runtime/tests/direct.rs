// SPDX-License-Identifier: Apache-2.0
//! Physical connections: values go from federate to federate past the RTI, and happen when they come.

use crate::support::federation::{Edge, Plan, Report, edge, run};
use crate::support::node::Behavior;
use lf_coordination::rti::{AfterLoss, Outcome};
use lf_model::time::Interval;
use lf_testkit::world::{Conditions, Fault};
use proptest::prelude::*;

const MS: fn(i64) -> Interval = Interval::from_millis;
/// The RTI's start delay and the time for the handshakes, roughly.
const START: i64 = 1_600;

fn timer(period: i64) -> Behavior {
    Behavior { timer: Some((Interval::ZERO, MS(period))), ..Behavior::default() }
}

fn direct(from: u16, to: u16) -> Edge {
    Edge { physical: true, ..edge(from, to) }
}

fn assert_complete(report: &Report) {
    assert_eq!(report.violation, None, "{:?}", report.results);
    assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
    assert_eq!(report.outcome, Some(Ok(Outcome::Complete)));
}

fn values(report: &Report, federate: usize) -> Vec<u32> {
    report.logs[federate].iter().map(|(_, _, _, value)| *value).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// A sender, a relay and a receiver without any logical connection: all comes, in order, at physical times.
    #[test]
    fn values_go_past_the_rti_in_order(
        seed: u64,
        pipe_bytes in 10usize..100,
        capacity in prop_oneof![Just(1usize), Just(2), Just(16)],
    ) {
        let relay = Behavior { relay: true, ..Behavior::default() };
        let nodes = vec![Behavior { stop_at: Some(30), ..timer(5) }, relay, Behavior::default()];
        let delayed = Edge { delay: Some(MS(3)), ..direct(1, 2) };
        let plan = Plan { capacity, ..Plan::new(nodes, vec![direct(0, 1), delayed]) };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_complete(&report);
        for (federate, first) in [(1, 1), (2, 2)] {
            let values = values(&report, federate);
            // Messages in transit when all stop do not take effect any more.
            prop_assert!(values.len() > 15, "{:?}", values);
            prop_assert!(values.iter().copied().eq((first..).take(values.len())), "{:?}", values);
            let times: Vec<_> = report.logs[federate].iter().map(|(time, microstep, ..)| (*time, *microstep)).collect();
            prop_assert!(times.is_sorted(), "{:?}", times);
        }
        // The delay counts from the physical time at which the relay's value comes; the clocks differ by less than the
        // latency.
        for ((one, ..), (other, ..)) in report.logs[1].iter().zip(&report.logs[2]) {
            prop_assert!(other - one >= 2_500_000, "{} {}", one, other);
        }
    }

    /// In both directions, and beside logical connections, which keep their tags.
    #[test]
    fn physical_connections_go_both_ways_and_beside_logical_ones(seed: u64, pipe_bytes in 20usize..100) {
        let nodes = vec![timer(10), timer(10)];
        let logical = Edge { physical: false, ..direct(0, 1) };
        let edges = vec![direct(0, 1), direct(1, 0), logical];
        let plan = Plan { capacity: 16, timeout: Some(MS(95)), ..Plan::new(nodes, edges) };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_complete(&report);
        prop_assert!(values(&report, 0).len() >= 5);
        let logical: Vec<_> = report.logs[1].iter().filter(|(_, _, input, _)| *input == 1).collect();
        prop_assert_eq!(logical.len(), 10);
        for (index, (time, ..)) in (0..).zip(logical) {
            prop_assert_eq!(*time, index * 10_000_000);
        }
    }

    /// A receiver that is slower than the sender slows it down; nothing is lost.
    #[test]
    fn a_slow_receiver_slows_its_sender(seed: u64) {
        let often = Some((Interval::ZERO, Interval::from_nanos(100_000)));
        let sender = Behavior { stop_at: Some(200), timer: often, ..Behavior::default() };
        let busy = Behavior { timer: Some((Interval::ZERO, MS(2))), work: MS(1), ..Behavior::default() };
        let plan = Plan { capacity: 1, fast: true, ..Plan::new(vec![sender, busy], vec![direct(0, 1)]) };
        let report = run(&plan, Conditions { pipe_bytes: 40, ..Conditions::seeded(seed) });
        prop_assert_eq!(report.violation, None);
        let values = values(&report, 1);
        prop_assert!(values.iter().copied().eq((1..).take(values.len())), "{:?}", values);
    }

    /// The one that is sent to comes last, and the one that sends waits for it, as for the start.
    #[test]
    fn a_federate_waits_for_those_to_which_it_sends(seed: u64, late in 0..5_000i64) {
        let nodes = vec![Behavior { stop_at: Some(9), ..timer(5) }, Behavior::default()];
        let begins = [(1, MS(late))].into();
        let plan = Plan { begins, ..Plan::new(nodes, vec![direct(0, 1)]) };
        let report = run(&plan, Conditions::seeded(seed));
        assert_complete(&report);
        prop_assert_eq!(values(&report, 1).first().copied(), Some(1));
    }

    /// A federate ends without a word; those that send to it directly go on, and those that hear from it end.
    #[test]
    fn the_end_of_another_federate_holds_nobody_up(seed: u64, who in 0..3usize, at in 0..200i64) {
        let relay = Behavior { relay: true, ..Behavior::default() };
        let edges = vec![direct(0, 1), direct(1, 2), direct(0, 2)];
        let faults = vec![(MS(START + at), 1 + who, Fault::Kill)];
        let plan = Plan {
            timeout: Some(MS(500)),
            after_loss: AfterLoss::GoOn,
            faults,
            ..Plan::new(vec![timer(5), relay, Behavior::default()], edges)
        };
        let report = run(&plan, Conditions::seeded(seed));
        prop_assert_eq!(report.violation, None);
        for (federate, result) in report.results.iter().enumerate().filter(|(federate, _)| *federate != who) {
            prop_assert_eq!(result, &Ok(()), "{}", federate);
        }
    }
}
