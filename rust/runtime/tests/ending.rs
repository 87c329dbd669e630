// SPDX-License-Identifier: Apache-2.0
//! Federates and RTI begin and end, in order and otherwise: always within bounded time, with a reason, and with the
//! knowledge of the others.

use std::collections::BTreeSet;
use std::time::Duration;

use crate::support::federation::{Edge, Plan, RTI, Report, edge, run};
use crate::support::node::Behavior;
use lf_coordination::FederateId;
use lf_coordination::federate::{FederateError, Phase};
use lf_coordination::rti::{AfterLoss, Cause, Outcome};
use lf_model::time::{EventTag, Interval};
use lf_runtime::RunError;
use lf_runtime::platform::NetError;
use lf_testkit::network::address_of;
use lf_testkit::world::{Conditions, Fault};
use lf_wire::RejectCode;
use proptest::prelude::*;

const MS: fn(i64) -> Interval = Interval::from_millis;
/// The RTI's start delay and the time for the handshakes, roughly.
const START: i64 = 1_050;
/// Longer than any of the times that federates and RTI give their peers at the end.
const FINAL_SEND_TIME_OUT: i64 = 3_000;

fn timer(period: i64) -> Behavior {
    Behavior { timer: Some((Interval::ZERO, MS(period))), ..Behavior::default() }
}

/// Returns a sender, a relay and a receiver, without an end of their own.
fn endless() -> Plan {
    let relay = Behavior { relay: true, ..Behavior::default() };
    Plan::new(vec![timer(10), relay, Behavior::default()], vec![edge(0, 1), edge(1, 2)])
}

fn assert_complete(report: &Report) {
    assert_eq!(report.violation, None, "{:?}", report.results);
    assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
    assert_eq!(report.outcome, Some(Ok(Outcome::Complete)));
    assert!(report.shut_down.iter().all(|shut_down| *shut_down));
}

fn cause(error: &Result<(), RunError>) -> Option<FederateError> {
    match error {
        Err(RunError::Federate(error)) => Some(*error),
        _ => None,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn a_time_out_ends_all(seed: u64, pipe_bytes in 10usize..100, fast: bool) {
        let plan = Plan { timeout: Some(MS(35)), fast, ..endless() };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_complete(&report);
        prop_assert_eq!(report.logs[2].len(), 4);
    }

    /// All run their shutdown reactions, whichever federate asks.
    #[test]
    fn a_stop_ends_all(seed: u64, pipe_bytes in 10usize..100, capacity in 1usize..=2, fast: bool) {
        let mut plan = Plan { capacity, fast, ..endless() };
        plan.nodes[0].stop_at = Some(7);
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_complete(&report);
        prop_assert_eq!(report.logs[2].len(), 7);
    }

    /// With authentication all goes on as without.
    #[test]
    fn a_federate_that_authenticates_is_accepted(seed: u64, pipe_bytes in 10usize..100) {
        let plan = Plan { authentication: true, timeout: Some(MS(35)), ..endless() };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        assert_complete(&report);
        prop_assert_eq!(report.logs[2].len(), 4);
    }

    /// One that authenticates alone, one that alone does not, or one with another key learns why it cannot join.
    #[test]
    fn a_federate_with_another_key_is_rejected(seed: u64, pipe_bytes in 10usize..100, authentication: bool, key: bool) {
        let mut plan = Plan { authentication, faults: vec![(MS(START), RTI, Fault::Interrupt)], ..endless() };
        let expected = match (authentication, key) {
            (true, true) => FederateError::RtiNotAuthentic,
            (true, false) => FederateError::Rejected(RejectCode::UnexpectedMessage),
            (false, true) => FederateError::Rejected(RejectCode::FederationIdMismatch),
            (false, false) => FederateError::Rejected(RejectCode::NotInAuthenticationMode),
        };
        if key { &mut plan.strangers } else { &mut plan.otherwise }.insert(1);
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        prop_assert_eq!(report.violation, None);
        prop_assert_eq!(cause(&report.results[1]), Some(expected));
        prop_assert!(report.ended[1] < MS(START));
    }

    /// A stop also ends those whose queues are full of messages for after it.
    #[test]
    fn a_stop_ends_full_queues(seed: u64, capacity in prop_oneof![Just(1usize), Just(2)]) {
        let edges = vec![Edge { delay: Some(MS(500)), ..edge(0, 1) }];
        let sender = Behavior { stop_at: Some(12), ..timer(10) };
        let plan = Plan { capacity, spare_bytes: 4096, ..Plan::new(vec![sender, Behavior::default()], edges) };
        let report = run(&plan, Conditions::seeded(seed));
        assert_complete(&report);
        prop_assert_eq!(&report.logs[1], &[]);
    }

    /// A federate without events and without a source of events ends; and then those downstream. Its messages at its
    /// end are never late.
    #[test]
    fn those_without_events_end(seed: u64, farewell: bool) {
        let once = Behavior { timer: Some((MS(5), Interval::ZERO)), farewell, ..Behavior::default() };
        let relay = Behavior { relay: true, farewell, ..Behavior::default() };
        let busy = Behavior { timer: Some((Interval::ZERO, MS(3))), ..Behavior::default() };
        let edges = vec![edge(0, 1), edge(1, 2), edge(1, 3)];
        let plan = Plan::new(vec![once, relay, Behavior::default(), busy], edges);
        // The last one never ends by itself.
        let plan = Plan { faults: vec![(MS(START + 100), 4, Fault::Interrupt)], ..plan };
        let report = run(&plan, Conditions::seeded(seed));
        prop_assert_eq!(report.violation, None);
        for result in &report.results[..3] {
            prop_assert_eq!(result, &Ok(()));
        }
        prop_assert_eq!(&report.results[3], &Err(RunError::Interrupted));
        prop_assert_eq!(report.logs[2].first(), Some(&(5_000_000, 0, 0, 2)));
    }

    /// The RTI ends without a word: every federate ends within bounded time, and says so.
    #[test]
    fn a_lost_rti_ends_all(seed: u64, at in 300..2_000i64, capacity in prop_oneof![Just(1usize), Just(2)]) {
        let plan = Plan { capacity, faults: vec![(MS(at), RTI, Fault::Kill)], ..endless() };
        let report = run(&plan, Conditions::seeded(seed));
        prop_assert_eq!(report.violation, None);
        for (result, ended) in report.results.iter().zip(&report.ended) {
            let lost = matches!(cause(result), Some(FederateError::RtiLost { .. }));
            let never_there = matches!(result, Err(RunError::RtiUnreachable { .. }));
            prop_assert!(lost || never_there, "{:?}", result);
            let limit = if lost { at + FINAL_SEND_TIME_OUT } else { 61_000 };
            prop_assert!(*ended <= MS(limit), "{:?} {:?}", result, ended);
        }
    }

    /// A federate ends without a word: the others are stopped.
    #[test]
    fn a_lost_federate_stops_the_others(seed: u64, who in 0..3usize, capacity in prop_oneof![Just(1usize), Just(2)]) {
        let faults = vec![(MS(START + 200), 1 + who, Fault::Kill)];
        let plan = Plan { capacity, faults, after_loss: AfterLoss::StopAll, ..endless() };
        let report = run(&plan, Conditions::seeded(seed));
        prop_assert_eq!(report.violation, None);
        let federate = FederateId(u16::try_from(who).unwrap());
        let lost = Outcome::Lost { federate, cause: Cause::ConnectionLost };
        prop_assert_eq!(&report.outcome, &Some(Ok(lost)));
        for (index, result) in report.results.iter().enumerate().filter(|(index, _)| *index != who) {
            prop_assert_eq!(cause(result), Some(FederateError::RtiFailed), "{}: {:?}", index, result);
            prop_assert!(report.ended[index] <= MS(START + 200 + FINAL_SEND_TIME_OUT));
        }
    }

    /// The same, but the others go on: those downstream of it come to their end, for nothing can come any more.
    #[test]
    fn the_others_can_go_on(seed: u64, capacity in prop_oneof![Just(1usize), Just(2)]) {
        let faults = vec![(MS(START + 200), 1, Fault::Kill)];
        let plan = Plan { capacity, faults, after_loss: AfterLoss::GoOn, ..endless() };
        let report = run(&plan, Conditions::seeded(seed));
        prop_assert_eq!(report.violation, None);
        prop_assert_eq!(&report.results[1..], &[Ok(()), Ok(())]);
        let lost = Outcome::Lost { federate: FederateId(0), cause: Cause::ConnectionLost };
        prop_assert_eq!(&report.outcome, &Some(Ok(lost)));
        // Every message to the relay came through.
        prop_assert_eq!(report.logs[1].len(), report.logs[2].len());
    }

    /// ^C at any time: Interrupted, soon; and the RTI knows it from the federate itself.
    #[test]
    fn an_interrupted_federate_tells_the_rti(seed: u64, at in 0..2_000i64, who in 0..3usize) {
        let faults = vec![(MS(at), 1 + who, Fault::Interrupt), (MS(20_000), RTI, Fault::Interrupt)];
        let plan = Plan { faults, after_loss: AfterLoss::StopAll, ..endless() };
        let report = run(&plan, Conditions::seeded(seed));
        prop_assert_eq!(report.violation, None);
        prop_assert_eq!(&report.results[who], &Err(RunError::Interrupted));
        prop_assert!(report.ended[who] <= MS(at + FINAL_SEND_TIME_OUT));
        if at > START + 200 {
            let federate = FederateId(u16::try_from(who).unwrap());
            prop_assert_eq!(&report.outcome, &Some(Ok(Outcome::Lost { federate, cause: Cause::Failed })));
        }
        for result in report.results.iter().enumerate().filter(|(index, _)| *index != who).map(|(_, result)| result) {
            prop_assert_eq!(cause(result), Some(FederateError::RtiFailed));
        }
    }

    /// ^C of the RTI: all federates hear of it as its last words, whatever they were doing.
    #[test]
    fn an_interrupted_rti_tells_the_federates(seed: u64, at in 0..500i64, pipe_bytes in 10usize..100) {
        let plan = Plan { faults: vec![(MS(START + at), RTI, Fault::Interrupt)], ..endless() };
        let report = run(&plan, Conditions { pipe_bytes, ..Conditions::seeded(seed) });
        prop_assert_eq!(report.violation, None);
        prop_assert_eq!(&report.outcome, &Some(Ok(Outcome::Aborted)));
        for (result, ended) in report.results.iter().zip(&report.ended) {
            prop_assert_eq!(cause(result), Some(FederateError::RtiFailed));
            prop_assert!(*ended <= MS(START + at + FINAL_SEND_TIME_OUT));
        }
    }

    /// RTI and federates may begin in any order, within the connect time-out.
    #[test]
    fn the_start_waits_for_a_federate_that_comes_late(seed: u64, rti in 0..5_000i64, last in 0..8_000i64) {
        let mut plan = Plan { timeout: Some(MS(35)), rti_begins: Some(MS(rti)), ..endless() };
        plan.begins.insert(2, MS(last));
        let report = run(&plan, Conditions::seeded(seed));
        assert_complete(&report);
        prop_assert_eq!(report.logs[2].len(), 4);
    }
}

#[test]
fn without_an_rti_a_federate_gives_up() {
    let plan = Plan { rti_begins: None, ..endless() };
    let report = run(&plan, Conditions::seeded(1));
    for (result, ended) in report.results.iter().zip(&report.ended) {
        assert!(matches!(result, Err(RunError::RtiUnreachable { last: Some(NetError::Refused), .. })), "{result:?}");
        assert!(*ended >= MS(60_000) && *ended <= MS(61_000));
        assert!(result.as_ref().unwrap_err().to_string().contains("start the RTI"));
    }
    assert_eq!(report.violation, None);
}

/// The rejected one learns the reason, and the RTI waits for the right one. No host has the address, so no attempt to
/// connect is answered.
#[test]
fn without_an_answer_a_federate_gives_up() {
    let plan = Plan { rti_begins: None, rti: address_of(200), ..endless() };
    let report = run(&plan, Conditions::seeded(1));
    for (result, ended) in report.results.iter().zip(&report.ended) {
        assert!(matches!(result, Err(RunError::RtiUnreachable { last: None, .. })), "{result:?}");
        assert!(*ended >= MS(60_000) && *ended <= MS(61_000));
    }
    assert_eq!(report.violation, None);
}

#[test]
fn a_stranger_is_told_why_it_is_refused() {
    for seed in 0..20 {
        let faults = vec![(MS(3_000), RTI, Fault::Interrupt)];
        let plan = Plan { strangers: BTreeSet::from([1]), faults, ..endless() };
        let report = run(&plan, Conditions::seeded(seed));
        assert_eq!(report.violation, None);
        assert!(matches!(cause(&report.results[1]), Some(FederateError::Rejected(_))), "{:?}", report.results);
        assert!(report.results[1].as_ref().unwrap_err().to_string().contains("same federation id"));
        assert!(report.ended[1] <= MS(FINAL_SEND_TIME_OUT));
        for other in [0, 2] {
            assert_eq!(cause(&report.results[other]), Some(FederateError::RtiFailed));
        }
    }
}

/// A federation runs the same way each time it is run with the same seed.
#[test]
fn a_seed_replays_a_run() {
    let faults = vec![(MS(START + 77), 2, Fault::Kill)];
    let plan = Plan { faults, after_loss: AfterLoss::StopAll, ..endless() };
    assert_eq!(run(&plan, Conditions::seeded(5)), run(&plan, Conditions::seeded(5)));
}

/// The phases have names in the sentence that is said.
#[test]
fn the_reason_is_a_sentence() {
    let error = RunError::Federate(FederateError::RtiLost { phase: Phase::Running });
    assert!(error.to_string().contains("while this federate was running"));
    assert!(RunError::InputFull { input: "a.x -> b.y" }.to_string().contains("a.x -> b.y"));
    let at = |ms| EventTag::new(Duration::from_millis(ms), 0);
    let late = RunError::Late { input: "a.x -> b.y", tag: at(20), current: at(30) }.to_string();
    assert!(late.contains("a.x -> b.y") && late.contains("20 ms") && late.contains("30 ms"), "{late}");
}

/// When the RTI's computer has no memory left for a message, whose it was or to whom it was to go is lost, and said to
/// be; what belongs behind that message does not come without it.
#[test]
fn a_message_that_there_is_no_memory_for_costs_one_federate() {
    // A tagged message has 25 bytes here, and nothing else that matters has more than 24.
    for (rti_memory, lost) in [((24, 100), 0), ((100, 24), 1)] {
        let pair = Plan::new(vec![timer(10), Behavior::default()], vec![edge(0, 1)]);
        let plan = Plan { rti_memory, after_loss: AfterLoss::StopAll, ..pair };
        let report = run(&plan, Conditions::seeded(1));
        assert_eq!(report.violation, None, "{:?}", report.results);
        let cause = Cause::NoMemory { bytes: 25 };
        assert_eq!(report.outcome, Some(Ok(Outcome::Lost { federate: FederateId(lost), cause })));
        assert!(report.results.iter().all(Result::is_err), "{:?}", report.results);
        assert_eq!(report.logs[1], Vec::new());
    }
}
