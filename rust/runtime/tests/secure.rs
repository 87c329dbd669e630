// SPDX-License-Identifier: Apache-2.0
//! Federations whose connections are encrypted, in virtual time: they do the same as without, and strangers, thieves
//! and ends without keys get nowhere.

use crate::support::federation::{Edge, INTRUSION, Intruder, Plan, RTI, Report, edge, run};
use crate::support::node::Behavior;
use lf_coordination::federate::FederateError;
use lf_coordination::rti::Outcome;
use lf_model::time::Interval;
use lf_runtime::{Coordination, RunError};
use lf_secure::MARK;
use lf_testkit::messages::encoded;
use lf_testkit::world::{Conditions, Fault};
use lf_wire::{Message, RejectCode};
use proptest::prelude::*;

const MS: fn(i64) -> Interval = Interval::from_millis;

/// Returns a chain of a sender, a relay and a receiver.
fn chain() -> Plan {
    let sender = Behavior { timer: Some((Interval::ZERO, MS(10))), ..Behavior::default() };
    let relay = Behavior { relay: true, ..Behavior::default() };
    let delayed = Edge { delay: Some(MS(3)), ..edge(1, 2) };
    let plan = Plan::new(vec![sender, relay, Behavior::default()], vec![edge(0, 1), delayed]);
    Plan { timeout: Some(MS(95)), ..plan }
}

/// Returns the same without an RTI in between.
fn direct_chain() -> Plan {
    let mut plan = Plan { coordination: Coordination::Decentralized, ..chain() };
    plan.edges.iter_mut().for_each(|edge| edge.waits = (Interval::FOREVER, Interval::ZERO));
    plan
}

/// Returns the plan in which all participants are asked to end after a while, because some wait for one that cannot
/// come.
fn ended(plan: Plan) -> Plan {
    let faults = (0..=plan.nodes.len()).map(|participant| (MS(20_000), participant, Fault::Interrupt)).collect();
    Plan { faults, ..plan }
}

/// Returns the plan with keys for each participant.
fn encrypted(plan: Plan) -> Plan {
    Plan { keys: (0..=plan.nodes.len()).map(|participant| (participant, participant)).collect(), ..plan }
}

fn assert_complete(report: &Report) {
    assert_eq!(report.violation, None, "{:?}", report.results);
    assert!(report.results.iter().all(Result::is_ok), "{:?} {:?}", report.results, report.lines);
    assert_eq!(report.outcome, Some(Ok(Outcome::Complete)));
}

fn has_line(report: &Report, participant: usize, parts: &[&str]) -> bool {
    report.lines[participant].iter().any(|line| parts.iter().all(|part| line.contains(part)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Encryption changes nothing that a program sees, in pipes of any size.
    #[test]
    fn an_encrypted_federation_does_what_a_plain_one_does(seed: u64, pipe_bytes in 60usize..400) {
        for plan in [chain(), direct_chain()] {
            let conditions = Conditions { pipe_bytes, ..Conditions::seeded(seed) };
            let (plain, report) = (run(&plan, conditions), run(&encrypted(plan.clone()), conditions));
            assert_complete(&plain);
            assert_complete(&report);
            let values = |report: &Report| report.logs[2].iter().map(|(.., value)| *value).collect::<Vec<_>>();
            prop_assert_eq!(values(&plain), values(&report));
            prop_assert!(!values(&report).is_empty());
        }
    }

    /// A federate without keys is refused, and both ends say why.
    #[test]
    fn a_federate_that_does_not_encrypt_is_refused(seed: u64) {
        let mut plan = ended(encrypted(chain()));
        plan.keys.remove(&1);
        let report = run(&plan, Conditions::seeded(seed));
        prop_assert_eq!(report.violation, None);
        let refused = RunError::Federate(FederateError::Rejected(RejectCode::Insecure));
        prop_assert_eq!(report.results[0], Err(refused));
        prop_assert!(refused.to_string().contains("give this end its keys"), "{}", refused);
        prop_assert!(report.log_events.iter().all(|event| !event.contains("federate 0 has joined")));
    }

    /// A federate with keys does not speak with an RTI that has none, and both say why.
    #[test]
    fn an_rti_that_does_not_encrypt_is_refused(seed: u64) {
        let mut plan = ended(encrypted(chain()));
        plan.keys.remove(&RTI);
        let report = run(&plan, Conditions::seeded(seed));
        prop_assert_eq!(report.violation, None);
        for federate in 0..3 {
            prop_assert_eq!(report.results[federate], Err(RunError::Interrupted));
            prop_assert!(has_line(&report, federate, &["not secure", "does not encrypt"]), "{:?}", report.lines);
        }
        prop_assert!(report.log_events.iter().any(|event| event.contains("the other end encrypts")));
    }

    /// A board whose keys were stolen is only itself: the RTI refuses it as another federate, and the true one joins.
    #[test]
    fn a_stolen_key_does_not_join_as_another_federate(seed: u64) {
        let mut plan = ended(encrypted(chain()));
        // Federate 1 claims to be federate 0, with its own key.
        plan.same_id = [(1, 0)].into();
        let report = run(&plan, Conditions::seeded(seed));
        let refused = RunError::Federate(FederateError::Rejected(RejectCode::Insecure));
        prop_assert_eq!(report.results[1], Err(refused));
        prop_assert!(report.log_events.iter().any(|event| event.contains("claimed to be federate 0, which it is not")));
        prop_assert!(report.log_events.iter().any(|event| event.contains("federate 0 has joined")));
    }

    /// A federate that has the keys of another one cannot be the receiver of direct connections.
    #[test]
    fn a_federate_with_the_key_of_another_one_is_no_receiver(seed: u64) {
        let mut plan = ended(encrypted(direct_chain()));
        plan.keys.insert(3, 1);
        let report = run(&plan, Conditions::seeded(seed));
        prop_assert!(report.results.iter().all(Result::is_err), "{:?}", report.results);
        prop_assert!(report.log_events.iter().any(|event| event.contains("claimed to be federate 2, which it is not")));
    }

    /// More connections than there are slots, at the RTI or at a federate, with handshakes that nobody finishes: they
    /// make way.
    #[test]
    fn unfinished_handshakes_make_way(seed: u64, connections in 1..12usize, begun in 0..5usize, to_rti: bool) {
        let first = [&[MARK, 1, 0, 48][..], &[0x5A; 48]].concat();
        let says = first[..[0, 1, 4, 30, first.len()][begun]].to_vec();
        let intruder = Intruder { to: (!to_rti).then_some(2), connections, says };
        let begins = [(0, MS(400)), (1, MS(500))].into();
        let plan = Plan { intruders: vec![intruder], begins, ..encrypted(direct_chain()) };
        let report = run(&plan, Conditions::seeded(seed));
        assert_complete(&report);
        prop_assert!(report.ended.iter().all(|ended| *ended < MS(15_000)), "{:?}", report.ended);
    }

    /// A program in the name of a federate is refused, and keeps nobody out.
    #[test]
    fn a_stranger_in_the_name_of_a_federate_keeps_nobody_out(seed: u64, connections in 1..4usize) {
        let (is_transient, federation_id) = (Some(false), &b"virtual"[..]);
        let says = encoded(&Message::P2pSendingFedId { federate: 1, is_transient, federation_id });
        let intruder = Intruder { to: Some(2), connections, says };
        let begins = [(0, MS(400)), (1, MS(500))].into();
        let plan = Plan { intruders: vec![intruder], begins, ..encrypted(direct_chain()) };
        let report = run(&plan, Conditions::seeded(seed));
        assert_complete(&report);
        prop_assert!(report.ended.iter().all(|ended| *ended < INTRUSION), "{:?}", report.ended);
        prop_assert!(has_line(&report, 2, &["not secure", "does not encrypt"]), "{:?}", report.lines);
    }
}
