// SPDX-License-Identifier: Apache-2.0
//! Arbitrary messages, in a form that owns what a message borrows.

use lf_wire::Tag;
use lf_wire::june_2026::{Message, MessageType, NeighborStructure, RejectCode};
use proptest::collection::vec;
use proptest::prelude::*;

/// What any message can be made of; each takes what it needs.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    pub(crate) message_type: MessageType,
    pub(crate) code: u8,
    pub(crate) port: u16,
    pub(crate) federate: u16,
    pub(crate) time: i64,
    pub(crate) microstep: u32,
    pub(crate) int: i32,
    pub(crate) address: [u8; 4],
    pub(crate) nonce: [u8; 8],
    pub(crate) hmac: [u8; 32],
    pub(crate) id: Vec<u8>,
    pub(crate) payload: Vec<u8>,
    pub(crate) upstream: Vec<(u16, i64)>,
    pub(crate) downstream: Vec<u16>,
}

impl Parts {
    /// The message of this type that these parts make.
    pub(crate) fn message(&self) -> Message<'_> {
        let tag = Tag::new(self.time, self.microstep);
        let Self { port, federate, time, nonce, hmac, .. } = *self;
        let payload = &self.payload[..];
        let federation_id = &self.id[..];
        match self.message_type {
            MessageType::Reject => Message::Reject(RejectCode::from_byte(self.code)),
            MessageType::FedIds => Message::FedIds { federate, federation_id },
            MessageType::Timestamp => Message::Timestamp(time),
            MessageType::Resign => Message::Resign,
            MessageType::TaggedMessage => Message::TaggedMessage { port, federate, tag, payload },
            MessageType::NextEventTag => Message::NextEventTag(tag),
            MessageType::TagGrant => Message::TagGrant(tag),
            MessageType::ProvisionalTagGrant => Message::ProvisionalTagGrant(tag),
            MessageType::LatestTagComplete => Message::LatestTagComplete(tag),
            MessageType::StopRequest => Message::StopRequest(tag),
            MessageType::StopReply => Message::StopReply(tag),
            MessageType::StopGranted => Message::StopGranted(tag),
            MessageType::AddressQuery => Message::AddressQuery { federate },
            MessageType::AddressQueryReply => Message::AddressQueryReply { port: self.int, address: self.address },
            MessageType::AddressAdvertisement => Message::AddressAdvertisement { port: self.int },
            MessageType::P2pSendingFedId => Message::P2pSendingFedId { federate, federation_id },
            MessageType::P2pMessage => Message::P2pMessage { port, federate, payload },
            MessageType::P2pTaggedMessage => Message::P2pTaggedMessage { port, federate, tag, payload },
            MessageType::T1 => Message::T1(time),
            MessageType::T3 => Message::T3 { federate },
            MessageType::T4 => Message::T4(time),
            MessageType::CodedProbe => Message::CodedProbe(time),
            MessageType::PortAbsent => Message::PortAbsent { port, federate, tag },
            MessageType::NeighborStructure => {
                Message::NeighborStructure(NeighborStructure::new(&self.upstream, &self.downstream))
            }
            MessageType::Failed => Message::Failed,
            MessageType::DownstreamNextEventTag => Message::DownstreamNextEventTag(tag),
            MessageType::FedNonce => Message::FedNonce { federate, nonce },
            MessageType::RtiResponse => Message::RtiResponse { nonce, hmac },
            MessageType::FedResponse => Message::FedResponse { hmac },
            MessageType::UdpPort => Message::UdpPort(port),
            MessageType::Ack => Message::Ack,
        }
    }

    /// The bytes of that message.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let message = self.message();
        let mut bytes = vec![0; message.encoded_len()];
        assert_eq!(message.encode(&mut bytes), Ok(bytes.len()));
        bytes
    }
}

/// Times with the special ones often among them.
fn time() -> impl Strategy<Value = i64> {
    prop_oneof![any::<i64>(), Just(i64::MIN), Just(i64::MAX), Just(0)]
}

/// Parts for a message of one of `types`.
pub(crate) fn parts(types: &'static [MessageType]) -> impl Strategy<Value = Parts> {
    let scalars = (any::<u8>(), any::<u16>(), any::<u16>(), time(), any::<u32>(), any::<i32>());
    let arrays = (any::<[u8; 4]>(), any::<[u8; 8]>(), any::<[u8; 32]>());
    let lists = (
        vec(any::<u8>(), 0..=255),
        vec(any::<u8>(), 0..300),
        vec((any::<u16>(), time()), 0..12),
        vec(any::<u16>(), 0..12),
    );
    (proptest::sample::select(types), scalars, arrays, lists).prop_map(|(message_type, scalars, arrays, lists)| {
        let (code, port, federate, time, microstep, int) = scalars;
        let (address, nonce, hmac) = arrays;
        let (id, payload, upstream, downstream) = lists;
        Parts {
            message_type,
            code,
            port,
            federate,
            time,
            microstep,
            int,
            address,
            nonce,
            hmac,
            id,
            payload,
            upstream,
            downstream,
        }
    })
}
