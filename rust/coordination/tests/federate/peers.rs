// SPDX-License-Identifier: Apache-2.0
//! A federate finds the others to which it sends directly, before the start.

use std::net::{Ipv4Addr, Ipv6Addr};

use super::{Config, Federate, Profile};
use crate::federate_support::dialogue::in_turn;
use lf_coordination::federate::{
    ADDRESS_RETRY, CONNECT_RETRY, CONNECT_TIME_OUT, ClockSync, Event, FederateError, Needs, Phase,
};
use lf_coordination::{Deadline, Endpoint, FederateId, IpAddress};
use lf_model::time::{Instant, Interval};
use lf_testkit::golden::Step;
use lf_testkit::messages::encoded;
use lf_wire::{ADDRESS_PORT_UNKNOWN, Decoded, Limits, Message, RejectCode, UDP_PORT_CLOCK_SYNC_OFF, decode};

const NOW: Instant = Instant::from_nanos(1_000_000);
const IN_TURN: &[Message<'static>] = in_turn::<Profile>();
const HERE: [u8; 4] = [127, 0, 0, 1];
const MS: Interval = Interval::from_millis(1);

fn federate(listening: Option<u16>, peers: &'static [u16]) -> Federate<'static> {
    let clock_sync = ClockSync::Off;
    let config = Config { listening, peers, clock_sync, ..Config::with_needs(FederateId(0), b"federation") };
    let mut federate = Federate::new(config).unwrap();
    federate.handle_connected(NOW, [0; 8]);
    drain(&mut federate);
    federate.handle_message(NOW, Message::Ack).unwrap();
    federate
}

fn drain(federate: &mut Federate<'_>) -> Vec<Message<'static>> {
    let all = std::iter::from_fn(|| federate.poll_transmit(usize::MAX)).map(|message| match message {
        Message::AddressQuery { federate, is_transient } => Some(Message::AddressQuery { federate, is_transient }),
        Message::AddressAdvertisement { port } => Some(Message::AddressAdvertisement { port }),
        Message::Timestamp(time) => Some(Message::Timestamp(time)),
        _ => None,
    });
    all.flatten().collect()
}

/// Takes what comes before the first question.
fn skip_in_turn(federate: &mut Federate<'_>) {
    let mut all = std::iter::from_fn(|| federate.poll_transmit(0x100));
    let last = IN_TURN.first().copied().unwrap_or(Message::UdpPort(UDP_PORT_CLOCK_SYNC_OFF));
    assert!(all.any(|message| message == last));
}

/// Returns a query in the form of LF 0.13, which every RTI answers.
fn query(federate: u16) -> Message<'static> {
    Message::AddressQuery { federate, is_transient: Some(false) }
}

fn reply(port: i32) -> Message<'static> {
    Message::AddressQueryReply { port, address: HERE }
}

fn found(federate: u16, port: u16) -> Event<'static> {
    Event::PeerFound { federate: FederateId(federate), address: Endpoint::new(Ipv4Addr::LOCALHOST, port) }
}

/// The request for an ordered stop, the advertisement, then each of the others, then the time: no federate starts while
/// a connection is missing.
#[test]
fn the_time_is_told_when_all_connections_are_there() {
    let mut federate = federate(Some(4711), &[2, 5]);
    let listens: &[_] = if Profile::PEERS_IN { &[Message::AddressAdvertisement { port: 4711 }] } else { &[] };
    assert_eq!(drain(&mut federate), [IN_TURN, listens, &[query(2)]].concat());
    assert_eq!(federate.phase(), Phase::Meeting);
    assert_eq!(federate.handle_message(NOW, reply(1234)), Ok(found(2, 1234)));
    assert_eq!((drain(&mut federate), federate.poll_timeout()), (vec![], Deadline::Never));
    federate.peer_connected(NOW);
    assert_eq!(drain(&mut federate), [query(5)]);
    assert_eq!(federate.handle_message(NOW, reply(1235)), Ok(found(5, 1235)));
    federate.peer_connected(NOW + MS);
    assert_eq!(drain(&mut federate), [Message::Timestamp((NOW + MS).as_nanos())]);
    assert_eq!(federate.phase(), Phase::Starting);
}

/// The messages of the recorded federate until the connection is made, byte by byte, but for the last one of each
/// question, which LF 0.12 does not have: an unknown address is asked for again 250 ms after the answer.
#[test]
fn the_questions_are_those_of_the_recording() {
    let recording = lf_testkit::golden::load("52-decentralized-source").unwrap();
    let mut federate = federate(None, &[1]);
    skip_in_turn(&mut federate);
    let (mut now, mut asked) = (NOW, 0);
    for step in &recording.steps {
        match step {
            Step::Recv(frame) if frame.message.starts_with("ADDRESS_QUERY") => {
                let [question] = drain(&mut federate)[..] else { panic!("nothing is asked") };
                asked += 1;
                assert_eq!([&frame.bytes.exact().unwrap()[..], &[0]].concat(), encoded(&question));
            }
            Step::Send(frame) if frame.message.starts_with("ADDRESS_QUERY_REPLY") => {
                let bytes = frame.bytes.fill_with(4711i32.to_le_bytes());
                let Ok(Decoded::Complete { message, .. }) = decode(&bytes, &Limits::NONE) else { panic!("{frame:?}") };
                let event = federate.handle_message(now, message).unwrap();
                if event == Event::None {
                    assert_eq!(federate.poll_timeout(), Deadline::At(now + ADDRESS_RETRY));
                    assert!(!federate.has_transmit());
                    now = now + ADDRESS_RETRY;
                    federate.handle_timeout(now).unwrap();
                } else {
                    assert_eq!((event, asked), (found(1, 4711), 3));
                    return;
                }
            }
            _ => {}
        }
    }
    panic!("the address was never known");
}

/// An RTI over IPv6 sends addresses of IPv6. A link-local one is at the interface that leads to the RTI.
#[test]
fn peers_are_found_over_ipv6() {
    let [near, far, here] = ["fe80::7", "fd00::7", "::1"].map(|text| text.parse::<Ipv6Addr>().unwrap());
    for (rti, told, expected) in [
        (IpAddress::v6(far, 0), far, IpAddress::v6(far, 0)),
        (IpAddress::v6(near, 3), near, IpAddress::v6(near, 3)),
        (IpAddress::v6(here, 0), near, IpAddress::v6(near, 9)),
    ] {
        let mut federate = federate(None, &[2]);
        federate.set_rti(rti);
        drain(&mut federate);
        let reply = Message::AddressQueryReplyIpv6 { port: 4711, address: told.octets(), scope: 9 };
        let address = Endpoint { ip: expected, port: 4711 };
        let found = Event::PeerFound { federate: FederateId(2), address };
        assert_eq!(federate.handle_message(NOW, reply), Ok(found));
    }
}

#[test]
fn a_connection_that_fails_is_tried_at_an_address_that_is_asked_for_again_until_the_time_is_over() {
    let mut federate = federate(None, &[3]);
    drain(&mut federate);
    let mut now = NOW;
    let mut attempts = 0;
    loop {
        assert_eq!(federate.handle_message(now, reply(1234)), Ok(found(3, 1234)));
        attempts += 1;
        if let Err(error) = federate.peer_lost(now) {
            assert_eq!(error, FederateError::PeerUnreachable { federate: FederateId(3) });
            break;
        }
        assert_eq!(federate.poll_timeout(), Deadline::At(now + CONNECT_RETRY));
        now = now + CONNECT_RETRY;
        federate.handle_timeout(now).unwrap();
        assert_eq!(drain(&mut federate), [query(3)]);
    }
    assert_eq!((attempts, now), (121, NOW + CONNECT_TIME_OUT));
    assert_eq!(federate.phase(), Phase::Failed);
}

/// While the other one has not come, there is no hurry: it may be started by hand.
#[test]
fn an_unknown_address_is_asked_for_as_long_as_it_takes() {
    let mut federate = federate(None, &[3]);
    skip_in_turn(&mut federate);
    let mut now = NOW;
    for _ in 0..1000 {
        assert_eq!(drain(&mut federate), [query(3)]);
        assert_eq!(federate.handle_message(now, reply(ADDRESS_PORT_UNKNOWN)), Ok(Event::None));
        now = now + ADDRESS_RETRY;
        federate.handle_timeout(now).unwrap();
    }
    // An invalid port is as good as none, and answers without a question mean nothing.
    drain(&mut federate);
    assert_eq!(federate.handle_message(now, reply(70_000)), Ok(Event::None));
    assert_eq!(federate.handle_message(now, reply(1234)), Ok(Event::None));
}

#[test]
fn an_rti_that_rejects_or_ends_meanwhile_is_an_error() {
    let mut federate = federate(None, &[3]);
    let code = RejectCode::UnexpectedMessage;
    assert_eq!(federate.handle_message(NOW, Message::Reject(code)), Err(FederateError::Rejected(code)));
    let mut federate = self::federate(None, &[3]);
    let lost = FederateError::RtiLost { phase: Phase::Meeting };
    assert_eq!(federate.handle_disconnected(), Err(lost));
}
