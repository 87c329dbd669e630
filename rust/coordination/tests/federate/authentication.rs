// SPDX-License-Identifier: Apache-2.0
//! Authentication between our RTI and our federate, and the peers that it keeps out.

use super::{Config, Federate};
use lf_coordination::FederateId;
use lf_coordination::auth::{AUTHENTICATOR, Answer, answer_rti};
use lf_coordination::federate::{ClockSync, Disconnected, Event, FederateError, Phase};
use lf_coordination::rti::{self, CONNECTION_TIME_OUT, ConnectionId};
use lf_model::time::Instant;
use lf_testkit::messages::encoded;
use lf_testkit::rti::{Rig, Sizes};
use lf_wire::{Decoded, Limits, Message, RejectCode, decode};

const NOW: Instant = Instant::from_nanos(1_000_000);
const KEY: &[u8] = b"grid";
const NONCE: [u8; 8] = [7; 8];

fn federate(key: &'static [u8], authentication: bool) -> Federate<'static> {
    let authentication = authentication.then_some(answer_rti as Answer);
    let mut federate =
        Federate::new(Config { authentication, clock_sync: ClockSync::Off, ..Config::with_needs(FederateId(0), key) })
            .unwrap();
    federate.handle_connected(NOW, NONCE);
    federate
}

fn rti(authentication: bool) -> Rig {
    let authentication = authentication.then_some(AUTHENTICATOR);
    let config = rti::Config { authentication, clock_sync: rti::ClockSync::Off, ..rti::Config::new(KEY, 64) };
    Rig::new(config, Sizes::ample(1))
}

/// Returns the federate's messages.
fn drain(federate: &mut Federate<'_>) -> Vec<Vec<u8>> {
    std::iter::from_fn(|| federate.poll_transmit(usize::MAX)).map(|message| encoded(&message)).collect()
}

/// Carries messages to and fro until both are silent, or the federate has failed. Returns its error.
fn talk(federate: &mut Federate<'_>, rti: &mut Rig, connection: ConnectionId) -> Result<(), FederateError> {
    let mut outcome = Ok(());
    loop {
        for message in drain(federate) {
            rti.send(connection, &message);
        }
        let bytes = rti.take(connection, usize::MAX);
        if bytes.is_empty() || outcome.is_err() {
            return outcome;
        }
        let mut rest = &bytes[..];
        while let Decoded::Complete { message, len } = decode(rest, &Limits::NONE).unwrap() {
            outcome = outcome.and_then(|()| federate.handle_message(NOW, message).map(|_: Event<'_>| ()));
            rest = &rest[len..];
        }
    }
}

#[test]
fn a_federate_with_the_same_key_is_accepted() {
    let (mut federate, mut rti) = (federate(KEY, true), rti(true));
    assert_eq!(federate.phase(), Phase::Authenticating);
    let connection = rti.connect();
    assert_eq!(talk(&mut federate, &mut rti, connection), Ok(()));
    assert_eq!(federate.phase(), Phase::Running);
    assert_eq!(rti.outlet.log_events[0], "federate 0 has joined");
}

#[test]
fn a_federate_refuses_an_rti_with_another_key_and_both_say_so() {
    let (mut federate, mut rti) = (federate(b"another", true), rti(true));
    let connection = rti.connect();
    assert_eq!(talk(&mut federate, &mut rti, connection), Err(FederateError::RtiNotAuthentic));
    assert_eq!(federate.handle_disconnected(), Ok(Disconnected::Ended));
    let refused = "a program that claims to be federate 0 refuses this RTI: the HMAC does not match (code 6)";
    assert_eq!(rti.outlet.log_events, [refused]);
    assert!(rti.outlet.list[connection.0].ended);
}

#[test]
fn an_rti_without_authentication_says_so_to_a_federate_that_has_it() {
    let (mut federate, mut rti) = (federate(KEY, true), rti(false));
    let connection = rti.connect();
    let error = talk(&mut federate, &mut rti, connection).unwrap_err();
    assert_eq!(error, FederateError::Rejected(RejectCode::NotInAuthenticationMode));
    assert!(error.to_string().contains("`auth: false`"), "{error}");
    assert!(rti.outlet.log_events[0].contains("does not use authentication"), "{:?}", rti.outlet.log_events);
}

#[test]
fn an_rti_with_authentication_says_so_to_a_federate_that_has_it_not() {
    let (mut federate, mut rti) = (federate(KEY, false), rti(true));
    let connection = rti.connect();
    let error = talk(&mut federate, &mut rti, connection).unwrap_err();
    assert_eq!(error, FederateError::Rejected(RejectCode::UnexpectedMessage));
    assert!(error.to_string().contains("`auth: true`"), "{error}");
    assert!(rti.outlet.log_events[0].contains("`auth: true`"), "{:?}", rti.outlet.log_events);
}

/// An attacker has recorded a handshake, and repeats the federate's part: the RTI's nonce differs then.
#[test]
fn a_recorded_handshake_of_a_federate_is_worthless() {
    let (mut original, mut rig) = (federate(KEY, true), rti(true));
    let connection = rig.connect();
    let nonce = drain(&mut original).remove(0);
    rig.send(connection, &nonce);
    let answer = rig.take(connection, usize::MAX);
    let Decoded::Complete { message, .. } = decode(&answer, &Limits::NONE).unwrap() else { panic!("it is cut") };
    original.handle_message(NOW, message).unwrap();
    let rest = drain(&mut original);

    let replayed = rig.connect();
    rig.send(replayed, &nonce);
    assert_ne!(rig.take(replayed, usize::MAX), answer);
    for message in &rest {
        rig.send(replayed, message);
    }
    assert_eq!(rig.take(replayed, usize::MAX), encoded(&Message::Reject(RejectCode::HmacMismatch)));
    // The original one goes on.
    rig.send(connection, &rest.concat());
    assert_eq!(rig.take(connection, usize::MAX), encoded(&Message::Ack));
}

/// An attacker has recorded an RTI's answer, and sends it to a federate with another nonce.
#[test]
fn a_recorded_answer_of_an_rti_is_worthless() {
    let (mut original, mut rig) = (federate(KEY, true), rti(true));
    let connection = rig.connect();
    rig.send(connection, &drain(&mut original).concat());
    let answer = rig.take(connection, usize::MAX);
    let Decoded::Complete { message, .. } = decode(&answer, &Limits::NONE).unwrap() else { panic!("it is cut") };

    original.handle_disconnected().unwrap();
    original.handle_connected(NOW, [8; 8]);
    assert_eq!(drain(&mut original), [encoded(&Message::FedNonce { federate: 0, nonce: [8; 8] })]);
    assert_eq!(original.handle_message(NOW, message), Err(FederateError::RtiNotAuthentic));
    let last_words = [encoded(&Message::Reject(RejectCode::HmacMismatch)), encoded(&Message::Failed)];
    assert_eq!(drain(&mut original), last_words);
}

/// A proof for one federate does not make its owner another one.
#[test]
fn a_federate_that_has_authenticated_cannot_join_as_another_one() {
    let (mut federate, mut rig) = (federate(KEY, true), rti(true));
    let connection = rig.connect();
    rig.send(connection, &drain(&mut federate).concat());
    let answer = rig.take(connection, usize::MAX);
    let Decoded::Complete { message, .. } = decode(&answer, &Limits::NONE).unwrap() else { panic!("it is cut") };
    federate.handle_message(NOW, message).unwrap();
    rig.send(connection, &drain(&mut federate)[0]);
    rig.message(connection, &Message::FedIds { federate: 1, federation_id: KEY });
    assert_eq!(rig.take(connection, usize::MAX), encoded(&Message::Reject(RejectCode::UnexpectedMessage)));
    assert!(rig.outlet.log_events[0].contains("claimed to be federate 1"), "{:?}", rig.outlet.log_events);
}

#[test]
fn a_handshake_that_ends_or_stops_in_the_middle_of_a_proof_is_given_up_and_the_id_stays_free() {
    let hello = encoded(&Message::FedNonce { federate: 0, nonce: NONCE });
    let proof = encoded(&Message::FedResponse { hmac: [0; 32] });
    for (length, times_out) in [(1, false), (10, true), (11, false), (12, true), (hello.len() + 32, false)] {
        let mut rig = rti(true);
        let connection = rig.connect();
        rig.send(connection, &[&hello[..], &proof].concat()[..length]);
        if times_out {
            let late = rig.now + CONNECTION_TIME_OUT;
            rig.rti.handle_timeout(late, &mut rig.outlet);
        } else {
            rig.close(connection);
        }
        let event = &rig.outlet.log_events[0];
        assert!(event.ends_with("before its handshake was complete"), "{length}: {event}");
        let next = rig.connect();
        assert_eq!(talk(&mut federate(KEY, true), &mut rig, next), Ok(()));
    }
}

/// An RTI that answers with anything but its proof, or twice, is not believed.
#[test]
fn nothing_but_the_proof_is_an_answer() {
    for message in [Message::Ack, Message::T1(0), Message::Timestamp(0), Message::FedResponse { hmac: [0; 32] }] {
        let mut federate = federate(KEY, true);
        drain(&mut federate);
        let error = federate.handle_message(NOW, message).unwrap_err();
        let expected = FederateError::Unexpected { message: message.message_type(), phase: Phase::Authenticating };
        assert_eq!(error, expected);
    }
    let mut early = federate(KEY, true);
    let answer = Message::RtiResponse { nonce: NONCE, hmac: [0; 32] };
    let expected =
        FederateError::Unexpected { message: lf_wire::MessageType::RtiResponse, phase: Phase::Authenticating };
    assert_eq!(early.handle_message(NOW, answer), Err(expected), "before the nonce was sent");
}
