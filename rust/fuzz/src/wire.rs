// SPDX-License-Identifier: Apache-2.0
//! The decoder: whatever it accepts is a valid message, independent of how the bytes are split, and it never asks for
//! more than the limits allow.

use arbitrary::Unstructured;
use lf_testkit::messages::encoded;
use lf_testkit::parts;
use lf_wire::{DecodeError, Decoded, InBuffer, Limits, Message, QueryEnd, decode, message_bytes_max};

/// Decodes bytes from a peer. The first bytes of the input choose limits and the size of pieces.
///
/// # Panics
/// If something does not hold that has to.
pub fn wire_raw(data: &[u8]) {
    let [payload, id, neighbors, piece, rest @ ..] = data else { return };
    let limits = Limits {
        payload_bytes_max: usize::from(*payload),
        federation_id_bytes_max: usize::from(*id),
        neighbors_max: usize::from(*neighbors % 16),
    };
    let whole = decode_whole(rest, &limits);
    let pieces = decode_in_pieces(rest, &limits, usize::from(*piece % 32) + 1);
    assert_eq!(whole, pieces, "the same messages, in whatever pieces they come");
}

/// Encodes a list of messages, and asserts that decoding returns the same messages.
///
/// # Panics
/// If something does not hold that has to.
pub fn wire_structured(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let mut bytes = Vec::new();
    let mut count = 0;
    let mut query_end = QueryEnd::NONE;
    while let Ok(parts) = parts::any(&mut input, 0) {
        let message = parts.message();
        let one = encoded(&message);
        let mut behind = query_end;
        if behind.take(&one).is_some() {
            // No federate sends this message after a query.
            if input.is_empty() {
                break;
            }
            continue;
        }
        query_end.follow(&message);
        match decode(&one, &Limits::NONE) {
            Ok(Decoded::Complete { message: back, len }) => assert_eq!((back, len), (message, one.len())),
            other => panic!("{message:?} comes back as {other:?}"),
        }
        bytes.extend(one);
        count += 1;
        if input.is_empty() {
            break;
        }
    }
    assert_eq!(decode_whole(&bytes, &Limits::NONE).lengths.len(), count);
}

/// The result of decoding a stream.
#[derive(Debug, PartialEq, Eq)]
struct Found {
    lengths: Vec<usize>,
    error: Option<DecodeError>,
}

/// Decodes messages as long as there are any; skips a byte that begins no message, as the RTI does.
fn decode_whole(bytes: &[u8], limits: &Limits) -> Found {
    let mut found = Found { lengths: Vec::new(), error: None };
    let mut rest = bytes;
    loop {
        match decode(rest, limits) {
            Ok(Decoded::Complete { message, len }) => {
                assert!(len > 0 && len <= rest.len() && len <= message_bytes_max(limits));
                assert_eq!(encoded(&message), rest[..len], "{message:?} is what its bytes say");
                for prefix in [0, len / 2, len - 1] {
                    match decode(&rest[..prefix], limits) {
                        Ok(Decoded::Complete { message: Message::AddressQuery { is_transient: None, .. }, len: 3 })
                            if prefix == 3 && matches!(message, Message::AddressQuery { .. }) => {}
                        Ok(Decoded::Incomplete { need, .. }) => assert!(need > prefix && need <= len),
                        other => panic!("{prefix} bytes of {message:?} are {other:?}"),
                    }
                }
                found.lengths.push(len);
                rest = &rest[len..];
            }
            Ok(Decoded::Incomplete { need, .. }) => {
                assert!(need > rest.len() && need <= message_bytes_max(limits));
                return found;
            }
            Err(DecodeError::UnknownType { .. }) => rest = &rest[1..],
            Err(error) => {
                found.error = Some(error);
                return found;
            }
        }
    }
}

fn decode_in_pieces(bytes: &[u8], limits: &Limits, piece: usize) -> Found {
    let mut found = Found { lengths: Vec::new(), error: None };
    let mut buffer = InBuffer::new(vec![0; message_bytes_max(limits)]);
    let mut query_end = QueryEnd::NONE;
    let mut rest = bytes;
    loop {
        let space = buffer.space();
        let count = piece.min(space.len()).min(rest.len());
        space[..count].copy_from_slice(&rest[..count]);
        buffer.filled(count);
        rest = &rest[count..];
        loop {
            let late = usize::from(query_end.take(buffer.bytes()).is_some());
            buffer.consume(late);
            if let Some(question) = found.lengths.last_mut() {
                *question += late;
            }
            match buffer.next(limits) {
                Ok(Some((message, len))) => {
                    query_end.follow(&message);
                    found.lengths.push(len);
                    buffer.consume(len);
                }
                Ok(None) => break,
                Err(DecodeError::UnknownType { .. }) => buffer.consume(1),
                Err(error) => {
                    found.error = Some(error);
                    return found;
                }
            }
        }
        if rest.is_empty() {
            return found;
        }
    }
}
