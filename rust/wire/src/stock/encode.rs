// SPDX-License-Identifier: Apache-2.0
//! Messages to bytes.

use super::layouts::{byte, fixed_bytes};
use crate::bytes::Writer;
use crate::{EncodeError, LengthOverflow, Message, MessageType, NeighborStructure, Tag};

/// Writes a message to the beginning of `target` and returns its length in bytes.
///
/// # Errors
/// [`EncodeError::NoRoom`] if `target` is shorter than [`encoded_len`], [`EncodeError::LengthOverflow`] if a part of
/// the message is longer than its length field can hold. Nothing has been written then.
pub(crate) fn encode(message: &Message<'_>, target: &mut [u8]) -> Result<usize, EncodeError> {
    let lengths = message.lengths()?;
    let len = encoded_len(message);
    let mut writer = Writer::new(target, len)?;
    writer.u8(byte(message.message_type()));
    message.write(&mut writer, lengths);
    Ok(len)
}

/// Returns the length of a message in bytes, type byte included.
pub(crate) fn encoded_len(message: &Message<'_>) -> usize {
    let variable = match message {
        Message::AddressQuery { is_transient, .. } => usize::from(is_transient.is_some()),
        Message::P2pSendingFedId { federation_id, is_transient, .. } => {
            federation_id.len().saturating_add(usize::from(is_transient.is_some()))
        }
        Message::FedIds { federation_id: bytes, .. }
        | Message::TransientFedIds { federation_id: bytes, .. }
        | Message::TaggedMessage { payload: bytes, .. }
        | Message::P2pMessage { payload: bytes, .. }
        | Message::P2pTaggedMessage { payload: bytes, .. } => bytes.len(),
        Message::NeighborStructure(neighbors) => neighbors.entries_bytes(),
        #[cfg(feature = "transients")]
        Message::EffectiveStart { .. } => Tag::BYTES,
        _ => 0,
    };
    fixed_bytes(message.message_type()).saturating_add(variable)
}

impl Message<'_> {
    /// Returns the values of the length fields, checked before the first byte is written; 0 if the message lacks the
    /// field.
    fn lengths(&self) -> Result<[u32; 2], LengthOverflow> {
        let message = self.message_type();
        let checked = |field, length, max| length_field(message, field, length, max);
        Ok(match self {
            Self::FedIds { federation_id, .. }
            | Self::TransientFedIds { federation_id, .. }
            | Self::P2pSendingFedId { federation_id, .. } => {
                [checked("federation id length", federation_id.len(), u8::MAX.into())?, 0]
            }
            Self::TaggedMessage { payload, .. }
            | Self::P2pMessage { payload, .. }
            | Self::P2pTaggedMessage { payload, .. } => [checked(PAYLOAD_LENGTH, payload.len(), u32::MAX)?, 0],
            Self::NeighborStructure(neighbors) => [
                checked("upstream count", neighbors.upstream().len(), i32::MAX.unsigned_abs())?,
                checked("downstream count", neighbors.downstream().len(), i32::MAX.unsigned_abs())?,
            ],
            _ => [0; 2],
        })
    }

    /// Writes everything behind the type byte.
    fn write(&self, writer: &mut Writer<'_>, [length, second_length]: [u32; 2]) {
        match self {
            Self::FedIds { federate, federation_id } => {
                writer.u16(*federate);
                write_id(writer, length, None, federation_id);
            }
            Self::TransientFedIds { federate, kind, federation_id } => {
                writer.u16(*federate);
                write_id(writer, length, Some(*kind), federation_id);
            }
            Self::P2pSendingFedId { federate, is_transient, federation_id } => {
                writer.u16(*federate);
                writer.flag(*is_transient);
                write_id(writer, length, None, federation_id);
            }
            Self::AddressQuery { federate, is_transient } => {
                writer.u16(*federate);
                writer.flag(*is_transient);
            }
            Self::TaggedMessage { port, federate, tag, payload }
            | Self::P2pTaggedMessage { port, federate, tag, payload } => {
                write_destination(writer, *port, *federate, length);
                writer.tag(*tag);
                writer.put(payload);
            }
            Self::P2pMessage { port, federate, payload } => {
                write_destination(writer, *port, *federate, length);
                writer.put(payload);
            }
            Self::NeighborStructure(neighbors) => write_neighbors(writer, [length, second_length], neighbors),
            _ => self.write_fixed(writer),
        }
    }

    /// Writes everything behind the type byte of a message that always has the same length.
    fn write_fixed(&self, writer: &mut Writer<'_>) {
        match self {
            Self::Reject(code) => writer.u8(code.byte()),
            Self::NextEventTag(tag)
            | Self::TagGrant(tag)
            | Self::ProvisionalTagGrant(tag)
            | Self::LatestTagComplete(tag)
            | Self::StopRequest(tag)
            | Self::StopReply(tag)
            | Self::StopGranted(tag)
            | Self::DownstreamNextEventTag(tag) => writer.tag(*tag),
            Self::Timestamp(time) | Self::T1(time) | Self::T4(time) | Self::CodedProbe(time) => writer.i64(*time),
            #[cfg(feature = "transients")]
            Self::EffectiveStart { start, tag } => {
                writer.i64(*start);
                writer.tag(*tag);
            }
            Self::T3 { federate } | Self::UpstreamDisconnected { federate } => writer.u16(*federate),
            #[cfg(feature = "transients")]
            Self::UpstreamConnected { federate }
            | Self::OutboundConnected { federate }
            | Self::OutboundDisconnected { federate } => writer.u16(*federate),
            Self::AddressQueryReply { port, address } => {
                writer.i32(*port);
                writer.put(address);
            }
            #[cfg(feature = "ipv6")]
            Self::AddressQueryReplyIpv6 { port, address, scope } => {
                writer.i32(*port);
                writer.put(address);
                writer.u32(*scope);
            }
            Self::AddressAdvertisement { port } => writer.i32(*port),
            Self::PortAbsent { port, federate, tag } => {
                writer.u16(*port);
                writer.u16(*federate);
                writer.tag(*tag);
            }
            Self::FedNonce { federate, nonce } => {
                writer.u16(*federate);
                writer.put(nonce);
            }
            Self::RtiResponse { nonce, hmac } => {
                writer.put(nonce);
                writer.put(hmac);
            }
            Self::FedResponse { hmac } => writer.put(hmac),
            Self::UdpPort(port) => writer.u16(*port),
            // The others have nothing there.
            _ => {}
        }
    }
}

const PAYLOAD_LENGTH: &str = "payload length";

/// Returns the value of a length field, unless it exceeds the maximum of the field.
fn length_field(message: MessageType, field: &'static str, length: usize, max: u32) -> Result<u32, LengthOverflow> {
    let found = u32::try_from(length).ok().filter(|length| *length <= max);
    found.ok_or(LengthOverflow { message, field, length, max })
}

/// Writes a federation id behind its length, and the kind of a federate between them if there is one.
fn write_id(writer: &mut Writer<'_>, length: u32, kind: Option<u8>, federation_id: &[u8]) {
    writer.u8(length.to_le_bytes()[0]);
    if let Some(kind) = kind {
        writer.u8(kind);
    }
    writer.put(federation_id);
}

/// Writes the destination of a payload, and its length.
fn write_destination(writer: &mut Writer<'_>, port: u16, federate: u16, length: u32) {
    writer.u16(port);
    writer.u16(federate);
    writer.u32(length);
}

fn write_neighbors(writer: &mut Writer<'_>, lengths: [u32; 2], neighbors: &NeighborStructure<'_>) {
    for length in lengths {
        writer.u32(length);
    }
    for (federate, delay) in neighbors.upstream() {
        writer.u16(federate);
        writer.i64(delay);
    }
    neighbors.downstream().for_each(|federate| writer.u16(federate));
}

/// The header of a message whose payload is encoded in place.
#[derive(Clone, Copy)]
pub(crate) struct PayloadHeader {
    pub(crate) message_type: MessageType,
    pub(crate) port: u16,
    pub(crate) federate: u16,
    /// `None` for a message without a tag.
    pub(crate) tag: Option<Tag>,
}

impl PayloadHeader {
    /// Returns the length of the header in bytes.
    pub(crate) const fn bytes(&self) -> usize {
        fixed_bytes(self.message_type)
    }

    /// Writes the header for a payload of `length` bytes to the beginning of `target`.
    pub(crate) fn encode(&self, length: usize, target: &mut [u8]) -> Result<(), EncodeError> {
        let length = length_field(self.message_type, PAYLOAD_LENGTH, length, u32::MAX)?;
        let mut writer = Writer::new(target, self.bytes())?;
        writer.u8(byte(self.message_type));
        writer.u16(self.port);
        writer.u16(self.federate);
        writer.u32(length);
        if let Some(tag) = self.tag {
            writer.tag(tag);
        }
        Ok(())
    }
}
