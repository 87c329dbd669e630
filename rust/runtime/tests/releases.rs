// SPDX-License-Identifier: Apache-2.0
//! A federate finds the form in which a receiver of either release of LF takes its introduction.

use crate::support::federation::{Plan, RTI, edge, run_with};
use crate::support::node::Behavior;
use lf_model::time::Interval;
use lf_runtime::Coordination;
use lf_runtime::platform::{Platform as _, SocketId};
use lf_testkit::network::octets_of;
use lf_testkit::world::Blocking;
use lf_wire::{Message, MessageType, RejectCode};

const ID: &[u8] = b"virtual";
/// Where the receiver listens.
const PEER_PORT: u16 = 4711;

/// Takes introductions as a receiver does whose header has this many bytes, the last of which is the length of the
/// federation id. Returns the number of introductions until one was right.
fn receive(tester: &mut Blocking, rti: SocketId, header_bytes: usize) -> usize {
    let listener = tester.platform.listen(PEER_PORT).unwrap();
    for attempt in 1.. {
        assert_eq!(tester.hear(rti, 4), [MessageType::AddressQuery.byte(), 1, 0, 0]);
        tester.say(rti, &Message::AddressQueryReply { port: PEER_PORT.into(), address: octets_of(RTI) });
        let peer = tester.accept(listener);
        let header = tester.hear(peer, header_bytes);
        let length = usize::from(header[header_bytes - 1]);
        if tester.hear(peer, length) == ID {
            tester.say(peer, &Message::Ack);
            return attempt;
        }
        tester.say(peer, &Message::Reject(RejectCode::FederationIdMismatch));
        tester.platform.close(peer);
    }
    unreachable!("it tries again until it is over")
}

/// Returns the number of introductions to such a receiver before a federate tells the RTI that it is ready.
fn attempts(header_bytes: usize) -> usize {
    let nodes = vec![Behavior::default(); 2];
    let coordination = Coordination::Decentralized;
    let plan = Plan { coordination, trials: 1, keepalive: true, ..Plan::new(nodes, vec![edge(0, 1)]) };
    let act = |tester: &mut Blocking, rti| {
        tester.say(rti, &Message::Ack);
        // FED_IDS, NEIGHBOR_STRUCTURE without neighbors, UDP_PORT.
        tester.hear(rti, 4 + ID.len() + 9 + 3);
        let now = tester.now().as_nanos();
        tester.say(rti, &Message::T1(now));
        tester.hear(rti, MessageType::T3.fixed_bytes());
        tester.say(rti, &Message::T4(now));
        let attempts = receive(tester, rti, header_bytes);
        assert_eq!(tester.hear(rti, MessageType::Timestamp.fixed_bytes())[0], MessageType::Timestamp.byte());
        tester.platform.close(rti);
        attempts
    };
    run_with::<2, _>(&plan, 0, Interval::ZERO, act).1
}

#[test]
fn a_receiver_of_lf_0_13_takes_the_first_introduction_and_one_of_lf_0_12_the_second() {
    assert_eq!([5, 4].map(attempts), [1, 2]);
}
