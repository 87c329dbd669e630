// SPDX-License-Identifier: Apache-2.0
//! A participant that waits logs what it waits for: before the start in any case, and while the federation runs if the
//! program asks for it.

use crate::support::federation::{Edge, Intruder, Plan, RTI, Report, edge, run};
use crate::support::node::Behavior;
use lf_coordination::federate::FederateError;
use lf_coordination::rti::AfterLoss;
use lf_model::time::Interval;
use lf_runtime::{Coordination, RunError};
use lf_testkit::network::address_of;
use lf_testkit::world::{Conditions, Fault};
use lf_wire::{Message, RejectCode};

const MS: fn(i64) -> Interval = Interval::from_millis;

fn awaited(from: u16, to: u16) -> Edge {
    Edge { waits: (Interval::FOREVER, Interval::ZERO), ..edge(from, to) }
}

/// Returns a sender and a receiver, which has a timer of its own.
fn pair(sender: Behavior) -> Plan {
    let receiver = Behavior { timer: Some((Interval::ZERO, MS(10))), ..Behavior::default() };
    Plan { timeout: Some(MS(3_000)), ..Plan::new(vec![sender, receiver], vec![awaited(0, 1)]) }
}

fn sender() -> Behavior {
    Behavior { timer: Some((Interval::ZERO, MS(10))), ..Behavior::default() }
}

/// Returns which participant has logged something that begins and ends like this.
fn says(lines: &[String], begin: &str, end: &str) -> bool {
    lines.iter().any(|line| line.starts_with(begin) && line.ends_with(end))
}

fn assert_says(lines: &[String], begin: &str, end: &str) {
    assert!(says(lines, begin, end), "{lines:#?}");
}

fn assert_ends(report: &Report) {
    assert_eq!(report.violation, None, "{:?}", report.results);
}

#[test]
fn a_federate_without_an_rti_says_so_before_it_gives_up() {
    let plan = Plan { rti_begins: Some(Interval::from_secs(12)), ..pair(sender()) };
    let report = run(&plan, Conditions::seeded(1));
    assert_ends(&report);
    let advice = " ms: start one with `lfz rti -n FEDERATES -i FEDERATION`, or correct the address";
    assert_says(&report.lines[0], "waiting for an RTI that answers at 10.0.0.1:15045 (", advice);
    assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
}

/// A stranger claims the id of a federate; when the RTI has closed its connection, the federate takes part.
#[test]
fn a_federate_whose_id_is_taken_asks_again_and_says_so() {
    let mut says = vec![0; 64];
    let ids = Message::FedIds { federate: 1, federation_id: b"virtual" };
    let length = ids.encode(&mut says).unwrap();
    says.truncate(length);
    let stranger = Intruder { to: None, connections: 1, says };
    let plan = Plan { intruders: vec![stranger], begins: [(1, MS(500))].into(), ..pair(sender()) };
    let report = run(&plan, Conditions::seeded(1));
    assert_ends(&report);
    assert_says(&report.lines[1], "waiting for its id, which the RTI says is taken, for ", "cannot come back");
    assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
}

/// Where the id stays taken, that is the error in the end, and not that there is no RTI.
#[test]
fn a_federate_whose_id_stays_taken_ends_with_that_after_a_minute() {
    let (begins, same_id) = ([(1, MS(2_000))].into(), [(1, 0)].into());
    let faults = vec![(MS(70_000), RTI, Fault::Interrupt)];
    let plan = Plan { begins, same_id, faults, ..pair(sender()) };
    let report = run(&plan, Conditions::seeded(1));
    let error = report.results[1].as_ref().unwrap_err();
    assert_eq!(*error, RunError::Federate(FederateError::Rejected(RejectCode::IdInUse)));
    assert!(report.ended[1] >= MS(62_000) && report.ended[1] < MS(64_000), "{:?}", report.ended);
}

/// An address without an answer costs some seconds if there is another one.
#[test]
fn all_addresses_of_the_rti_are_tried() {
    let plan = Plan { rti: address_of(200), others: vec![address_of(201), address_of(RTI)], ..pair(sender()) };
    let report = run(&plan, Conditions::seeded(1));
    assert_ends(&report);
    assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
    assert!(report.ended.iter().all(|ended| *ended < MS(17_000)), "{:?}", report.ended);
}

#[test]
fn the_start_says_who_is_missing_on_both_sides() {
    let plan = Plan { begins: [(1, Interval::from_secs(12))].into(), ..pair(sender()) };
    let report = run(&plan, Conditions::seeded(1));
    assert_ends(&report);
    assert_says(&report.log_events, "the start waits for 1 of 2 federates", "");
    assert_says(&report.log_events, "federate 1 has not connected", "");
    assert_says(&report.lines[0], "waiting for the other federates, of which the RTI says which are missing, for ", "");
    assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
}

#[test]
fn a_federate_that_connects_to_another_one_names_it() {
    let late = [(1, Interval::from_secs(12))].into();
    let plan = Plan { begins: late, coordination: Coordination::Decentralized, ..pair(sender()) };
    let report = run(&plan, Conditions::seeded(1));
    assert_ends(&report);
    assert_says(&report.lines[0], "waiting for federate 1, to which this one sends directly, for ", " ms");
}

/// The sender computes for two seconds at a time: the receiver waits for its grants, and both it and the RTI say so.
#[test]
fn a_wait_for_a_grant_is_told_where_it_is_asked_for() {
    let busy = Behavior { timer: Some((Interval::ZERO, MS(2_000))), work: MS(1_900), ..Behavior::default() };
    let asked = Plan { log_waits: Some(MS(500)), ..pair(busy) };
    let report = run(&asked, Conditions::seeded(1));
    assert_ends(&report);
    assert_says(&report.lines[1], "waiting for the RTI to grant (T0 + ", "ms");
    assert_says(&report.log_events, "federate 1 has been waiting for ", "");
    let report = run(&pair(busy), Conditions::seeded(1));
    assert_ends(&report);
    assert!(!says(&report.lines[1], "waiting for", "") && !says(&report.log_events, "federate 1 has been", ""));
}

#[test]
fn a_wait_for_what_another_federate_sends_names_the_connection() {
    let busy = Behavior { timer: Some((Interval::ZERO, MS(2_000))), work: MS(1_900), ..Behavior::default() };
    let coordination = Coordination::Decentralized;
    let plan = Plan { log_waits: Some(MS(500)), coordination, ..pair(busy) };
    let report = run(&plan, Conditions::seeded(1));
    assert_ends(&report);
    assert_says(&report.lines[1], "waiting for what comes over node.in at (T0 + ", "ms");
}

/// A receiver that computes for long holds its sender up: the RTI names both.
#[test]
fn messages_that_wait_for_their_receiver_are_told() {
    let quick = Behavior { timer: Some((Interval::ZERO, MS(5))), ..Behavior::default() };
    let slow = Behavior { timer: Some((Interval::ZERO, MS(900))), work: MS(800), ..Behavior::default() };
    let plan = Plan {
        log_waits: Some(MS(200)),
        timeout: Some(MS(1_000)),
        after_loss: AfterLoss::StopAll,
        faults: vec![(Interval::from_secs(100), 1, Fault::Interrupt)],
        ..Plan::new(vec![quick, slow], vec![awaited(0, 1)])
    };
    let report = run(&plan, Conditions { pipe_bytes: 100, ..Conditions::seeded(1) });
    assert_ends(&report);
    assert!(
        says(
            &report.log_events,
            "messages of federate 0 have been waiting for ",
            "federate 1 does not take what it is sent"
        ) || says(
            &report.log_events,
            "messages of federate 0 have been waiting for ",
            "federate 1 is too many tags behind"
        ),
        "{:#?}",
        report.log_events
    );
}
