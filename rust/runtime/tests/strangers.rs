// SPDX-License-Identifier: Apache-2.0
//! A peer that connects to a federate without being one keeps no other federate from connecting, and none waits
//! forever.

use crate::support::federation::{Edge, INTRUSION, Intruder, Plan, edge, run};
use crate::support::node::Behavior;
use lf_coordination::rti::Outcome;
use lf_model::time::Interval;
use lf_runtime::{Coordination, PeerFault, RunError};
use lf_testkit::messages::encoded;
use lf_testkit::world::Conditions;
use lf_wire::{Message, RejectCode};
use proptest::prelude::*;

const MS: fn(i64) -> Interval = Interval::from_millis;

/// Two senders and a receiver without an RTI between them, with these intruders at the receiver.
fn plan(intruders: Vec<Intruder>) -> Plan {
    let sender = Behavior { timer: Some((Interval::ZERO, MS(10))), ..Behavior::default() };
    let waits = (Interval::FOREVER, Interval::ZERO);
    let edge = |from| Edge { waits, ..edge(from, 2) };
    Plan {
        coordination: Coordination::Decentralized,
        timeout: Some(MS(95)),
        // The intruders come first.
        begins: [(0, MS(400)), (1, MS(500))].into(),
        intruders,
        ..Plan::new(vec![sender, sender, Behavior::default()], vec![edge(0), edge(1)])
    }
}

fn introduction(federate: u16) -> Vec<u8> {
    encoded(&Message::P2pSendingFedId { federate, is_transient: Some(false), federation_id: b"virtual" })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// More idle connections than there are slots, some of which have begun their introduction: they are evicted.
    #[test]
    fn idle_connections_make_way(seed: u64, connections in 1..12usize, says in 0..5usize) {
        let says = introduction(0)[..says].to_vec();
        let report = run(&plan(vec![Intruder { to: Some(2), connections, says }]), Conditions::seeded(seed));
        prop_assert_eq!(report.violation, None);
        prop_assert!(report.results.iter().all(Result::is_ok), "{:?}", report.results);
        prop_assert_eq!(report.outcome, Some(Ok(Outcome::Complete)));
        prop_assert_eq!(report.logs[2].len(), 20);
        prop_assert!(report.ended.iter().all(|ended| *ended < MS(15_000)), "{:?}", report.ended);
    }

    /// A program that connects first in the name of a federate cannot be told from that federate, as long as
    /// connections between federates are not authenticated: then the true one logs why it cannot go on, and all end.
    #[test]
    fn a_peer_that_takes_the_place_of_a_federate_is_noticed(seed: u64) {
        let intruder = Intruder { to: Some(2), connections: 1, says: introduction(1) };
        let report = run(&plan(vec![intruder]), Conditions::seeded(seed));
        prop_assert_eq!(report.violation, None);
        let refused = RunError::Peer { federate: 2, fault: PeerFault::Refuses(RejectCode::IdInUse) };
        prop_assert_eq!(report.results[1], Err(refused));
        prop_assert!(report.results.iter().all(Result::is_err), "{:?}", report.results);
        prop_assert!(report.ended.iter().all(|ended| *ended < INTRUSION), "{:?}", report.ended);
    }
}
