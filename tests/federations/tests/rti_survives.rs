// SPDX-License-Identifier: Apache-2.0
//! Messages that end the stock RTI, or harm whole federations with it: `lfz rti` reports the error, and the others
//! continue.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};

use lf_federations::{Finished, Lfz, Run, TIME_OUT};
use lf_testkit::messages::encoded;
use lf_wire::{
    DELAY_NONE, Decoded, Limits, Message, MessageType, NeighborStructure, RejectCode, Tag, UDP_PORT_CLOCK_SYNC_OFF,
    decode,
};

const FEDERATION: &str = "survivors";
/// The federates' clocks show 0, so all start a second later.
const START: i64 = 1_000_000_000;
/// The messages of one burst: more than any queue of an RTI holds.
const BURST: i64 = 20_000;

fn rti(options: &[&str]) -> (Run, u16) {
    Lfz::rti(&[&["-n", "2", "-i", FEDERATION, "--go-on-after-loss"], options].concat())
}

fn at(ns: i64) -> Tag {
    Tag::new(START + ns, 0)
}

/// A tester that plays a federate.
struct Federate {
    stream: TcpStream,
    /// The received bytes that are not read yet.
    bytes: Vec<u8>,
}

impl Federate {
    fn connect(port: u16) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", port)).expect("the RTI listens");
        stream.set_nodelay(true).expect("it is TCP");
        stream.set_read_timeout(Some(TIME_OUT)).expect("it is not zero");
        Self { stream, bytes: Vec::new() }
    }

    /// Joins; federate 1 is downstream of federate 0.
    fn join(port: u16, id: u16) -> Self {
        let mut federate = Self::connect(port);
        let upstream: &[(u16, i64)] = if id == 1 { &[(0, DELAY_NONE)] } else { &[] };
        let downstream: &[u16] = if id == 0 { &[1] } else { &[] };
        federate.say(&Message::FedIds { federate: id, federation_id: FEDERATION.as_bytes() });
        federate.say(&Message::NeighborStructure(NeighborStructure::new(upstream, downstream)));
        federate.say(&Message::UdpPort(UDP_PORT_CLOCK_SYNC_OFF));
        federate.hears(&Message::Ack);
        federate
    }

    fn say(&mut self, message: &Message<'_>) {
        self.send(&encoded(message));
    }

    fn send(&mut self, bytes: &[u8]) {
        self.stream.write_all(bytes).expect("the RTI reads");
    }

    /// Returns the bytes of the next message; `None` at the end of the connection.
    fn next(&mut self) -> Option<Vec<u8>> {
        loop {
            if let Ok(Decoded::Complete { len, .. }) = decode(&self.bytes, &Limits::NONE) {
                return Some(self.bytes.drain(..len).collect());
            }
            let mut buffer = [0; 16 * 1024];
            match self.stream.read(&mut buffer) {
                Ok(0) | Err(_) => return None,
                Ok(count) => self.bytes.extend_from_slice(&buffer[..count]),
            }
        }
    }

    /// Asserts that the next message is this one; skips DNETs, which are advice.
    fn hears(&mut self, expected: &Message<'_>) {
        let dnet = MessageType::DownstreamNextEventTag.byte();
        let mut found = self.next();
        while found.as_ref().is_some_and(|bytes| bytes[0] == dnet) {
            found = self.next();
        }
        assert_eq!(found, Some(encoded(expected)), "{expected:?} is due");
    }

    /// Asserts that the connection has ended, perhaps after FAILED.
    fn is_expelled(&mut self) {
        self.hears(&Message::Failed);
        assert_eq!(self.next(), None);
    }

    fn resign(mut self) {
        self.say(&Message::Resign);
        while self.next().is_some() {}
    }
}

/// Starts two federates, the second one downstream of the first.
fn started(port: u16) -> [Federate; 2] {
    let mut federates = [0, 1].map(|id| Federate::join(port, id));
    for federate in &mut federates {
        federate.say(&Message::Timestamp(0));
    }
    for federate in &mut federates {
        federate.hears(&Message::Timestamp(START));
    }
    federates
}

/// Lets federate 0 send this after the start: the RTI drops it, and federate 1 continues at once.
fn expelled_for(bytes: &[u8]) -> Finished {
    let (rti, port) = rti(&[]);
    let [mut wrong, mut right] = started(port);
    wrong.send(bytes);
    wrong.is_expelled();
    right.hears(&Message::TagGrant(Tag::FOREVER));
    right.resign();
    let finished = rti.finish();
    assert_eq!(finished.code(), 1, "{finished}");
    finished
}

#[test]
fn a_message_for_an_unknown_federate() {
    let message = Message::TaggedMessage { port: 0, federate: 7, tag: at(0), payload: b"lost" };
    expelled_for(&encoded(&message)).line(&["federate 0", "it named federate 7"]);
}

#[test]
fn an_absence_for_an_unknown_federate() {
    let message = Message::PortAbsent { port: 0, federate: u16::MAX, tag: at(0) };
    expelled_for(&encoded(&message)).line(&["federate 0", "it named federate 65535"]);
}

#[test]
fn an_address_query_for_an_unknown_federate() {
    expelled_for(&encoded(&Message::AddressQuery { federate: 2, is_transient: None }))
        .line(&["federate 0", "it named federate 2"]);
}

/// The available memory decides the maximum length, so the RTI, which has no configuration for them, forwards these
/// messages, and later ones.
#[test]
fn messages_of_many_megabytes() {
    let (rti, port) = rti(&[]);
    let [mut sender, mut receiver] = started(port);
    let payloads = [2_400_000, 3, 20_000_000, 5].map(|length: u32| (0..length).map(|at| (at % 251) as u8).collect());
    let payloads: [Vec<u8>; 4] = payloads;
    let messages = (0..)
        .zip(&payloads)
        .map(|(ns, payload)| encoded(&Message::TaggedMessage { port: 0, federate: 1, tag: at(ns), payload }));
    let messages: Vec<Vec<u8>> = messages.collect();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            sender.say(&Message::NextEventTag(at(0)));
            for message in &messages {
                sender.send(message);
            }
            sender.resign();
        });
        for message in &messages {
            let found = receiver.next().expect("the RTI forwards it");
            assert!(found == *message, "{} bytes came instead of {}", found.len(), message.len());
        }
    });
    receiver.hears(&Message::TagGrant(Tag::FOREVER));
    receiver.resign();
    rti.succeed();
}

#[test]
fn a_message_that_is_longer_than_the_limit() {
    let (rti, port) = rti(&["--max-message", "1000"]);
    let [mut wrong, mut right] = started(port);
    let longest = Message::TaggedMessage { port: 0, federate: 1, tag: at(0), payload: &[1; 1000] };
    wrong.say(&longest);
    right.hears(&longest);
    wrong.say(&Message::TaggedMessage { port: 0, federate: 1, tag: at(0), payload: &[1; 1001] });
    wrong.is_expelled();
    right.hears(&Message::TagGrant(Tag::FOREVER));
    right.resign();
    let finished = rti.finish();
    assert_eq!(finished.code(), 1, "{finished}");
    finished.line(&["federate 0 is lost", "of 1001 bytes", "at most 1000", "`--max-message 1001`"]);
}

/// An announced length costs no memory, only received bytes do.
#[test]
fn a_message_that_claims_to_be_huge() {
    let (mut rti, port) = rti(&["--max-message", &u32::MAX.to_string()]);
    let [mut wrong, mut right] = started(port);
    let payload = vec![3; 1_000_000];
    let mut bytes = encoded(&Message::TaggedMessage { port: 0, federate: 1, tag: at(0), payload: &payload });
    bytes[5..9].copy_from_slice(&u32::MAX.to_le_bytes());
    wrong.send(&bytes);
    drop(wrong);
    rti.wait_for("federate 0 is lost: its connection ended without a word");
    let peak = rti.memory_bytes_max();
    // The allocator reserves a gigabyte of addresses.
    assert!(peak < 1 << 31, "the RTI has had {peak} bytes");
    right.hears(&Message::TagGrant(Tag::FOREVER));
    right.resign();
    assert_eq!(rti.finish().code(), 1);
}

#[test]
fn a_wrong_hmac() {
    let (rti, port) = rti(&["--auth"]);
    let mut stranger = Federate::connect(port);
    stranger.say(&Message::FedNonce { federate: 0, nonce: [1; 8] });
    assert_eq!(stranger.next().map(|bytes| bytes[0]), Some(MessageType::RtiResponse.byte()));
    stranger.say(&Message::FedResponse { hmac: [0; 32] });
    stranger.hears(&Message::Reject(RejectCode::HmacMismatch));
    assert_eq!(stranger.next(), None);
    // It still serves others.
    let mut other = Federate::connect(port);
    other.say(&Message::FedIds { federate: 0, federation_id: FEDERATION.as_bytes() });
    other.hears(&Message::Reject(RejectCode::UnexpectedMessage));
    drop(rti);
}

#[test]
fn a_connection_that_ends_in_the_middle_of_a_message() {
    let (rti, port) = rti(&[]);
    let [mut wrong, mut right] = started(port);
    let message = encoded(&Message::TaggedMessage { port: 0, federate: 1, tag: at(0), payload: &[5; 100] });
    wrong.send(&message[..50]);
    wrong.stream.shutdown(Shutdown::Both).expect("it is open");
    right.hears(&Message::TagGrant(Tag::FOREVER));
    right.resign();
    let finished = rti.finish();
    assert_eq!(finished.code(), 1, "{finished}");
    finished.line(&["federate 0 is lost", "its connection ended without a word"]);
}

#[test]
fn a_connection_that_ends_during_the_handshake() {
    let (mut rti, port) = rti(&[]);
    let mut gone = Federate::connect(port);
    gone.say(&Message::FedIds { federate: 0, federation_id: FEDERATION.as_bytes() });
    gone.hears(&Message::Ack);
    drop(gone);
    rti.wait_for("ended before its handshake was complete");
    // Its slot is free, and nothing else has happened.
    for federate in started(port) {
        federate.resign();
    }
    rti.succeed();
}

#[test]
fn leaving_while_a_stop_is_pending() {
    let (rti, port) = rti(&[]);
    let [mut asks, mut leaves] = started(port);
    asks.say(&Message::StopRequest(at(10)));
    leaves.hears(&Message::StopRequest(at(10)));
    leaves.resign();
    asks.hears(&Message::StopGranted(at(10)));
    asks.resign();
    rti.succeed();
}

#[test]
fn silent_connections() {
    let (rti, port) = rti(&[]);
    let silent: Vec<Federate> = (0..4).map(|_| Federate::connect(port)).collect();
    // No federate waits until the RTI gives them up.
    for federate in started(port) {
        federate.resign();
    }
    drop(silent);
    rti.succeed();
}

/// More connections than the RTI has slots for stay silent, and others are refused and do not close: the oldest ones
/// are dropped.
#[test]
fn more_strangers_than_there_are_places() {
    let (rti, port) = rti(&[]);
    let silent: Vec<Federate> = (0..200).map(|_| Federate::connect(port)).collect();
    let refused: Vec<Federate> = (0..100)
        .map(|_| {
            let mut stranger = Federate::connect(port);
            stranger.send(&[99]);
            stranger
        })
        .collect();
    for federate in started(port) {
        federate.resign();
    }
    drop((silent, refused));
    let finished = rti.succeed();
    finished.line(&["a connection that had not said which federate it is was closed", "all places are taken"]);
}

/// A flood of errors does not flood the RTI's log: it logs the first one, the tenth, the hundredth, and the sum.
#[test]
fn floods_of_events_are_logged_at_intervals() {
    const BYTES: usize = 1 << 20;
    const MESSAGES: usize = 5_000;
    let (rti, port) = rti(&[]);
    for _ in 0..MESSAGES / 10 {
        let mut stranger = Federate::connect(port);
        stranger.say(&Message::FedIds { federate: 0, federation_id: b"other" });
        stranger.hears(&Message::Reject(RejectCode::FederationIdMismatch));
    }
    let [mut floods, mut right] = started(port);
    right.say(&Message::LatestTagComplete(at(10)));
    // So the RTI has read it before the next messages.
    right.say(&Message::AddressQuery { federate: 1, is_transient: None });
    assert_eq!(right.next().map(|bytes| bytes[0]), Some(MessageType::AddressQueryReply.byte()));
    floods.send(&vec![99; BYTES]);
    let late = Message::TaggedMessage { port: 0, federate: 1, tag: at(5), payload: b"late" };
    for _ in 0..MESSAGES {
        floods.say(&late);
        right.hears(&late);
    }
    right.resign();
    for _ in 0..MESSAGES {
        floods.say(&late);
    }
    floods.resign();
    let finished = rti.succeed();
    finished.line(&["federate 0 sent 99, which begins no message and was skipped (1000000 so far)"]);
    finished.line(&["a connection was refused", "of federation \"other\"", " (100 so far)"]);
    finished.line(&["a message from federate 0 is late", " (1000 so far)"]);
    finished.line(&[&format!(
        "federate 0 in all: {BYTES} bytes that begin no message; {MESSAGES} late messages; {MESSAGES} messages \
         dropped, because their destinations have left"
    )]);
    assert!(finished.lines.len() < 40, "{finished}");
}

#[test]
fn a_burst_of_20000_messages_without_an_ltc() {
    let (rti, port) = rti(&[]);
    let [mut sender, mut receiver] = started(port);
    let burst = std::thread::spawn(move || {
        sender.say(&Message::NextEventTag(at(0)));
        for ns in 0..BURST {
            sender.say(&Message::TaggedMessage { port: 0, federate: 1, tag: at(ns), payload: &ns.to_le_bytes() });
        }
        sender
    });
    for ns in 0..BURST {
        receiver.hears(&Message::TaggedMessage { port: 0, federate: 1, tag: at(ns), payload: &ns.to_le_bytes() });
    }
    let sender = burst.join().expect("the RTI has read all");
    receiver.say(&Message::LatestTagComplete(at(BURST)));
    sender.resign();
    receiver.hears(&Message::TagGrant(Tag::FOREVER));
    receiver.resign();
    rti.succeed();
}

#[test]
fn an_id_that_is_a_prefix_of_the_federations() {
    let (rti, port) = rti(&[]);
    for id in ["surv", "", "survivors "] {
        let mut stranger = Federate::connect(port);
        stranger.say(&Message::FedIds { federate: 0, federation_id: id.as_bytes() });
        stranger.hears(&Message::Reject(RejectCode::FederationIdMismatch));
        assert_eq!(stranger.next(), None);
    }
    for federate in started(port) {
        federate.resign();
    }
    rti.succeed();
}

#[test]
fn a_resignation_without_closing() {
    let (rti, port) = rti(&[]);
    let [mut stays, mut right] = started(port);
    stays.say(&Message::Resign);
    // At once, though the connection is still open.
    right.hears(&Message::TagGrant(Tag::FOREVER));
    right.resign();
    rti.succeed();
    drop(stays);
}

#[test]
fn a_loss_before_the_start() {
    let (mut rti, port) = rti(&["--start-time-out", "10 ms"]);
    let mut waits = Federate::join(port, 1);
    waits.say(&Message::Timestamp(0));
    drop(Federate::join(port, 0));
    waits.is_expelled();
    rti.wait_for("federate 0 is missing");
    let finished = rti.finish();
    assert_eq!(finished.code(), 1, "{finished}");
    finished.line(&["error: ", "the federation has not started", "federate 0", "--start-time-out"]);
}
