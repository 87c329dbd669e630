// SPDX-License-Identifier: Apache-2.0
//! Messages of which a fuzzer chooses the parts.

use arbitrary::{Arbitrary, Result, Unstructured};
use lf_model::time::{Instant, Microstep, Tag};
use lf_wire::june_2026::{Message, MessageType, NeighborStructure, RejectCode};

/// What any message can be made of; each takes what it needs.
#[derive(Debug)]
pub(crate) struct Parts {
    message_type: MessageType,
    port: u16,
    federate: u16,
    tag: lf_wire::Tag,
    int: i32,
    bytes: Vec<u8>,
    upstream: Vec<(u16, i64)>,
    downstream: Vec<u16>,
}

impl Parts {
    /// Any message: most numbers are small, times are around `start`.
    pub(crate) fn any(input: &mut Unstructured<'_>, start: i64) -> Result<Self> {
        let message_type = *input.choose(MessageType::ALL)?;
        Self::of_type(input, message_type, start)
    }

    /// Any message of this type.
    pub(crate) fn of_type(input: &mut Unstructured<'_>, message_type: MessageType, start: i64) -> Result<Self> {
        let mut parts = Self {
            message_type,
            port: small(input)?,
            federate: small(input)?,
            tag: wire(tag(input, start)?),
            int: i32::arbitrary(input)?,
            bytes: Vec::new(),
            upstream: Vec::new(),
            downstream: Vec::new(),
        };
        let count = usize::from(u8::arbitrary(input)? % 40);
        parts.bytes = input.bytes(count.min(input.len()))?.to_vec();
        if message_type == MessageType::NeighborStructure {
            for _ in 0..count % 5 {
                parts.upstream.push((small(input)?, delay(input)?));
                parts.downstream.push(small(input)?);
            }
        }
        Ok(parts)
    }

    fn array<const N: usize>(&self) -> [u8; N] {
        std::array::from_fn(|index| self.bytes.get(index).copied().unwrap_or_default())
    }

    /// The message that these parts make.
    pub(crate) fn message(&self) -> Message<'_> {
        let Self { port, federate, tag, int, .. } = *self;
        let bytes = &self.bytes[..];
        match self.message_type {
            MessageType::Reject => Message::Reject(RejectCode::from_byte(self.array::<1>()[0])),
            MessageType::FedIds => Message::FedIds { federate, federation_id: bytes },
            MessageType::Timestamp => Message::Timestamp(tag.time),
            MessageType::Resign => Message::Resign,
            MessageType::TaggedMessage => Message::TaggedMessage { port, federate, tag, payload: bytes },
            MessageType::NextEventTag => Message::NextEventTag(tag),
            MessageType::TagGrant => Message::TagGrant(tag),
            MessageType::ProvisionalTagGrant => Message::ProvisionalTagGrant(tag),
            MessageType::LatestTagComplete => Message::LatestTagComplete(tag),
            MessageType::StopRequest => Message::StopRequest(tag),
            MessageType::StopReply => Message::StopReply(tag),
            MessageType::StopGranted => Message::StopGranted(tag),
            MessageType::AddressQuery => Message::AddressQuery { federate },
            MessageType::AddressQueryReply => Message::AddressQueryReply { port: int, address: self.array() },
            MessageType::AddressAdvertisement => Message::AddressAdvertisement { port: int },
            MessageType::P2pSendingFedId => Message::P2pSendingFedId { federate, federation_id: bytes },
            MessageType::P2pMessage => Message::P2pMessage { port, federate, payload: bytes },
            MessageType::P2pTaggedMessage => Message::P2pTaggedMessage { port, federate, tag, payload: bytes },
            MessageType::T1 => Message::T1(tag.time),
            MessageType::T3 => Message::T3 { federate },
            MessageType::T4 => Message::T4(tag.time),
            MessageType::CodedProbe => Message::CodedProbe(tag.time),
            MessageType::PortAbsent => Message::PortAbsent { port, federate, tag },
            MessageType::NeighborStructure => {
                Message::NeighborStructure(NeighborStructure::new(&self.upstream, &self.downstream))
            }
            MessageType::Failed => Message::Failed,
            MessageType::DownstreamNextEventTag => Message::DownstreamNextEventTag(tag),
            MessageType::FedNonce => Message::FedNonce { federate, nonce: self.array() },
            MessageType::RtiResponse => Message::RtiResponse { nonce: self.array(), hmac: self.array() },
            MessageType::FedResponse => Message::FedResponse { hmac: self.array() },
            MessageType::UdpPort => Message::UdpPort(port),
            MessageType::Ack => Message::Ack,
        }
    }
}

/// Mostly one of the first few.
fn small(input: &mut Unstructured<'_>) -> Result<u16> {
    let number = u16::arbitrary(input)?;
    Ok(if number % 16 == 15 { number } else { number % 5 })
}

/// A delay as in a neighbor structure.
pub(crate) fn delay(input: &mut Unstructured<'_>) -> Result<i64> {
    Ok(match u8::arbitrary(input)? {
        0..100 => i64::MIN,
        100..150 => 0,
        other @ 150..250 => i64::from(other - 149),
        _ => i64::arbitrary(input)?,
    })
}

/// A tag, mostly a little after the start.
pub(crate) fn tag(input: &mut Unstructured<'_>, start: i64) -> Result<Tag> {
    let near = u8::arbitrary(input)?;
    Ok(match near {
        0..240 => Tag::new(Instant(start.saturating_add(i64::from(near / 4) - 2)), Microstep(u32::from(near % 4))),
        240..246 => Tag::FOREVER,
        246..250 => Tag::NEVER,
        _ => Tag::new(Instant(i64::arbitrary(input)?), Microstep(u32::arbitrary(input)?)),
    })
}

pub(crate) fn wire(tag: Tag) -> lf_wire::Tag {
    lf_wire::Tag::new(tag.time.as_nanos(), tag.microstep.0)
}

pub(crate) fn from_wire(tag: lf_wire::Tag) -> Tag {
    Tag::new(Instant(tag.time), Microstep(tag.microstep))
}

/// The bytes of a message.
pub(crate) fn encoded(message: &Message<'_>) -> Vec<u8> {
    let mut bytes = vec![0; message.encoded_len()];
    let len = message.encode(&mut bytes).expect("there is as much room as the message is long");
    assert_eq!(len, bytes.len(), "{message:?} is as long as it says");
    bytes
}
