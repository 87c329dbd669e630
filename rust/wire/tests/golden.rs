// SPDX-License-Identifier: Apache-2.0
//! Every message of the recorded runs decodes, is called as the recording calls it, and encodes to the same bytes.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails, in its helpers too")]

mod describe;

use std::collections::BTreeMap;

use describe::describe;
use lf_testkit::golden::{Fill, Frame, Recording, Step, load_all};
use lf_wire::{DecodeError, Decoded, InBuffer, Limits, Message, MessageType, QueryEnd, Tag, decode};

/// The deliberate bytes of recordings that are not one message: recording, step and kind.
const NOT_ONE_MESSAGE: [(&str, usize, Odd); 7] = [
    ("05-unexpected-first-message", 1, Odd::Part { message_type: MessageType::NextEventTag, len: 3 }),
    ("05-unexpected-first-message", 3, Odd::Rest),
    ("05-unexpected-first-message", 23, Odd::Several(4)),
    ("38-unknown-message-type", 14, Odd::Unknown { byte: 99, then: 0 }),
    ("38-unknown-message-type", 19, Odd::Unknown { byte: 3, then: 1 }),
    ("39-handshake-order", 3, Odd::Part { message_type: MessageType::NextEventTag, len: 9 }),
    ("52b-decentralized-sink", 38, Odd::Part { message_type: MessageType::P2pTaggedMessage, len: 4 }),
];

/// Messages that 05 describes otherwise than all recordings do: as it does, and as they do.
const DESCRIBED_OTHERWISE: [(&str, &str); 2] = [
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
        (_, Some(tag)) => frame.bytes.fill(&(START + tag.time_ns).to_le_bytes()).unwrap(),
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
    if frame.tag.is_none() && frame.bytes.masked_len() > 0 {
        // The description cannot say what varies, but what it is.
        assert_eq!(frame.message.split([' ', ',']).next(), name, "{place}");
    } else {
        let otherwise = DESCRIBED_OTHERWISE.iter().find(|(otherwise, _)| *otherwise == frame.message);
        assert_eq!(otherwise.map_or(&*frame.message, |(_, usual)| *usual), described, "{place}");
    }
}

/// Takes all messages from the front of `bytes`, checks that they encode to the same, and returns how many there are.
fn check_messages(bytes: &[u8], counts: &mut BTreeMap<u8, usize>) -> usize {
    let (mut rest, mut messages) = (bytes, 0);
    while !rest.is_empty() {
        let Ok(Decoded::Complete { message, len }) = decode(rest, &Limits::NONE) else {
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
            let need = message_type.fixed_bytes();
            let incomplete = Decoded::Incomplete { need, message_type: Some(message_type) };
            assert_eq!(decode(bytes, &Limits::NONE), Ok(incomplete));
        }
        Odd::Rest => assert_eq!(bytes.len(), 1),
        Odd::Several(messages) => assert_eq!(check_messages(bytes, counts), messages),
        Odd::Unknown { byte, then } => {
            assert_eq!(decode(bytes, &Limits::NONE), Err(DecodeError::UnknownType { found: byte }));
            assert_eq!(check_messages(&bytes[1..], counts), then);
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
            let decoded = decode(&bytes, &Limits::NONE).unwrap_or_else(|error| panic!("{place}: {error}"));
            let Decoded::Complete { message, .. } = decoded else { panic!("{place}: {decoded:?}") };
            check_meaning(&message, frame, start, &place);
            assert_eq!(check_messages(&bytes, &mut counts), 1, "{place}");
        }
    }
    assert_eq!((frames, odd_frames), (1869 + 1264 + 17 + 16, NOT_ONE_MESSAGE.len()));
    // 17, between federates on physical connections, is the only message that no recording has.
    let expected: BTreeMap<u8, usize> = [
        (0, 22),
        (1, 150),
        (2, 280),
        (4, 140),
        (5, 284),
        (6, 541),
        (7, 321),
        (8, 19),
        (9, 283),
        (10, 11),
        (11, 6),
        (12, 11),
        (13, 18),
        (14, 17),
        (15, 4),
        (16, 4),
        (18, 10),
        (19, 134),
        (20, 134),
        (21, 133),
        (22, 7),
        (23, 37),
        (24, 141),
        (25, 4),
        (26, 152),
        (100, 6),
        (101, 5),
        (102, 4),
        (103, 2),
        (254, 140),
        (255, 144),
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
    let pinned: [(Message<'_>, Vec<u8>); 10] = [
        (p2p, vec![17, 2, 1, 4, 3, 2, 0, 0, 0, 7, 8]),
        (Message::FedNonce { federate: 0x0102, nonce }, [&[100, 2, 1][..], &nonce].concat()),
        (Message::RtiResponse { nonce, hmac }, [&[101][..], &nonce, &hmac].concat()),
        (Message::FedResponse { hmac }, [&[102][..], &hmac].concat()),
        (Message::T1(0x0102), vec![19, 2, 1, 0, 0, 0, 0, 0, 0]),
        (Message::T4(-1), vec![21, 255, 255, 255, 255, 255, 255, 255, 255]),
        (Message::CodedProbe(3), vec![22, 3, 0, 0, 0, 0, 0, 0, 0]),
        (Message::AddressAdvertisement { port: 0x3ac6 }, vec![15, 0xc6, 0x3a, 0, 0]),
        (Message::DownstreamNextEventTag(Tag::NEVER), vec![26, 0, 0, 0, 0, 0, 0, 0, 128, 0, 0, 0, 0]),
        (Message::UpstreamDisconnected { federate: 0x0102 }, vec![28, 2, 1]),
    ];
    for (message, bytes) in pinned {
        assert_eq!(decode(&bytes, &Limits::NONE), Ok(Decoded::Complete { message, len: bytes.len() }));
        assert_eq!(check_messages(&bytes, &mut BTreeMap::new()), 1);
    }
}

#[test]
fn every_recorded_connection_reads_as_a_stream_in_one_byte_pieces() {
    let mut messages = 0;
    for recording in load_all().unwrap() {
        let mut streams: BTreeMap<(u16, bool), Vec<u8>> = BTreeMap::new();
        let mut connections = Vec::new();
        for step in &recording.steps {
            match step {
                Step::Connect(connection) | Step::P2pConnect(connection) => {
                    let previous = [(*connection, true), (*connection, false)].map(|key| streams.remove(&key));
                    connections.extend(previous.into_iter().flatten());
                }
                Step::Send(frame) => streams.entry((frame.connection, true)).or_default().extend(fill(frame)),
                Step::Recv(frame) => streams.entry((frame.connection, false)).or_default().extend(fill(frame)),
                _ => {}
            }
        }
        connections.extend(streams.into_values());
        messages += connections.iter().map(|stream| count_messages(stream)).sum::<usize>();
    }
    // One a frame, but: three messages never become whole, one of them sent in two frames; one byte is no message; and
    // one frame has four.
    assert_eq!(messages, 1869 + 1264 - 3 - 1 - 1 + 3);
}

/// Feeds a stream byte by byte and returns the number of messages; bytes that are no type are skipped, as in the
/// recordings.
fn count_messages(stream: &[u8]) -> usize {
    let mut buffer = InBuffer::new(vec![0; 20_100]);
    let (mut messages, mut query_end) = (0, QueryEnd::NONE);
    for byte in stream {
        buffer.space()[0] = *byte;
        buffer.filled(1);
        let late = query_end.take(buffer.bytes());
        buffer.consume(late);
        match buffer.next(&Limits::NONE) {
            Ok(Some((message, len))) => {
                query_end.follow(&message);
                messages += 1;
                buffer.consume(len);
            }
            Ok(None) => {}
            Err(error) => {
                assert!(matches!(error, DecodeError::UnknownType { found: 3 | 99 }), "{error}");
                buffer.consume(1);
            }
        }
    }
    messages
}
