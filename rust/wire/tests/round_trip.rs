// SPDX-License-Identifier: Apache-2.0
//! Encoding and decoding are inverse, for every message and every split of a stream.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails, in its helpers too")]

mod common;

use common::parts;
use lf_testkit::messages::{Parts, encoded};
use lf_wire::{
    Decoded, InBuffer, Limits, Message, MessageType, NeighborStructure, NoRoom, OutBuffer, PushError, QueryEnd,
    RejectCode, Tag, decode, decode_to_transient,
};
use proptest::collection::vec;
use proptest::prelude::*;

/// One message of each type, so that none depends on chance.
fn one_of_each() -> impl Strategy<Value = Vec<Parts>> {
    MessageType::ALL.iter().map(|t| parts(std::slice::from_ref(t))).collect::<Vec<_>>()
}

/// Feeds `stream` into a buffer in pieces of the given lengths (over and over) and returns the bytes of the messages
/// that come out, each encoded again; the last byte of a question belongs to it also if it comes later.
fn receive(stream: &[u8], pieces: &[usize], buffer: &mut InBuffer<&mut [u8]>) -> Vec<Vec<u8>> {
    let mut pieces = pieces.iter().copied().cycle();
    let (mut rest, mut received, mut query_end) = (stream, Vec::<Vec<u8>>::new(), QueryEnd::NONE);
    while !rest.is_empty() {
        let space = buffer.space();
        let n = pieces.next().unwrap().min(space.len()).min(rest.len());
        let (piece, later) = rest.split_at(n);
        space[..n].copy_from_slice(piece);
        buffer.filled(n);
        rest = later;
        let late = usize::from(query_end.take(buffer.bytes()).is_some());
        if let Some(question) = received.last_mut() {
            question.extend(&buffer.bytes()[..late]);
        }
        buffer.consume(late);
        while let Some((message, len)) = buffer.next(&Limits::NONE).unwrap() {
            let mut bytes = vec![0; len];
            assert_eq!(message.encode(&mut bytes), Ok(len));
            query_end.follow(&message);
            received.push(bytes);
            buffer.consume(len);
            assert_eq!(query_end.take(buffer.bytes()), None, "what is there is read at once");
        }
    }
    received
}

proptest! {
    /// Bytes that are taken out of the middle leave the others, in order, and room for more.
    #[test]
    fn only_removed_elements_are_gone(
        bytes in vec(any::<u8>(), 0..40), consumed in 0..10usize, offset in 0..50usize, len in 0..50usize,
    ) {
        let mut storage = [0; 40];
        let mut buffer = InBuffer::new(&mut storage[..]);
        buffer.space()[..bytes.len()].copy_from_slice(&bytes);
        buffer.filled(bytes.len());
        buffer.consume(consumed);
        buffer.remove(offset, len);
        let mut expected = bytes[consumed.min(bytes.len())..].to_vec();
        let offset = offset.min(expected.len());
        expected.drain(offset..(offset + len).min(expected.len()));
        prop_assert_eq!(buffer.bytes(), &expected);
        let room = buffer.space().len();
        prop_assert!(room + expected.len() <= 40 && (room > 0 || expected.len() == 40));
    }
}

proptest! {
    // Each case tries every message.
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_message_decodes_to_itself(all in one_of_each(), tail in vec(any::<u8>(), 0..4)) {
        for parts in &all {
            let message = parts.message();
            let mut bytes = parts.bytes();
            let len = bytes.len();
            let is_open = matches!(message, Message::AddressQuery { is_transient: None, .. });
            if is_open && tail.first().is_some_and(|byte| *byte <= 1) {
                continue;
            }
            bytes.extend(&tail);
            prop_assert_eq!(bytes[0], message.message_type().byte());
            prop_assert_eq!(decode(&bytes, &Limits::NONE), Ok(Decoded::Complete { message, len }));
        }
    }

    /// A transient federate takes every message as others do, but for the long form of TIMESTAMP.
    #[test]
    fn a_transient_federate_finds_its_effective_start(
        all in one_of_each(), start: i64, time: i64, microstep: u32,
    ) {
        let message = Message::EffectiveStart { start, tag: Tag::new(time, microstep) };
        let bytes = encoded(&message);
        for cut in 0..bytes.len() {
            let decoded = decode_to_transient(&bytes[..cut], &Limits::NONE, |_| true);
            let need = if cut == 0 { 1 } else { bytes.len() };
            let message_type = (cut > 0).then_some(MessageType::Timestamp);
            prop_assert_eq!(decoded, Ok(Decoded::Incomplete { need, message_type }));
        }
        let complete = Decoded::Complete { message, len: bytes.len() };
        prop_assert_eq!(decode_to_transient(&bytes, &Limits::NONE, |_| true), Ok(complete));
        for parts in all.iter().filter(|parts| parts.message_type != MessageType::Timestamp) {
            let bytes = parts.bytes();
            let decoded = decode_to_transient(&bytes, &Limits::NONE, |_| true);
            prop_assert_eq!(decoded, decode(&bytes, &Limits::NONE));
        }
    }

    #[test]
    fn every_beginning_of_a_message_asks_for_more_but_not_for_too_much(all in one_of_each()) {
        for parts in &all {
            let bytes = parts.bytes();
            let mut need_before = 0;
            for cut in 0..bytes.len() {
                if cut == 3 && parts.message_type == MessageType::AddressQuery {
                    let Message::AddressQuery { federate, .. } = parts.message() else { unreachable!() };
                    let message = Message::AddressQuery { federate, is_transient: None };
                    prop_assert_eq!(decode(&bytes[..cut], &Limits::NONE), Ok(Decoded::Complete { message, len: 3 }));
                    continue;
                }
                let Ok(Decoded::Incomplete { need, message_type }) = decode(&bytes[..cut], &Limits::NONE) else {
                    panic!("{cut} of {} bytes of {:?} are taken for a whole", bytes.len(), parts.message());
                };
                prop_assert!(cut < need && need <= bytes.len() && need_before <= need);
                prop_assert_eq!(message_type, (cut > 0).then_some(parts.message_type));
                need_before = need;
            }
        }
    }

    #[test]
    fn every_message_refuses_a_target_that_is_too_small_and_leaves_it_alone(all in one_of_each()) {
        for parts in &all {
            let message = parts.message();
            let needed = message.encoded_len();
            let mut target = vec![0xa5; needed - 1];
            let room = target.len();
            prop_assert_eq!(message.encode(&mut target), Err(NoRoom { needed, room }.into()));
            prop_assert!(target.iter().all(|byte| *byte == 0xa5));
        }
    }

}

proptest! {
    #[test]
    fn a_stream_gives_the_same_messages_whatever_the_split(
        sent in vec(parts(MessageType::ALL), 0..20),
        pieces in vec(1_usize..300, 1..20),
        spare in 0_usize..200,
    ) {
        // No federate sends such a message behind a question.
        let sent: Vec<_> = sent.into_iter().filter(|parts| parts.bytes()[0] > 1).collect();
        let messages: Vec<_> = sent.iter().map(Parts::bytes).collect();
        let stream = messages.concat();
        let longest = messages.iter().map(Vec::len).max().unwrap_or(1);
        let mut storage = vec![0; longest + spare];
        let mut buffer = InBuffer::new(&mut storage[..]);
        prop_assert_eq!(receive(&stream, &pieces, &mut buffer), messages);
        prop_assert!(buffer.bytes().is_empty());
    }

    #[test]
    fn pushed_bytes_come_out_in_order_in_any_portions(
        sent in vec(parts(MessageType::ALL), 0..20),
        writes in vec(1_usize..300, 1..20),
        spare in 0_usize..200,
    ) {
        let messages: Vec<_> = sent.iter().map(Parts::bytes).collect();
        let longest = messages.iter().map(Vec::len).max().unwrap_or(1);
        let mut buffer = OutBuffer::new(vec![0; longest + spare]);
        let (mut stream, mut writes) = (Vec::<u8>::new(), writes.into_iter().cycle());
        for parts in &sent {
            let message = parts.message();
            let needed = message.encoded_len();
            while buffer.room() < needed {
                let room = buffer.room();
                prop_assert_eq!(buffer.push(&message), Err(NoRoom { needed, room }.into()));
                let n = writes.next().unwrap().min(buffer.pending().len());
                stream.extend(&buffer.pending()[..n]);
                buffer.consume(n);
            }
            prop_assert_eq!(buffer.push(&message), Ok(()));
        }
        stream.extend(buffer.pending());
        prop_assert_eq!(stream, messages.concat());
    }

    #[test]
    fn a_payload_encoded_in_place_makes_the_same_bytes(
        parts in parts(&[MessageType::TaggedMessage, MessageType::P2pTaggedMessage, MessageType::P2pMessage]),
        spare in 0_usize..50,
    ) {
        let mut buffer = OutBuffer::new(vec![0; parts.bytes().len() + spare]);
        let max = parts.payload.len() + spare;
        let write = |target: &mut [u8]| {
            assert_eq!(target.len(), max);
            target[..parts.payload.len()].copy_from_slice(&parts.payload);
            Ok::<_, ()>(parts.payload.len())
        };
        let Parts { port, federate, tag, .. } = parts;
        let pushed = match parts.message_type {
            MessageType::TaggedMessage => buffer.push_tagged_with(port, federate, tag, max, write),
            kind => {
                let tag = (kind == MessageType::P2pTaggedMessage).then_some(tag);
                buffer.push_p2p_with(port, federate, tag, max, write)
            }
        };
        prop_assert_eq!(pushed, Ok(parts.payload.len()));
        prop_assert_eq!(buffer.pending(), parts.bytes());
    }
}

#[test]
fn a_payload_that_fails_leaves_the_buffer_as_it_was() {
    let mut buffer = OutBuffer::new([0; 40]);
    buffer.push(&Message::Ack).unwrap();
    let failed = buffer.push_tagged_with(0, 0, Tag::NEVER, 8, |_| Err("no value"));
    assert_eq!(failed, Err(PushError::Payload("no value")));
    let overrun = buffer.push_tagged_with(0, 0, Tag::NEVER, 8, |_| Ok::<_, ()>(9));
    assert_eq!(overrun, Err(PushError::PayloadOverrun { written: 9, given: 8 }));
    let none = buffer.push_tagged_with(0, 0, Tag::NEVER, 19, |_| -> Result<usize, ()> { panic!("there is no room") });
    assert_eq!(none, Err(PushError::Encode(NoRoom { needed: 40, room: 39 }.into())));
    assert_eq!(buffer.pending(), [255]);
}

#[test]
fn a_federation_id_that_the_wire_cannot_carry_is_refused() {
    let federation_id = &[b'f'; 256];
    let mut target = [0; 300];
    for message in [
        Message::FedIds { federate: 0, federation_id },
        Message::TransientFedIds { federate: 0, kind: 0, federation_id },
        Message::P2pSendingFedId { federate: 0, is_transient: None, federation_id },
        Message::P2pSendingFedId { federate: 0, is_transient: Some(false), federation_id },
    ] {
        let error = message.encode(&mut target).unwrap_err().to_string();
        let name = message.name();
        assert_eq!(error, format!("{name}: federation id length would be 256, but the wire carries at most 255"));
    }
    assert_eq!(target, [0; 300]);
}

#[test]
fn the_reject_codes_are_those_of_the_protocol() {
    let codes = [
        RejectCode::FederationIdMismatch,
        RejectCode::IdInUse,
        RejectCode::IdOutOfRange,
        RejectCode::UnexpectedMessage,
        RejectCode::WrongServer,
        RejectCode::HmacMismatch,
        RejectCode::NotInAuthenticationMode,
        RejectCode::JoinsTooLate,
    ];
    for (code, byte) in codes.into_iter().zip(1..) {
        assert_eq!((code.byte(), RejectCode::from_byte(byte)), (byte, code));
    }
    let insecure = RejectCode::Insecure;
    assert_eq!((insecure.byte(), RejectCode::from_byte(229)), (229, insecure));
    for byte in [0].into_iter().chain(9..=255).filter(|byte| *byte != 229) {
        assert_eq!(RejectCode::from_byte(byte), RejectCode::Other(byte));
        assert_eq!(RejectCode::Other(byte).byte(), byte);
    }
}

#[test]
fn neighbors_read_from_bytes_are_those_that_were_written() {
    let structure = NeighborStructure::new(&[(1, i64::MIN), (2, 0)], &[7, 8, 9]);
    let mut bytes = [0; 35];
    assert_eq!(Message::NeighborStructure(structure).encode(&mut bytes), Ok(35));
    let Ok(Decoded::Complete { message: Message::NeighborStructure(read), len: 35 }) = decode(&bytes, &Limits::NONE)
    else {
        panic!("{bytes:?} is no neighbor structure");
    };
    assert_eq!(read, structure);
    assert_ne!(read, NeighborStructure::new(&[(1, i64::MIN), (2, 1)], &[7, 8, 9]));
    assert_ne!(read, NeighborStructure::new(&[(1, i64::MIN), (2, 0)], &[7, 8]));
    assert_eq!((read.upstream().len(), read.downstream().len()), (2, 3));
    assert_eq!(read.upstream().nth(1), Some((2, 0)));
    assert_eq!(
        format!("{read:?}"),
        "NeighborStructure { upstream: [(1, -9223372036854775808), (2, 0)], downstream: [7, 8, 9] }"
    );
}

#[test]
fn a_buffer_that_grows_keeps_its_bytes() {
    let mut buffer = InBuffer::new(vec![0; 4]);
    buffer.space().copy_from_slice(&[255, 255, 6, 1]);
    buffer.filled(4);
    buffer.consume(2);
    assert_eq!(buffer.replace(vec![0]), Err(vec![0]));
    assert_eq!(buffer.replace(vec![0; 13]).map(|old| old.len()), Ok(4));
    assert_eq!(buffer.bytes(), [6, 1]);
    assert_eq!(buffer.space().len(), 11);
    let mut out = OutBuffer::new(vec![0; 1]);
    out.push(&Message::Ack).unwrap();
    out.replace(vec![0; 2]).unwrap();
    out.push_bytes(&[4]).unwrap();
    assert_eq!(out.pending(), [255, 4]);
    assert_eq!(out.push_bytes(&[4]), Err(NoRoom { needed: 1, room: 0 }));
}

#[test]
fn saying_too_much_to_a_buffer_takes_no_more_than_there_is() {
    let mut buffer = InBuffer::new([0; 3]);
    buffer.filled(9);
    assert_eq!(buffer.bytes().len(), 3);
    buffer.consume(9);
    assert_eq!((buffer.bytes().len(), buffer.space().len()), (0, 3));
    let mut out = OutBuffer::new([0; 3]);
    out.push_bytes(&[1, 2]).unwrap();
    out.consume(9);
    assert!(out.is_empty() && out.room() == 3);
}

/// Both releases of LF, byte for byte, whole and cut at every byte.
#[test]
fn both_forms_of_what_two_releases_send_differently_are_read() {
    let id = b"federation";
    let forms: [(Message<'_>, Vec<u8>); 5] = [
        (Message::AddressQuery { federate: 0x102, is_transient: None }, vec![13, 2, 1]),
        (Message::AddressQuery { federate: 0x102, is_transient: Some(false) }, vec![13, 2, 1, 0]),
        (Message::AddressQuery { federate: 0x102, is_transient: Some(true) }, vec![13, 2, 1, 1]),
        (
            Message::P2pSendingFedId { federate: 0x102, is_transient: None, federation_id: id },
            [&[16, 2, 1, 10][..], id].concat(),
        ),
        (
            Message::P2pSendingFedId { federate: 0x102, is_transient: Some(false), federation_id: id },
            [&[16, 2, 1, 0, 10][..], id].concat(),
        ),
    ];
    for (message, bytes) in forms {
        let mut encoded = vec![0; message.encoded_len()];
        assert_eq!(message.encode(&mut encoded), Ok(bytes.len()));
        assert_eq!(encoded, bytes);
        let stream = [&bytes[..], &[4]].concat();
        for piece in 1..=stream.len() {
            let mut storage = [0; 100];
            let received = receive(&stream, &[piece], &mut InBuffer::new(&mut storage[..]));
            assert_eq!(received, [&bytes[..], &[4]], "{message:?} in pieces of {piece}");
        }
    }
}
