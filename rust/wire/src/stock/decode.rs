// SPDX-License-Identifier: Apache-2.0
//! Bytes to messages.

#[cfg(feature = "transients")]
use super::layouts::byte;
use super::layouts::{DOWNSTREAM_BYTES, UPSTREAM_BYTES, fixed_bytes, message_type};
use crate::bytes::{Reader, Short};
use crate::{
    DecodeError, Decoded, Destination, FEDERATION_ID_BYTES_MAX, Limits, Message, MessageType, NeighborStructure,
    RejectCode, Tag,
};

/// Decodes the message at the beginning of `bytes`.
///
/// An ADDRESS_QUERY is complete without its last byte, which not all releases of LF send. [`QueryEnd`](crate::QueryEnd)
/// finds that byte if it comes in a later piece than the others.
///
/// # Errors
/// [`DecodeError`] if no further bytes can make this a message within `limits`.
pub fn decode<'a>(bytes: &'a [u8], limits: &Limits) -> Result<Decoded<'a>, DecodeError> {
    decode_expected(bytes, limits, |_| true)
}

/// Decodes the message at the beginning of `bytes`, if its type is expected. If the expected types are constant, there
/// is no code for others.
///
/// # Errors
/// Those of [`decode`]; and [`DecodeError::Unexpected`].
pub fn decode_expected<'a>(
    bytes: &'a [u8],
    limits: &Limits,
    expects: impl Fn(MessageType) -> bool,
) -> Result<Decoded<'a>, DecodeError> {
    let Some(&first) = bytes.first() else {
        return Ok(Decoded::Incomplete { need: 1, message_type: None });
    };
    let message_type = message_type(first).ok_or(DecodeError::UnknownType { found: first })?;
    let mut fields = Fields { reader: Reader::new(bytes), message_type, limits };
    match fields.message(expects) {
        Ok(message) => Ok(Decoded::Complete { message, len: fields.reader.at() }),
        Err(Stop::Short(Short { need })) => Ok(Decoded::Incomplete { need, message_type: Some(message_type) }),
        Err(Stop::Wrong(error)) => Err(error),
    }
}

/// Decodes the message at the beginning of `bytes`, which the RTI has sent to a transient federate: TIMESTAMP has its
/// long form there.
///
/// # Errors
/// Those of [`decode_expected`].
#[cfg(feature = "transients")]
pub fn decode_to_transient<'a>(
    bytes: &'a [u8],
    limits: &Limits,
    expects: impl Fn(MessageType) -> bool,
) -> Result<Decoded<'a>, DecodeError> {
    let message_type = MessageType::Timestamp;
    if bytes.first() != Some(&byte(message_type)) || !expects(message_type) {
        return decode_expected(bytes, limits, expects);
    }
    let mut reader = Reader::new(bytes);
    if let Err(Short { need }) = reader.require(fixed_bytes(message_type) + Tag::BYTES) {
        return Ok(Decoded::Incomplete { need, message_type: Some(message_type) });
    }
    reader.u8();
    let message = Message::EffectiveStart { start: reader.i64(), tag: reader.tag() };
    Ok(Decoded::Complete { message, len: reader.at() })
}

/// Returns the tag of the message at the beginning of `bytes`, if it has a tag and a payload, and everything but the
/// payload is there.
pub fn tag_in_header(bytes: &[u8]) -> Option<Tag> {
    let message_type = message_type(*bytes.first()?)?;
    if !matches!(message_type, MessageType::TaggedMessage | MessageType::P2pTaggedMessage) {
        return None;
    }
    // The tag is the last of the header's fields.
    let header = bytes.get(..fixed_bytes(message_type))?;
    Some(Reader::new(header.get(header.len() - Tag::BYTES..)?).tag())
}

/// Returns the destination of the message at the beginning of `bytes`, if it has a payload, and its length is there:
/// also if it is longer than any limit.
pub fn destination_in_header(bytes: &[u8]) -> Option<Destination> {
    const TO_LENGTH: usize = size_of::<u16>() + size_of::<u16>() + size_of::<u32>();
    let message_type = message_type(*bytes.first()?)?;
    let has_payload =
        matches!(message_type, MessageType::TaggedMessage | MessageType::P2pTaggedMessage | MessageType::P2pMessage);
    let mut reader = Reader::new(bytes.get(1..=TO_LENGTH)?);
    if !has_payload {
        return None;
    }
    Some(Destination { port: reader.u16(), federate: reader.u16(), payload_bytes: reader.u32() })
}

/// Returns the length in bytes of the longest message that `limits` accept: a receive buffer has to hold it.
pub const fn message_bytes_max(limits: &Limits) -> usize {
    let id = if limits.federation_id_bytes_max < FEDERATION_ID_BYTES_MAX {
        limits.federation_id_bytes_max
    } else {
        FEDERATION_ID_BYTES_MAX
    };
    let lengths = [
        fixed_bytes(MessageType::RtiResponse),
        fixed_bytes(MessageType::TransientFedIds) + id,
        fixed_bytes(MessageType::TaggedMessage).saturating_add(limits.payload_bytes_max),
        fixed_bytes(MessageType::NeighborStructure)
            .saturating_add(limits.neighbors_max.saturating_mul(UPSTREAM_BYTES + DOWNSTREAM_BYTES)),
    ];
    let mut max = 0;
    let mut i = 0;
    while i < lengths.len() {
        if lengths[i] > max {
            max = lengths[i];
        }
        i += 1;
    }
    max
}

/// The reason why there is no message.
enum Stop {
    Short(Short),
    Wrong(DecodeError),
}

impl From<Short> for Stop {
    fn from(short: Short) -> Self {
        Self::Short(short)
    }
}

/// Reads the fields of one message.
struct Fields<'a, 'l> {
    reader: Reader<'a>,
    message_type: MessageType,
    limits: &'l Limits,
}

impl<'a> Fields<'a, '_> {
    fn message(&mut self, expects: impl Fn(MessageType) -> bool) -> Result<Message<'a>, Stop> {
        // After this check all fields of a fixed length are there.
        self.reader.require(fixed_bytes(self.message_type))?;
        self.reader.u8();
        let reader = &mut self.reader;
        Ok(match self.message_type {
            MessageType::Reject if expects(MessageType::Reject) => Message::Reject(RejectCode::from_byte(reader.u8())),
            MessageType::Timestamp if expects(MessageType::Timestamp) => Message::Timestamp(reader.i64()),
            MessageType::Resign if expects(MessageType::Resign) => Message::Resign,
            MessageType::NextEventTag if expects(MessageType::NextEventTag) => Message::NextEventTag(reader.tag()),
            MessageType::TagGrant if expects(MessageType::TagGrant) => Message::TagGrant(reader.tag()),
            MessageType::ProvisionalTagGrant if expects(MessageType::ProvisionalTagGrant) => {
                Message::ProvisionalTagGrant(reader.tag())
            }
            MessageType::LatestTagComplete if expects(MessageType::LatestTagComplete) => {
                Message::LatestTagComplete(reader.tag())
            }
            MessageType::StopRequest if expects(MessageType::StopRequest) => Message::StopRequest(reader.tag()),
            MessageType::StopReply if expects(MessageType::StopReply) => Message::StopReply(reader.tag()),
            MessageType::StopGranted if expects(MessageType::StopGranted) => Message::StopGranted(reader.tag()),
            MessageType::AddressQueryReply if expects(MessageType::AddressQueryReply) => {
                Message::AddressQueryReply { port: reader.i32(), address: reader.array() }
            }
            #[cfg(feature = "ipv6")]
            MessageType::AddressQueryReplyIpv6 if expects(MessageType::AddressQueryReplyIpv6) => {
                let (port, address, scope) = (reader.i32(), reader.array(), reader.u32());
                Message::AddressQueryReplyIpv6 { port, address, scope }
            }
            MessageType::AddressAdvertisement if expects(MessageType::AddressAdvertisement) => {
                Message::AddressAdvertisement { port: reader.i32() }
            }
            MessageType::T1 if expects(MessageType::T1) => Message::T1(reader.i64()),
            MessageType::T3 if expects(MessageType::T3) => Message::T3 { federate: reader.u16() },
            MessageType::T4 if expects(MessageType::T4) => Message::T4(reader.i64()),
            MessageType::CodedProbe if expects(MessageType::CodedProbe) => Message::CodedProbe(reader.i64()),
            MessageType::Failed if expects(MessageType::Failed) => Message::Failed,
            MessageType::DownstreamNextEventTag if expects(MessageType::DownstreamNextEventTag) => {
                Message::DownstreamNextEventTag(reader.tag())
            }
            MessageType::UpstreamDisconnected if expects(MessageType::UpstreamDisconnected) => {
                Message::UpstreamDisconnected { federate: reader.u16() }
            }
            #[cfg(feature = "transients")]
            MessageType::UpstreamConnected if expects(MessageType::UpstreamConnected) => {
                Message::UpstreamConnected { federate: reader.u16() }
            }
            #[cfg(feature = "transients")]
            MessageType::Stop if expects(MessageType::Stop) => Message::Stop,
            #[cfg(feature = "transients")]
            MessageType::OutboundConnected if expects(MessageType::OutboundConnected) => {
                Message::OutboundConnected { federate: reader.u16() }
            }
            #[cfg(feature = "transients")]
            MessageType::OutboundDisconnected if expects(MessageType::OutboundDisconnected) => {
                Message::OutboundDisconnected { federate: reader.u16() }
            }
            MessageType::UdpPort if expects(MessageType::UdpPort) => Message::UdpPort(reader.u16()),
            MessageType::Ack if expects(MessageType::Ack) => Message::Ack,
            _ => self.long_message(expects)?,
        })
    }

    /// Reads a message with more than a tag, a time or an address, or that only the RTI reads.
    fn long_message(&mut self, expects: impl Fn(MessageType) -> bool) -> Result<Message<'a>, Stop> {
        let reader = &mut self.reader;
        Ok(match self.message_type {
            MessageType::FedIds if expects(MessageType::FedIds) => {
                let (federate, length) = (reader.u16(), self.federation_id_length()?);
                Message::FedIds { federate, federation_id: self.reader.take(length)? }
            }
            MessageType::TaggedMessage if expects(MessageType::TaggedMessage) => {
                let (port, federate, tag, payload) = self.tagged()?;
                Message::TaggedMessage { port, federate, tag, payload }
            }
            MessageType::TransientFedIds if expects(MessageType::TransientFedIds) => {
                let (federate, length) = (reader.u16(), self.federation_id_length()?);
                let kind = self.reader.u8();
                Message::TransientFedIds { federate, kind, federation_id: self.reader.take(length)? }
            }
            MessageType::AddressQuery if expects(MessageType::AddressQuery) => {
                Message::AddressQuery { federate: reader.u16(), is_transient: reader.flag() }
            }
            MessageType::P2pSendingFedId if expects(MessageType::P2pSendingFedId) => {
                let (federate, is_transient) = (reader.u16(), reader.flag());
                reader.require(reader.at() + 1)?;
                let length = self.federation_id_length()?;
                Message::P2pSendingFedId { federate, is_transient, federation_id: self.reader.take(length)? }
            }
            MessageType::P2pMessage if expects(MessageType::P2pMessage) => {
                let (port, federate, length) = (reader.u16(), reader.u16(), self.payload_length()?);
                Message::P2pMessage { port, federate, payload: self.reader.take(length)? }
            }
            MessageType::P2pTaggedMessage if expects(MessageType::P2pTaggedMessage) => {
                let (port, federate, tag, payload) = self.tagged()?;
                Message::P2pTaggedMessage { port, federate, tag, payload }
            }
            MessageType::PortAbsent if expects(MessageType::PortAbsent) => {
                Message::PortAbsent { port: reader.u16(), federate: reader.u16(), tag: reader.tag() }
            }
            MessageType::NeighborStructure if expects(MessageType::NeighborStructure) => {
                Message::NeighborStructure(self.neighbors()?)
            }
            MessageType::FedNonce if expects(MessageType::FedNonce) => {
                Message::FedNonce { federate: reader.u16(), nonce: reader.array() }
            }
            MessageType::RtiResponse if expects(MessageType::RtiResponse) => {
                Message::RtiResponse { nonce: reader.array(), hmac: reader.array() }
            }
            MessageType::FedResponse if expects(MessageType::FedResponse) => {
                Message::FedResponse { hmac: reader.array() }
            }
            message => return Err(Stop::Wrong(DecodeError::Unexpected { message })),
        })
    }

    fn federation_id_length(&mut self) -> Result<usize, Stop> {
        let offset = self.reader.at();
        let found = self.reader.u8().into();
        self.within("federation id length", offset, found, self.limits.federation_id_bytes_max)
    }

    fn tagged(&mut self) -> Result<(u16, u16, Tag, &'a [u8]), Stop> {
        let (port, federate) = (self.reader.u16(), self.reader.u16());
        let length = self.payload_length()?;
        let tag = self.reader.tag();
        Ok((port, federate, tag, self.reader.take(length)?))
    }

    fn neighbors(&mut self) -> Result<NeighborStructure<'a>, Stop> {
        let upstream = self.neighbor_count("upstream count")?.saturating_mul(UPSTREAM_BYTES);
        let downstream = self.neighbor_count("downstream count")?.saturating_mul(DOWNSTREAM_BYTES);
        self.reader.require(self.reader.at().saturating_add(upstream).saturating_add(downstream))?;
        Ok(NeighborStructure::from_bytes(self.reader.take(upstream)?, self.reader.take(downstream)?))
    }

    fn payload_length(&mut self) -> Result<usize, Stop> {
        let offset = self.reader.at();
        let found = self.reader.u32();
        self.within("payload length", offset, found, self.limits.payload_bytes_max)
    }

    fn neighbor_count(&mut self, field: &'static str) -> Result<usize, Stop> {
        let offset = self.reader.at();
        let found = self.reader.i32();
        let message = self.message_type;
        let count =
            u32::try_from(found).map_err(|_| Stop::Wrong(DecodeError::Negative { message, field, offset, found }))?;
        self.within(field, offset, count, self.limits.neighbors_max)
    }

    /// Returns the length that was found at `offset`, unless it is above `limit`.
    fn within(&self, field: &'static str, offset: usize, found: u32, limit: usize) -> Result<usize, Stop> {
        let message = self.message_type;
        usize::try_from(found).ok().filter(|length| *length <= limit).ok_or(Stop::Wrong(DecodeError::OverLimit {
            message,
            field,
            offset,
            found,
            limit,
        }))
    }
}
