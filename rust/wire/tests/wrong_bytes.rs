// SPDX-License-Identifier: Apache-2.0
//! Bytes that are no message, or too long a one, are refused by name, field and offset, and never panic.

mod common;

use common::parts;
use lf_wire::{
    DecodeError, Decoded, Destination, InBuffer, Limits, Message, MessageType, decode, destination_in_header,
    message_bytes_max,
};
use proptest::collection::vec;
use proptest::prelude::*;

const LIMITS: Limits = Limits { payload_bytes_max: 300, federation_id_bytes_max: 40, neighbors_max: 5 };

/// Returns the sentence that refuses these bytes.
fn refusal(bytes: &[u8], limits: &Limits) -> String {
    decode(bytes, limits).expect_err("these bytes have to be refused").to_string()
}

#[test]
fn every_type_byte_outside_the_protocol_is_refused() {
    let mut known: Vec<_> = MessageType::ALL.iter().map(|message_type| message_type.byte()).collect();
    known.sort_unstable();
    let expected: Vec<u8> = [0, 1, 2].into_iter().chain(4..=31).chain(100..=103).chain([114, 254, 255]).collect();
    assert_eq!(known, expected);
    for byte in (0..=255).filter(|byte| !known.contains(byte)) {
        assert_eq!(MessageType::from_byte(byte), None);
        assert_eq!(decode(&[byte, 0, 0], &LIMITS), Err(DecodeError::UnknownType { found: byte }));
    }
    assert_eq!(refusal(&[3], &LIMITS), "type byte 3 at offset 0 is no message of this protocol");
}

#[test]
fn a_length_over_its_limit_is_refused_before_what_it_announces_has_come() {
    let none: &[u8] = &[];
    let cases: [(&[u8], u32, &[u8], &str); 6] = [
        (&[5, 0, 0, 0, 0], 301, &[0; 12], "TAGGED_MESSAGE: payload length at offset 5 is 301, more than the 300"),
        (&[18, 0, 0, 0, 0], u32::MAX, &[0; 12], "P2P_TAGGED_MESSAGE: payload length at offset 5 is 4294967295, more"),
        (&[17, 0, 0, 0, 0], 301, none, "P2P_MESSAGE: payload length at offset 5 is 301, more than the 300"),
        (&[24], 6, &[0; 4], "NEIGHBOR_STRUCTURE: upstream count at offset 1 is 6, more than the 5"),
        (&[24, 0, 0, 0, 0], 6, none, "NEIGHBOR_STRUCTURE: downstream count at offset 5 is 6, more than the 5"),
        (&[24], u32::MAX, &[0; 4], "NEIGHBOR_STRUCTURE: upstream count at offset 1 is -1, but cannot be negative"),
    ];
    for (before, length, after, expected) in cases {
        let bytes = [before, &length.to_le_bytes(), after].concat();
        let found = refusal(&bytes, &LIMITS);
        assert!(found.starts_with(expected), "{found}");
    }
    let ids: [(&[u8], &str, usize); 4] = [
        (&[1, 0, 0, 41], "FED_IDS", 3),
        (&[16, 0, 0, 41], "P2P_SENDING_FED_ID", 3),
        (&[16, 0, 0, 0, 41], "P2P_SENDING_FED_ID", 4),
        (&[103, 0, 0, 41, 0], "TRANSIENT_FED_IDS", 3),
    ];
    for (bytes, name, offset) in ids {
        let expected =
            format!("{name}: federation id length at offset {offset} is 41, more than the 40 that are accepted here");
        assert_eq!(refusal(bytes, &LIMITS), expected);
    }
}

#[test]
fn a_length_at_its_limit_is_accepted() {
    let fixed: [(&[u8], usize); 4] = [
        (&[5, 0, 0, 0, 0, 44, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], 321),
        (&[17, 0, 0, 0, 0, 44, 1, 0, 0], 309),
        (&[1, 0, 0, 40], 44),
        (&[24, 5, 0, 0, 0, 5, 0, 0, 0], 69),
    ];
    for (fixed, len) in fixed {
        assert!(matches!(decode(fixed, &LIMITS), Ok(Decoded::Incomplete { need, .. }) if need == len), "{fixed:?}");
        let mut bytes = fixed.to_vec();
        bytes.resize(len, 0);
        assert!(matches!(decode(&bytes, &LIMITS), Ok(Decoded::Complete { len: l, .. }) if l == len), "{fixed:?}");
        assert!(len <= message_bytes_max(&LIMITS));
    }
    assert_eq!(message_bytes_max(&LIMITS), 321);
}

#[test]
fn the_longest_message_is_that_of_the_greatest_limit() {
    let limits = |payload_bytes_max, federation_id_bytes_max, neighbors_max| {
        message_bytes_max(&Limits { payload_bytes_max, federation_id_bytes_max, neighbors_max })
    };
    assert_eq!(limits(0, 0, 0), 41);
    assert_eq!(limits(100, 200, 0), 205);
    assert_eq!(limits(0, 1000, 0), 260);
    assert_eq!(limits(0, 0, 10), 129);
    assert_eq!(message_bytes_max(&Limits::NONE), usize::MAX);
}

#[test]
fn a_message_that_can_never_fit_into_the_buffer_is_refused_at_once() {
    let mut buffer = InBuffer::new([0; 20]);
    buffer.space()[0] = 5;
    buffer.filled(1);
    let error = buffer.next(&LIMITS).unwrap_err().to_string();
    assert_eq!(error, "TAGGED_MESSAGE: has 21 bytes or more, but the receive buffer holds 20");
    let empty = InBuffer::new([0; 0]).next(&LIMITS).unwrap_err().to_string();
    assert_eq!(empty, "any message: has 1 bytes or more, but the receive buffer holds 0");
}

#[test]
fn refused_bytes_stay_until_their_owner_drops_them() {
    let mut buffer = InBuffer::new([0; 4]);
    buffer.space()[..2].copy_from_slice(&[99, 255]);
    buffer.filled(2);
    assert_eq!(buffer.next(&LIMITS), Err(DecodeError::UnknownType { found: 99 }));
    assert_eq!(buffer.next(&LIMITS), Err(DecodeError::UnknownType { found: 99 }));
    buffer.consume(1);
    assert!(buffer.next(&LIMITS).unwrap().is_some());
}

/// Also of a message that is refused for its length, as soon as its header is there.
#[test]
fn a_header_tells_where_a_payload_goes() {
    for (first, fixed) in [(5, 21), (17, 9), (18, 21)] {
        let mut bytes = vec![first, 7, 1, 2, 0, 0xff, 0xff, 0xff, 0x7f];
        bytes.resize(fixed, 0);
        let destination = Destination { port: 0x107, federate: 2, payload_bytes: 0x7fff_ffff };
        assert_eq!(destination_in_header(&bytes), Some(destination));
        assert_eq!(destination_in_header(&bytes[..9]), Some(destination));
        assert_eq!(destination_in_header(&bytes[..8]), None);
    }
    for none in [&[][..], &[3; 30], &[23; 30]] {
        assert_eq!(destination_in_header(none), None);
    }
}

/// Checks what holds for all bytes: an answer within the limits, and bytes that are a message are the only ones that
/// encode it.
fn check(bytes: &[u8]) {
    match decode(bytes, &LIMITS) {
        Ok(Decoded::Complete { message, len }) => {
            let mut again = vec![0; len];
            assert_eq!(message.encode(&mut again), Ok(len));
            assert_eq!(again, bytes[..len]);
            assert!(len <= message_bytes_max(&LIMITS));
            let told = destination_in_header(bytes);
            match message {
                Message::TaggedMessage { port, federate, payload, .. }
                | Message::P2pTaggedMessage { port, federate, payload, .. }
                | Message::P2pMessage { port, federate, payload } => {
                    let payload_bytes = u32::try_from(payload.len()).expect("payloads here are short");
                    assert_eq!(told, Some(Destination { port, federate, payload_bytes }));
                }
                _ => assert_eq!(told, None),
            }
        }
        Ok(Decoded::Incomplete { need, message_type }) => {
            assert!(bytes.len() < need && need <= message_bytes_max(&LIMITS));
            assert_eq!(message_type.map(MessageType::byte), bytes.first().copied());
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn arbitrary_bytes_never_panic(bytes in vec(any::<u8>(), 0..60)) {
        check(&bytes);
    }

    #[test]
    fn arbitrary_bytes_after_any_type_never_panic(
        message_type in proptest::sample::select(MessageType::ALL),
        bytes in vec(prop_oneof![Just(0), any::<u8>()], 0..60),
    ) {
        check(&[&[message_type.byte()], &bytes[..]].concat());
    }

    #[test]
    fn messages_with_one_byte_changed_never_panic(
        parts in parts(MessageType::ALL),
        place in any::<proptest::sample::Index>(),
        byte in any::<u8>(),
    ) {
        let mut bytes = parts.bytes();
        *place.get_mut(&mut bytes) = byte;
        check(&bytes);
    }
}
