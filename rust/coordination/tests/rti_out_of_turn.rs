// SPDX-License-Identifier: Apache-2.0
//! Messages out of turn: the answers of the RTI to every type of message in each phase of a connection.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use lf_coordination::auth::AUTHENTICATOR;
use lf_coordination::rti::{Config, ConnectionId};
use lf_testkit::messages::{Parts, encoded};
use lf_testkit::rti::dialogue::{FEDERATION, START, at, config, hello, read, started};
use lf_testkit::rti::{Rig, Sizes};
use lf_wire::{Message, MessageType, NeighborStructure};

/// The nonce of the federate that authenticates.
const NONCE: [u8; 8] = [7; 8];

/// Returns a message of a type.
fn message_of(message_type: MessageType) -> Parts {
    Parts {
        message_type,
        code: 1,
        port: 0,
        federate: 0,
        tag: at(5),
        int: 4000,
        address: [127, 0, 0, 1],
        nonce: NONCE,
        hmac: [1; 32],
        is_transient: None,
        id: FEDERATION.to_vec(),
        payload: b"value".to_vec(),
        upstream: Vec::new(),
        downstream: Vec::new(),
    }
}

/// Returns an RTI, and a connection on which these messages have been sent.
fn after(config: Config<'static>, messages: &[Message<'_>]) -> (Rig, ConnectionId) {
    let mut rig = Rig::new(config, Sizes::ample(2));
    let connection = rig.connect();
    for message in messages {
        rig.message(connection, message);
    }
    (rig, connection)
}

/// Returns all outcomes, each with the messages that have it.
fn outcomes(phase: impl Fn() -> (Rig, ConnectionId)) -> String {
    let mut all: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for message_type in MessageType::ALL {
        let (mut rig, connection) = phase();
        read(&mut rig, connection);
        rig.outlet.log_events.clear();
        rig.send(connection, &encoded(&message_of(*message_type).message()));
        let wire = &rig.outlet.list[connection.0];
        let end = match (wire.open, wire.incoming.len()) {
            (false, _) => "closed".to_owned(),
            (true, 0) => "open".to_owned(),
            (true, left) => format!("{left} bytes wait"),
        };
        let answer = read(&mut rig, connection).join(", ");
        let name = message_type.name();
        let said: Vec<_> = rig.outlet.log_events.iter().map(|event| event.replace(name, "<type>")).collect();
        all.entry(format!("{end}; answer: {answer}; log: {said:#?}")).or_default().push(name);
    }
    let mut text = String::new();
    for (outcome, types) in all {
        let _ = writeln!(text, "{}\n  {outcome}", types.join(" "));
    }
    text
}

#[test]
fn every_message_before_a_federate_has_joined() {
    let ids = Message::FedIds { federate: 0, federation_id: FEDERATION };
    let neighbors = Message::NeighborStructure(NeighborStructure::new(&[], &[]));
    let authenticating = || Config { authentication: Some(AUTHENTICATOR), ..config() };
    let nonce = Message::FedNonce { federate: 0, nonce: NONCE };
    insta::assert_snapshot!("connected", outcomes(|| after(config(), &[])));
    insta::assert_snapshot!("connected_to_one_that_authenticates", outcomes(|| after(authenticating(), &[])));
    insta::assert_snapshot!("nonce", outcomes(|| after(authenticating(), &[nonce])));
    insta::assert_snapshot!("ids", outcomes(|| after(config(), &[ids])));
    insta::assert_snapshot!("neighbors", outcomes(|| after(config(), &[ids, neighbors])));
}

#[test]
fn every_message_of_a_federate() {
    let joined = || {
        let mut rig = Rig::new(config(), Sizes::ample(2));
        let connection = hello(&mut rig, 0, &[]);
        (rig, connection)
    };
    let running = || {
        let (rig, connections) = started(config(), Sizes::ample(2), &[vec![], vec![]]);
        assert_eq!(rig.rti.start_time().map(lf_model::time::Instant::as_nanos), Some(START));
        (rig, connections[0])
    };
    let resigned = || {
        let (mut rig, connection) = running();
        rig.message(connection, &Message::Resign);
        (rig, connection)
    };
    insta::assert_snapshot!("joined", outcomes(joined));
    insta::assert_snapshot!("running", outcomes(running));
    insta::assert_snapshot!("resigned", outcomes(resigned));
}
