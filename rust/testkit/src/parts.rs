// SPDX-License-Identifier: Apache-2.0
//! Messages with fields that a fuzzer chooses.

use arbitrary::{Arbitrary, Result, Unstructured};
use lf_coordination::to_wire;
use lf_model::time::{Instant, Microstep, Tag};
use lf_wire::MessageType;

use crate::messages::Parts;

/// Returns any message: most numbers are small, times are around `start`.
///
/// # Errors
/// When the input is used up.
pub fn any(input: &mut Unstructured<'_>, start: i64) -> Result<Parts> {
    let message_type = *input.choose(MessageType::ALL)?;
    of_type(input, message_type, start)
}

/// Returns any message of this type.
///
/// # Errors
/// When the input is used up.
pub fn of_type(input: &mut Unstructured<'_>, message_type: MessageType, start: i64) -> Result<Parts> {
    let (port, federate) = (small(input)?, small(input)?);
    let (tag, int) = (to_wire(tag(input, start)?), i32::arbitrary(input)?);
    let count = usize::from(u8::arbitrary(input)? % 40);
    let bytes = input.bytes(count.min(input.len()))?;
    let mut parts = Parts {
        message_type,
        code: bytes.first().copied().unwrap_or_default(),
        port,
        federate,
        tag,
        int,
        address: array(bytes),
        nonce: array(bytes),
        hmac: array(bytes),
        is_transient: bytes.get(1).map(|byte| byte % 2 == 1),
        id: bytes.to_vec(),
        payload: bytes.to_vec(),
        upstream: Vec::new(),
        downstream: Vec::new(),
    };
    if message_type == MessageType::NeighborStructure {
        for _ in 0..count % 5 {
            parts.upstream.push((small(input)?, delay(input)?));
            parts.downstream.push(small(input)?);
        }
    }
    Ok(parts)
}

/// Returns the first bytes, padded with zeros.
fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
    std::array::from_fn(|index| bytes.get(index).copied().unwrap_or_default())
}

/// Returns a number that is mostly small.
fn small(input: &mut Unstructured<'_>) -> Result<u16> {
    let number = u16::arbitrary(input)?;
    Ok(if number % 16 == 15 { number } else { number % 5 })
}

/// Returns a delay as in a neighbor structure.
///
/// # Errors
/// When the input is used up.
pub fn delay(input: &mut Unstructured<'_>) -> Result<i64> {
    Ok(match u8::arbitrary(input)? {
        0..100 => i64::MIN,
        100..150 => 0,
        other @ 150..250 => i64::from(other - 149),
        _ => i64::arbitrary(input)?,
    })
}

/// Returns a tag, mostly a little after the start.
///
/// # Errors
/// When the input is used up.
pub fn tag(input: &mut Unstructured<'_>, start: i64) -> Result<Tag> {
    let near = u8::arbitrary(input)?;
    Ok(match near {
        0..240 => {
            Tag::new(Instant::from_nanos(start.saturating_add(i64::from(near / 4) - 2)), Microstep(u32::from(near % 4)))
        }
        240..246 => Tag::FOREVER,
        246..250 => Tag::NEVER,
        _ => Tag::new(Instant::from_nanos(i64::arbitrary(input)?), Microstep(u32::arbitrary(input)?)),
    })
}
