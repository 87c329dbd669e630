// SPDX-License-Identifier: Apache-2.0
//! Every message of the recorded runs decodes, is called as the recording calls it, and encodes to the same bytes.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails, in its helpers too")]

mod describe;

use std::collections::BTreeMap;

use describe::describe;
use lf_testkit::golden::{Fill, Frame, Recording, Step, load_all};
use lf_wire::{
    DecodeError, Decoded, InBuffer, KIND_TRANSIENT, Limits, Message, MessageType, QueryEnd, Tag, decode,
    decode_to_transient,
};

/// The deliberate bytes of recordings that are not one message: recording, step and kind.
const NOT_ONE_MESSAGE: [(&str, usize, Odd); 10] = [
    ("0.13/34-rejections-while-running", 20, Odd::Part { message_type: MessageType::P2pSendingFedId, len: 4 }),
    ("0.13/34-rejections-while-running", 25, Odd::Part { message_type: MessageType::FedNonce, len: 4 }),
    ("0.13/34-rejections-while-running", 30, Odd::Part { message_type: MessageType::NeighborStructure, len: 4 }),
    ("05-unexpected-first-message", 1, Odd::Part { message_type: MessageType::NextEventTag, len: 3 }),
    ("05-unexpected-first-message", 3, Odd::Rest),
    ("05-unexpected-first-message", 23, Odd::Several(4)),
    ("38-unknown-message-type", 14, Odd::Unknown { byte: 99, then: 0 }),
    ("38-unknown-message-type", 19, Odd::Unknown { byte: 3, then: 1 }),
    ("39-handshake-order", 3, Odd::Part { message_type: MessageType::NextEventTag, len: 9 }),
    ("52b-decentralized-sink", 38, Odd::Part { message_type: MessageType::P2pTaggedMessage, len: 4 }),
];

/// Messages that some recordings describe otherwise than the others: as these do, and as the others do.
const DESCRIBED_OTHERWISE: [(&str, &str); 8] = [
    ("REJECT 1 (federation id)", "REJECT FEDERATION_ID_DOES_NOT_MATCH"),
    ("REJECT 2 (federate id in use)", "REJECT FEDERATE_ID_IN_USE"),
    ("REJECT 3 (federate id out of range)", "REJECT FEDERATE_ID_OUT_OF_RANGE"),
    ("REJECT 4 (unexpected message)", "REJECT UNEXPECTED_MESSAGE"),
    ("REJECT 5 (wrong server)", "REJECT WRONG_SERVER"),
    ("REJECT 7 (RTI without authentication)", "REJECT RTI_NOT_EXECUTED_WITH_AUTH"),
    ("P2P_SENDING_FED_ID federate 0", "P2P_SENDING_FED_ID federate 0, federation \"Unidentified Federation\""),
    (
        "P2P_TAGGED_MESSAGE to federate 0, port 0, 1 byte",
        "P2P_TAGGED_MESSAGE (start+-1000000000, 0) to federate 0, port 0, 1 bytes",
    ),
];

/// The start time that is put where it varies, in nanoseconds.
const START: i64 = 1_000_000_000_000_000_000;

#[derive(Clone, Copy, Debug)]
enum Odd {
    /// The beginning of a message, after which the tester stops.
    Part { message_type: MessageType, len: usize },
    /// The next byte of a message whose beginning is the frame before.
    Rest,
    /// This many messages at once.
    Several(usize),
    /// A byte that is no type, and then this many messages.
    Unknown { byte: u8, then: usize },
}

/// Returns the bytes with deterministic values, different at every place, where they vary.
fn fill(frame: &Frame) -> Vec<u8> {
    match (&frame.fill, frame.tag) {
        (Some(Fill::P2pPort), _) => frame.bytes.fill(&15_046_i32.to_le_bytes()).unwrap(),
        (_, Some(tag)) => {
            let times = [START, START + tag.time_ns].map(i64::to_le_bytes).concat();
            frame.bytes.fill(&times[times.len() - frame.bytes.masked_len()..]).unwrap()
        }
        _ => frame.bytes.fill_with((1..=255).cycle()),
    }
}

/// Returns the start time of a recording, in ns: that of the recorded RTI, or that of [`fill`] for a federate.
fn start(recording: &Recording) -> i64 {
    let received = recording.steps.iter().find_map(|step| match step {
        Step::Recv(frame) if recording.rti().is_some() => match decode(&frame.bytes.exact()?, &Limits::NONE) {
            Ok(Decoded::Complete { message: Message::Timestamp(start), .. }) => Some(start),
            _ => None,
        },
        _ => None,
    });
    received.unwrap_or(START)
}

/// Panics if the recorder, which made its descriptions without this crate, has seen another message in these bytes.
fn check_meaning(message: &Message<'_>, frame: &Frame, start: i64, place: &str) {
    let described = describe(message, start);
    let name = described.split(' ').next();
    let is_time = message.message_type() == MessageType::Timestamp;
    if (frame.tag.is_none() || is_time) && frame.bytes.masked_len() > 0 {
        // The description cannot say what varies, but what it is.
        assert_eq!(frame.message.split([' ', ',', ':']).next(), name, "{place}");
    } else if let (Message::Timestamp(time), true) = (message, frame.message.contains("start")) {
        assert_eq!(frame.message, format!("TIMESTAMP start{:+}", time - start), "{place}");
    } else {
        let otherwise = DESCRIBED_OTHERWISE.iter().find(|(otherwise, _)| *otherwise == frame.message);
        assert_eq!(otherwise.map_or(&*frame.message, |(_, usual)| *usual), described, "{place}");
    }
}

/// The function that decodes a message: that of a transient federate, or of any other receiver.
type Decode = for<'a> fn(&'a [u8]) -> Result<Decoded<'a>, DecodeError>;

const OF_ALL: Decode = |bytes| decode(bytes, &Limits::NONE);
const OF_TRANSIENT: Decode = |bytes| decode_to_transient(bytes, &Limits::NONE, |_| true);

/// Returns how the receiver of this step decodes it.
fn decode_of(recording: &Recording, step: &Step) -> Decode {
    match step {
        Step::Recv(frame) if is_transient(recording, frame.connection) => OF_TRANSIENT,
        _ => OF_ALL,
    }
}

/// Returns whether the tester is a transient federate on this connection.
fn is_transient(recording: &Recording, connection: u16) -> bool {
    let kind = |step: &Step| match step {
        Step::Send(frame) if frame.connection == connection => match decode(&fill(frame), &Limits::NONE) {
            Ok(Decoded::Complete { message: Message::TransientFedIds { kind, .. }, .. }) => Some(kind),
            _ => None,
        },
        _ => None,
    };
    recording.steps.iter().find_map(kind) == Some(KIND_TRANSIENT)
}

/// Takes all messages from the front of `bytes`, checks that they encode to the same, and returns how many there are.
fn check_messages(bytes: &[u8], decode: Decode, counts: &mut BTreeMap<u8, usize>) -> usize {
    let (mut rest, mut messages) = (bytes, 0);
    while !rest.is_empty() {
        let Ok(Decoded::Complete { message, len }) = decode(rest) else {
            panic!("{rest:02x?} does not begin with a message");
        };
        let mut again = vec![0; message.encoded_len()];
        assert_eq!(message.encode(&mut again), Ok(len), "{message:?}");
        assert_eq!(again, rest[..len], "{message:?}");
        *counts.entry(message.message_type().byte()).or_default() += 1;
        messages += 1;
        rest = &rest[len..];
    }
    messages
}

fn check_odd(odd: Odd, bytes: &[u8], counts: &mut BTreeMap<u8, usize>) {
    match odd {
        Odd::Part { message_type, len } => {
            assert_eq!(bytes.len(), len);
            let decoded = decode(bytes, &Limits::NONE);
            let Ok(Decoded::Incomplete { need, message_type: found }) = decoded else { panic!("{decoded:?}") };
            assert!(need > len && found == Some(message_type));
        }
        Odd::Rest => assert_eq!(bytes.len(), 1),
        Odd::Several(messages) => assert_eq!(check_messages(bytes, OF_ALL, counts), messages),
        Odd::Unknown { byte, then } => {
            assert_eq!(decode(bytes, &Limits::NONE), Err(DecodeError::UnknownType { found: byte }));
            assert_eq!(check_messages(&bytes[1..], OF_ALL, counts), then);
        }
    }
}

/// Returns the frame of a step that has one.
fn frame(step: &Step) -> Option<&Frame> {
    match step {
        Step::Send(frame) | Step::Recv(frame) | Step::UdpSend(frame) | Step::UdpRecv { frame, .. } => Some(frame),
        _ => None,
    }
}

#[test]
fn every_recorded_message_decodes_and_encodes_to_the_same_bytes() {
    let (mut frames, mut odd_frames) = (0, 0);
    let mut counts = BTreeMap::new();
    for recording in load_all().unwrap() {
        let start = start(&recording);
        for (index, step) in recording.steps.iter().enumerate() {
            let Some(frame) = frame(step) else { continue };
            let bytes = fill(frame);
            frames += 1;
            let odd = NOT_ONE_MESSAGE.iter().find(|(name, step, _)| *name == recording.name && *step == index);
            if let Some((_, _, odd)) = odd {
                check_odd(*odd, &bytes, &mut counts);
                odd_frames += 1;
                continue;
            }
            let place = format!("{}, step {index}: {}", recording.name, frame.message);
            let decode = decode_of(&recording, step);
            let decoded = decode(&bytes).unwrap_or_else(|error| panic!("{place}: {error}"));
            let Decoded::Complete { message, .. } = decoded else { panic!("{place}: {decoded:?}") };
            check_meaning(&message, frame, start, &place);
            assert_eq!(check_messages(&bytes, decode, &mut counts), 1, "{place}");
        }
    }
    assert_eq!((frames, odd_frames), (2748 + 1848 + 17 + 16, NOT_ONE_MESSAGE.len()));
    // 17, between federates on physical connections, is the only message that no recording has.
    let expected: BTreeMap<u8, usize> = [
        (0, 30),
        (1, 209),
        (2, 485),
        (4, 226),
        (5, 363),
        (6, 754),
        (7, 434),
        (8, 30),
        (9, 347),
        (10, 21),
        (11, 12),
        (12, 21),
        (13, 28),
        (14, 27),
        (15, 7),
        (16, 4),
        (18, 10),
        (19, 137),
        (20, 137),
        (21, 136),
        (22, 7),
        (23, 52),
        (24, 249),
        (25, 12),
        (26, 252),
        (27, 30),
        (28, 25),
        (29, 3),
        (30, 3),
        (31, 2),
        (100, 6),
        (101, 5),
        (102, 4),
        (103, 55),
        (254, 248),
        (255, 253),
    ]
    .into();
    assert_eq!(counts, expected);
}

/// The recordings have no type 17, and mask the fields of the others or do not describe them, so nothing there
/// distinguishes one field from another.
#[test]
fn messages_that_the_recordings_do_not_pin_down_lie_as_the_protocol_says() {
    let (nonce, hmac) = ([9, 8, 7, 6, 5, 4, 3, 2], std::array::from_fn(|i| 100 + u8::try_from(i).unwrap()));
    let p2p = Message::P2pMessage { port: 0x0102, federate: 0x0304, payload: &[7, 8] };
    let pinned: [(Message<'_>, Vec<u8>); 14] = [
        (p2p, vec![17, 2, 1, 4, 3, 2, 0, 0, 0, 7, 8]),
        (Message::FedNonce { federate: 0x0102, nonce }, [&[100, 2, 1][..], &nonce].concat()),
        (Message::RtiResponse { nonce, hmac }, [&[101][..], &nonce, &hmac].concat()),
        (Message::FedResponse { hmac }, [&[102][..], &hmac].concat()),
        (Message::T1(0x0102), vec![19, 2, 1, 0, 0, 0, 0, 0, 0]),
        (Message::T4(-1), vec![21, 255, 255, 255, 255, 255, 255, 255, 255]),
        (Message::CodedProbe(3), vec![22, 3, 0, 0, 0, 0, 0, 0, 0]),
        (Message::AddressAdvertisement { port: 0x3ac6 }, vec![15, 0xc6, 0x3a, 0, 0]),
        (Message::DownstreamNextEventTag(Tag::NEVER), vec![26, 0, 0, 0, 0, 0, 0, 0, 128, 0, 0, 0, 0]),
        (Message::UpstreamConnected { federate: 0x0102 }, vec![27, 2, 1]),
        (Message::UpstreamDisconnected { federate: 0x0102 }, vec![28, 2, 1]),
        (Message::Stop, vec![29]),
        (Message::OutboundConnected { federate: 0x0102 }, vec![30, 2, 1]),
        (Message::OutboundDisconnected { federate: 0x0102 }, vec![31, 2, 1]),
    ];
    for (message, bytes) in pinned {
        assert_eq!(decode(&bytes, &Limits::NONE), Ok(Decoded::Complete { message, len: bytes.len() }));
        assert_eq!(check_messages(&bytes, OF_ALL, &mut BTreeMap::new()), 1);
    }
}

#[test]
fn every_recorded_connection_reads_as_a_stream_in_one_byte_pieces() {
    let mut messages = 0;
    for recording in load_all().unwrap() {
        let mut streams: BTreeMap<(u16, bool), (Vec<u8>, Decode)> = BTreeMap::new();
        let mut connections = Vec::new();
        for step in &recording.steps {
            match step {
                Step::Connect(connection) | Step::P2pConnect(connection) => {
                    let previous = [(*connection, true), (*connection, false)].map(|key| streams.remove(&key));
                    connections.extend(previous.into_iter().flatten());
                }
                Step::Send(frame) | Step::Recv(frame) => {
                    let of = (frame.connection, matches!(step, Step::Send(_)));
                    let stream = streams.entry(of).or_insert_with(|| (Vec::new(), decode_of(&recording, step)));
                    stream.0.extend(fill(frame));
                }
                _ => {}
            }
        }
        connections.extend(streams.into_values());
        messages += connections.iter().map(|(stream, decode)| count_messages(stream, *decode)).sum::<usize>();
    }
    // One a frame, but: six messages never become whole, one of them sent in two frames; one byte is no message; and
    // one frame has four.
    assert_eq!(messages, 2748 + 1848 - 6 - 1 - 1 + 3);
}

/// Feeds a stream byte by byte and returns the number of messages; bytes that are no type are skipped, as in the
/// recordings.
fn count_messages(stream: &[u8], decode: Decode) -> usize {
    let mut buffer = InBuffer::new(vec![0; 20_100]);
    let (mut messages, mut query_end) = (0, QueryEnd::NONE);
    for byte in stream {
        buffer.space()[0] = *byte;
        buffer.filled(1);
        let late = usize::from(query_end.take(buffer.bytes()).is_some());
        buffer.consume(late);
        match decode(buffer.bytes()) {
            Ok(Decoded::Complete { message, len }) => {
                query_end.follow(&message);
                messages += 1;
                buffer.consume(len);
            }
            Ok(Decoded::Incomplete { .. }) => {}
            Err(error) => {
                assert!(matches!(error, DecodeError::UnknownType { found: 3 | 99 }), "{error}");
                buffer.consume(1);
            }
        }
    }
    messages
}
