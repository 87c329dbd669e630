// SPDX-License-Identifier: Apache-2.0
//! Dialogues with a federate whose messages go to federates that come and go, or that is transient itself.

use std::net::{Ipv4Addr, Ipv6Addr};

use lf_coordination::federate::{CONNECT_RETRY, Coordination, Event, Phase};
use lf_coordination::{Endpoint, FederateId, IpAddress};
use lf_wire::Message;

use super::{Config, config};
use crate::federate_support::dialogue::{DOWNSTREAM, NOW, UPSTREAM, connected, drain, started};

const REPLY: Message<'static> = Message::AddressQueryReply { port: 4711, address: [127, 0, 0, 1] };

fn query(federate: u16, is_transient: bool) -> Message<'static> {
    Message::AddressQuery { federate, is_transient: Some(is_transient) }
}

fn found(federate: u16) -> Event<'static> {
    Event::PeerFound { federate: FederateId(federate), address: Endpoint::new(Ipv4Addr::LOCALHOST, 4711) }
}

/// Federate 1 between the transient federates 0 and 2. It sends directly to 2, and to 3.
fn direct() -> Config<'static> {
    let coordination = Coordination::Decentralized;
    Config { coordination, peers: &[2, 3], transients: &[0, 2], ..config(UPSTREAM, DOWNSTREAM) }
}

#[test]
fn the_start_waits_for_no_transient_receiver() {
    // It is not there, or cannot be reached.
    for answer in [Message::AddressQueryReply { port: -1, address: [0; 4] }, REPLY] {
        let mut federate = connected(direct());
        federate.handle_message(NOW, Message::Ack).unwrap();
        assert_eq!(drain(&mut federate).last(), Some(&query(2, true)));
        match federate.handle_message(NOW, answer) {
            Ok(Event::None) => {}
            event => {
                assert_eq!(event, Ok(found(2)));
                federate.peer_lost(NOW).unwrap();
            }
        }
        assert_eq!(drain(&mut federate), [query(3, false)]);
        assert_eq!(federate.handle_message(NOW, REPLY), Ok(found(3)));
        federate.peer_connected(NOW);
        assert_eq!(drain(&mut federate), [Message::Timestamp(NOW.as_nanos())]);
    }
}

/// Of the receivers it is the next one that counts, and not the first one.
#[test]
fn the_start_waits_for_a_persistent_receiver_after_a_transient_one() {
    let mut federate = connected(direct());
    federate.handle_message(NOW, Message::Ack).unwrap();
    drain(&mut federate);
    for (index, federate_id) in [(0, 2), (1, 3)] {
        assert_eq!(federate.next_peer_index(), Some(index));
        assert_eq!(federate.handle_message(NOW, REPLY), Ok(found(federate_id)));
        if federate_id == 3 {
            federate.peer_lost(NOW).unwrap();
            assert_eq!((federate.phase(), drain(&mut federate)), (Phase::Meeting, vec![]));
            federate.handle_timeout(NOW + CONNECT_RETRY).unwrap();
            assert_eq!(drain(&mut federate), [query(3, false)]);
            federate.handle_message(NOW, REPLY).unwrap();
        }
        federate.peer_connected(NOW);
        assert_eq!(drain(&mut federate).len(), 1, "a question, or the clock");
    }
    assert_eq!((federate.next_peer_index(), federate.phase()), (None, Phase::Starting));
}

#[test]
fn a_receiver_that_comes_is_looked_for_one_at_a_time() {
    let mut federate = started(Config { peers: &[], ..direct() });
    assert!(federate.find_peer(FederateId(2)) && !federate.find_peer(FederateId(3)));
    assert_eq!(drain(&mut federate), [query(2, true)]);
    assert_eq!(federate.handle_message(NOW, REPLY), Ok(found(2)));
    assert!(!federate.find_peer(FederateId(3)));
    federate.peer_connected(NOW);
    assert!(federate.find_peer(FederateId(3)));
    // It leaves before the answer, which is for nobody then.
    assert_eq!(drain(&mut federate), [query(3, true)]);
    let left = Message::OutboundDisconnected { federate: 3 };
    assert_eq!(federate.handle_message(NOW, left), Ok(Event::PeerLeft(FederateId(3))));
    let unknown = Message::AddressQueryReply { port: -1, address: [0; 4] };
    assert_eq!(federate.handle_message(NOW, unknown), Ok(Event::None));
    assert!(federate.find_peer(FederateId(2)), "one that cannot be reached is looked for again");
    drain(&mut federate);
    federate.handle_message(NOW, REPLY).unwrap();
    federate.peer_lost(NOW).unwrap();
    assert!(federate.find_peer(FederateId(2)));
}

/// Others connect to it, and send it what it needs at its first tag.
#[test]
fn with_decentralized_coordination_a_transient_receiver_begins_later() {
    let coordination = Coordination::Decentralized;
    for (listening, seconds) in [(None, 0), (Some(4711), 1)] {
        let transients = &[1];
        let mut federate = connected(Config { coordination, listening, transients, ..config(UPSTREAM, DOWNSTREAM) });
        federate.handle_message(NOW, Message::Ack).unwrap();
        let clock = Message::Timestamp(NOW.as_nanos() + seconds * 1_000_000_000);
        assert_eq!(drain(&mut federate).last(), Some(&clock));
    }
}

#[test]
fn a_receiver_that_comes_is_found_over_ipv6() {
    let mut federate = started(Config { peers: &[], ..direct() });
    assert!(federate.find_peer(FederateId(2)));
    assert_eq!(drain(&mut federate), [query(2, true)]);
    let far = Ipv6Addr::new(0xfd00, 0, 0, 0, 0, 0, 0, 7);
    let reply = Message::AddressQueryReplyIpv6 { port: 4711, address: far.octets(), scope: 0 };
    let address = Endpoint::new(IpAddress::v6(far, 0), 4711);
    assert_eq!(federate.handle_message(NOW, reply), Ok(Event::PeerFound { federate: FederateId(2), address }));
}
