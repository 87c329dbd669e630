// SPDX-License-Identifier: Apache-2.0
//! Cycles without delay in virtual time: federates ask and answer within a tag, for any pieces of the bytes between
//! them, and none waits forever when another one leaves.

use crate::support::federation::{Edge, Plan, Report, edge, run};
use crate::support::node::{Behavior, Log};
use lf_coordination::rti::Outcome;
use lf_model::time::Interval;
use lf_runtime::Coordination;
use lf_testkit::world::{Conditions, Fault};
use proptest::prelude::*;

const MS: fn(i64) -> Interval = Interval::from_millis;

fn timer(period: i64) -> Behavior {
    Behavior { timer: Some((Interval::ZERO, MS(period))), ..Behavior::default() }
}

/// Sends by its timer, and looks at what comes on input `first` and later ones after that.
fn asks(period: i64, first: usize, level: u16) -> Behavior {
    Behavior { answers: Some((first, level)), ..timer(period) }
}

/// Answers what comes, at levels from this on.
fn answers(level: u16) -> Behavior {
    Behavior { relay: true, level, ..Behavior::default() }
}

fn any_conditions() -> impl Strategy<Value = Conditions> {
    (any::<u64>(), 20..400usize, 0..3_000_000u64, any::<bool>())
        .prop_map(|(seed, pipe_bytes, latency_ns_max, whole)| Conditions { seed, pipe_bytes, latency_ns_max, whole })
}

fn assert_complete(report: &Report) {
    assert_eq!(report.violation, None, "{:?}", report.results);
    assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
    assert_eq!(report.outcome, Some(Ok(Outcome::Complete)));
}

/// Returns the log of a timer with this period and this much added on the way, up to and including a time.
fn from_timer(period: i64, until: i64, input: usize, added: u32) -> Log {
    let times = (0..=until).step_by(usize::try_from(period).unwrap());
    (1..).zip(times).map(|(count, ms)| (ms * 1_000_000, 0, input, count + added)).collect()
}

fn merged(logs: &[Log]) -> Log {
    let mut all = logs.concat();
    all.sort_unstable();
    all
}

fn ping_pong() -> Plan {
    let nodes = vec![asks(10, 0, 20), answers(10)];
    Plan { timeout: Some(MS(60)), ..Plan::new(nodes, vec![edge(0, 1), edge(1, 0)]) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn an_answer_comes_at_the_tag_of_the_question(conditions in any_conditions(), fast: bool) {
        let report = run(&Plan { fast, ..ping_pong() }, conditions);
        assert_complete(&report);
        prop_assert_eq!(report.logs, [from_timer(10, 60, 0, 1), from_timer(10, 60, 0, 0)]);
        prop_assert_eq!(report.shut_down, [true; 2]);
    }

    /// The port numbers that other compilers use from a federate to itself lie before, between and behind the others.
    #[test]
    fn numbers_of_ports_to_itself_are_left_out(conditions in any_conditions(), own in 0..4usize) {
        let own_ports = [&[0][..], &[1], &[0, 1], &[0, 2, 5]][own];
        let two = Plan { own_ports, ..ping_pong() };
        let report = run(&two, conditions);
        assert_complete(&report);
        prop_assert_eq!(report.logs, [from_timer(10, 60, 0, 1), from_timer(10, 60, 0, 0)]);
        let nodes = vec![timer(10), timer(15), Behavior::default()];
        let plan = Plan { timeout: Some(MS(60)), own_ports, ..Plan::new(nodes, vec![edge(0, 2), edge(1, 2)]) };
        for coordination in [Coordination::Centralized, Coordination::Decentralized] {
            let waits = (MS(20), Interval::ZERO);
            let edges = plan.edges.iter().map(|edge| Edge { waits, ..*edge }).collect();
            let report = run(&Plan { edges, coordination, ..plan.clone() }, conditions);
            assert_complete(&report);
            let expected = merged(&[from_timer(10, 60, 0, 0), from_timer(15, 60, 1, 0)]);
            prop_assert_eq!(merged(&report.logs[2..]), expected);
        }
    }

    /// Two timers at once in one cycle: each federate is at tags at which the other has no event.
    #[test]
    fn both_ask_in_one_cycle(conditions in any_conditions()) {
        // The first sends before it looks at what comes; the second sends after that.
        let second = Behavior { level: 10, ..timer(4) };
        let plan = Plan {
            timeout: Some(MS(40)),
            ..Plan::new(vec![asks(6, 0, 20), second], vec![edge(0, 1), edge(1, 0)])
        };
        let report = run(&plan, conditions);
        assert_complete(&report);
        prop_assert_eq!(report.logs, [from_timer(4, 40, 0, 0), from_timer(6, 40, 0, 0)]);
    }

    #[test]
    fn a_question_goes_round_a_cycle_of_three(conditions in any_conditions(), capacity in 1..3usize) {
        let nodes = vec![asks(10, 0, 30), answers(10), answers(20)];
        let edges = vec![edge(0, 1), edge(1, 2), edge(2, 0)];
        let plan = Plan { timeout: Some(MS(50)), capacity, ..Plan::new(nodes, edges) };
        let report = run(&plan, conditions);
        assert_complete(&report);
        prop_assert_eq!(report.logs, [2, 0, 1].map(|added| from_timer(10, 50, 0, added)));
    }

    /// An answer in one cycle is a question in another one, which the first does not wait for.
    #[test]
    fn two_cycles_are_linked(conditions in any_conditions()) {
        let passes_on = Behavior { relay: true, level: 30, answers: Some((1, 60)), ..timer(15) };
        let nodes = vec![asks(10, 0, 20), answers(10), passes_on, answers(50)];
        let edges = vec![edge(0, 1), edge(1, 0), edge(1, 2), edge(2, 3), edge(3, 2)];
        let plan = Plan { timeout: Some(MS(60)), ..Plan::new(nodes, edges) };
        let report = run(&plan, conditions);
        assert_complete(&report);
        prop_assert_eq!(&report.logs[..2], [from_timer(10, 60, 0, 1), from_timer(10, 60, 0, 0)]);
        // The received value sets the output after the timer does.
        let asked = merged(&[from_timer(10, 60, 0, 2), from_timer(15, 60, 0, 0)]);
        let both = |ms: i64| asked.iter().filter(|entry| entry.0 == ms * 1_000_000).count() == 2;
        let asked: Log = asked
            .iter()
            .filter(|entry| {
                let ms = entry.0 / 1_000_000;
                !both(ms) || entry.3 == u32::try_from(ms / 10).unwrap() + 3
            })
            .copied()
            .collect();
        prop_assert_eq!(&report.logs[3], &asked);
        let answered: Log = asked.iter().map(|(ns, step, _, value)| (*ns, *step, 1, value + 1)).collect();
        prop_assert_eq!(&report.logs[2], &merged(&[from_timer(10, 60, 0, 1), answered]));
    }

    /// A cycle behind a federate that is not in it. With the stock RTI this shape can end in a deadlock.
    #[test]
    fn a_cycle_has_an_upstream_outside(conditions in any_conditions()) {
        // 1 passes on what 0 sends, and looks at the answer of 2, which has a timer of its own, afterwards.
        let first = Behavior { relay: true, level: 10, answers: Some((1, 40)), ..Behavior::default() };
        let second = Behavior { level: 30, relay: true, ..timer(10) };
        let plan = Plan {
            timeout: Some(MS(40)),
            ..Plan::new(vec![timer(5), first, second], vec![edge(0, 1), edge(2, 1), edge(1, 2)])
        };
        let report = run(&plan, conditions);
        assert_complete(&report);
        prop_assert_eq!(&report.logs[2], &from_timer(5, 40, 0, 1));
        prop_assert_eq!(&report.logs[1], &merged(&[from_timer(5, 40, 0, 0), from_timer(5, 40, 1, 2)]));
    }

    /// A federate sends into a cycle by a physical action, which never occurs or occurs now and then, and begins late.
    /// The others wait for physical time to pass it at each tag, and for nothing else.
    #[test]
    fn a_cycle_goes_on_beside_a_physical_action(conditions in any_conditions(), begins in 0..200i64, occurs: bool) {
        let first = if occurs { MS(3) } else { MS(10_000) };
        let button = Behavior { physical: true, timer: Some((first, MS(20))), ..Behavior::default() };
        let mut plan = ping_pong();
        plan.nodes.push(button);
        plan.edges.push(edge(2, 1));
        plan.begins.insert(2, MS(begins));
        // A thread could make it occur.
        plan.keepalive = true;
        let report = run(&plan, conditions);
        assert_complete(&report);
        let of_timer = |log: &Log, input: usize| log.iter().filter(|it| it.2 == input).copied().collect::<Log>();
        prop_assert_eq!(of_timer(&report.logs[1], 0), from_timer(10, 60, 0, 0));
        let answers = report.logs[0].iter().filter(|it| it.0 % 10_000_000 == 0).count();
        prop_assert_eq!(answers, 7, "{:?}", report.logs[0]);
        prop_assert_eq!(of_timer(&report.logs[1], 1).is_empty(), !occurs);
    }

    #[test]
    fn a_stop_inside_a_cycle_is_at_one_tag(conditions in any_conditions(), who in 0..2usize) {
        let mut plan = ping_pong();
        plan.timeout = None;
        plan.nodes[1].timer = Some((MS(5), MS(10)));
        plan.nodes[who].stop_at = Some(3);
        let report = run(&plan, conditions);
        assert_complete(&report);
        prop_assert_eq!(&report.shut_down, &[true; 2]);
        let tags = |log: &Log, values: u32| log.iter().filter(|entry| entry.3 % 2 == values % 2).count();
        prop_assert!(tags(&report.logs[0], 0) > 0 && tags(&report.logs[1], 1) > 0);
        // All that was asked was answered, and nothing after the end.
        let questions: Vec<_> = report.logs[1].iter().map(|entry| (entry.0, entry.1)).collect();
        let answered: Vec<_> = report.logs[0].iter().map(|entry| (entry.0, entry.1)).collect();
        prop_assert!(questions.iter().all(|tag| answered.contains(tag)), "{questions:?} {answered:?}");
    }

    /// No federate waits for one that has left.
    #[test]
    fn a_departure_inside_a_cycle_frees_the_others(
        conditions in any_conditions(),
        who in 0..3u16,
        at in 1500..1600i64,
        interrupted: bool,
    ) {
        let nodes = vec![asks(10, 0, 30), answers(10), answers(20)];
        let edges = vec![edge(0, 1), edge(1, 2), edge(2, 0)];
        let mut plan = Plan { timeout: Some(MS(1000)), ..Plan::new(nodes, edges) };
        let fault = if interrupted { Fault::Interrupt } else { Fault::Kill };
        plan.faults.push((MS(at), usize::from(who) + 1, fault));
        let report = run(&plan, conditions);
        prop_assert_eq!(report.violation, None);
        for other in (0..3).filter(|other| *other != usize::from(who)) {
            prop_assert_eq!(&report.results[other], &Ok(()));
            prop_assert!(report.shut_down[other]);
        }
        // Values were seen in order, each question at most once.
        let whole = [2, 0, 1].map(|added| from_timer(10, 1000, 0, added));
        for (log, whole) in report.logs.iter().zip(whole) {
            prop_assert_eq!(&log[..], &whole[..log.len()]);
        }
    }

    /// Others wait for it at a tag, and still for each other, as they are in a cycle without it, too.
    #[test]
    fn a_departure_frees_what_is_left_of_a_cycle(
        conditions in any_conditions(),
        at in 1500..1600i64,
        interrupted: bool,
    ) {
        let nodes = vec![asks(10, 0, 30), answers(10), answers(20)];
        let edges = vec![edge(0, 1), edge(1, 2), edge(2, 0), edge(0, 2)];
        let mut plan = Plan { timeout: Some(MS(1000)), ..Plan::new(nodes, edges) };
        let fault = if interrupted { Fault::Interrupt } else { Fault::Kill };
        plan.faults.push((MS(at), 2, fault));
        let report = run(&plan, conditions);
        prop_assert_eq!(report.violation, None);
        for other in [0, 2] {
            prop_assert_eq!(&report.results[other], &Ok(()));
            prop_assert!(report.shut_down[other]);
        }
    }

    /// Physical actions in a cycle: the tags are those of their time, and all see them at the same ones.
    #[test]
    fn physical_actions_are_asked_and_answered(conditions in any_conditions(), both: bool) {
        let mut plan = ping_pong();
        plan.nodes[0].physical = true;
        plan.nodes[1].physical = both;
        if both {
            plan.nodes[1].timer = Some((MS(3), MS(20)));
        }
        let report = run(&plan, conditions);
        assert_complete(&report);
        // A federate that answers sets the output once at a tag, by the question if there is one.
        let tags = |log: &Log| log.iter().map(|entry| (entry.0, entry.1)).collect::<Vec<_>>();
        let (answers, questions) = (tags(&report.logs[0]), tags(&report.logs[1]));
        prop_assert!(!questions.is_empty());
        prop_assert!(questions.iter().all(|tag| answers.contains(tag)), "{questions:?} {answers:?}");
        prop_assert!(both || answers.len() == questions.len(), "{questions:?} {answers:?}");
        for (ns, step, _, value) in &report.logs[1] {
            prop_assert!(report.logs[0].contains(&(*ns, *step, 0, value + 1)));
        }
    }
}
