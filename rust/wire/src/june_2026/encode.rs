// SPDX-License-Identifier: Apache-2.0
//! Messages to bytes.

use super::layouts::{byte, fixed_bytes};
use crate::bytes::Writer;
use crate::{Beyond, EncodeError, Message, MessageType, NeighborStructure, NoRoom, Tag};

/// Writes a message to the beginning of `target` and returns its length in bytes.
///
/// # Errors
/// [`EncodeError::NoRoom`] if `target` is shorter than [`encoded_len`], [`EncodeError::Beyond`] if a part of the
/// message is longer than its length field can say. Nothing has been written then.
pub(crate) fn encode(message: &Message<'_>, target: &mut [u8]) -> Result<usize, EncodeError> {
    let lengths = message.lengths()?;
    let len = encoded_len(message);
    let mut writer = Writer::new(target, len)?;
    writer.u8(byte(message.message_type()))?;
    message.write(&mut writer, lengths)?;
    Ok(len)
}

/// Bytes of a message, type byte included.
pub(crate) fn encoded_len(message: &Message<'_>) -> usize {
    let variable = match message {
        Message::FedIds { federation_id: bytes, .. }
        | Message::P2pSendingFedId { federation_id: bytes, .. }
        | Message::TaggedMessage { payload: bytes, .. }
        | Message::P2pMessage { payload: bytes, .. }
        | Message::P2pTaggedMessage { payload: bytes, .. } => bytes.len(),
        Message::NeighborStructure(neighbors) => neighbors.entries_bytes(),
        _ => 0,
    };
    fixed_bytes(message.message_type()).saturating_add(variable)
}

impl Message<'_> {
    /// The values of the length fields, checked before the first byte is written.
    fn lengths(&self) -> Result<Lengths, Beyond> {
        let message = self.message_type();
        match self {
            Self::FedIds { federation_id, .. } | Self::P2pSendingFedId { federation_id, .. } => {
                let field = "federation id length";
                u8::try_from(federation_id.len()).map(Lengths::Id).map_err(|_| Beyond {
                    message,
                    field,
                    length: federation_id.len(),
                    max: u8::MAX.into(),
                })
            }
            Self::TaggedMessage { payload, .. }
            | Self::P2pMessage { payload, .. }
            | Self::P2pTaggedMessage { payload, .. } => payload_length(message, payload.len()).map(Lengths::Payload),
            Self::NeighborStructure(neighbors) => Ok(Lengths::Neighbors(
                neighbor_count(message, "upstream count", neighbors.upstream().len())?,
                neighbor_count(message, "downstream count", neighbors.downstream().len())?,
            )),
            _ => Ok(Lengths::None),
        }
    }

    /// Writes what follows the type byte.
    fn write(&self, writer: &mut Writer<'_>, lengths: Lengths) -> Result<(), NoRoom> {
        match self {
            Self::Reject(code) => writer.u8(code.byte()),
            Self::FedIds { federate, federation_id } | Self::P2pSendingFedId { federate, federation_id } => {
                writer.u16(*federate)?;
                writer.length(lengths)?;
                writer.put(federation_id)
            }
            Self::TaggedMessage { port, federate, tag, payload }
            | Self::P2pTaggedMessage { port, federate, tag, payload } => {
                writer.u16(*port)?;
                writer.u16(*federate)?;
                writer.length(lengths)?;
                writer.tag(*tag)?;
                writer.put(payload)
            }
            Self::P2pMessage { port, federate, payload } => {
                writer.u16(*port)?;
                writer.u16(*federate)?;
                writer.length(lengths)?;
                writer.put(payload)
            }
            Self::NextEventTag(tag)
            | Self::TagGrant(tag)
            | Self::ProvisionalTagGrant(tag)
            | Self::LatestTagComplete(tag)
            | Self::StopRequest(tag)
            | Self::StopReply(tag)
            | Self::StopGranted(tag)
            | Self::DownstreamNextEventTag(tag) => writer.tag(*tag),
            Self::Timestamp(time) | Self::T1(time) | Self::T4(time) | Self::CodedProbe(time) => writer.i64(*time),
            Self::AddressQuery { federate } | Self::T3 { federate } => writer.u16(*federate),
            Self::AddressQueryReply { port, address } => {
                writer.i32(*port)?;
                writer.put(address)
            }
            Self::AddressAdvertisement { port } => writer.i32(*port),
            Self::PortAbsent { port, federate, tag } => {
                writer.u16(*port)?;
                writer.u16(*federate)?;
                writer.tag(*tag)
            }
            Self::NeighborStructure(neighbors) => {
                writer.length(lengths)?;
                write_entries(writer, neighbors)
            }
            Self::FedNonce { federate, nonce } => {
                writer.u16(*federate)?;
                writer.put(nonce)
            }
            Self::RtiResponse { nonce, hmac } => {
                writer.put(nonce)?;
                writer.put(hmac)
            }
            Self::FedResponse { hmac } => writer.put(hmac),
            Self::UdpPort(port) => writer.u16(*port),
            Self::Resign | Self::Failed | Self::Ack => Ok(()),
        }
    }
}

/// The length fields of a message, in the width that they have on the wire.
#[derive(Clone, Copy)]
enum Lengths {
    None,
    Id(u8),
    Payload(u32),
    Neighbors(i32, i32),
}

impl Writer<'_> {
    fn length(&mut self, lengths: Lengths) -> Result<(), NoRoom> {
        match lengths {
            Lengths::None => Ok(()),
            Lengths::Id(length) => self.u8(length),
            Lengths::Payload(length) => self.u32(length),
            Lengths::Neighbors(upstream, downstream) => {
                self.i32(upstream)?;
                self.i32(downstream)
            }
        }
    }
}

fn payload_length(message: MessageType, length: usize) -> Result<u32, Beyond> {
    u32::try_from(length).map_err(|_| Beyond { message, field: "payload length", length, max: u32::MAX })
}

fn neighbor_count(message: MessageType, field: &'static str, length: usize) -> Result<i32, Beyond> {
    i32::try_from(length).map_err(|_| Beyond { message, field, length, max: i32::MAX.unsigned_abs() })
}

fn write_entries(writer: &mut Writer<'_>, neighbors: &NeighborStructure<'_>) -> Result<(), NoRoom> {
    for (federate, delay) in neighbors.upstream() {
        writer.u16(federate)?;
        writer.i64(delay)?;
    }
    neighbors.downstream().try_for_each(|federate| writer.u16(federate))
}

/// What precedes the payload of a message whose payload is encoded in place.
#[derive(Clone, Copy)]
pub(crate) struct PayloadHeader {
    pub(crate) message_type: MessageType,
    pub(crate) port: u16,
    pub(crate) federate: u16,
    /// `None` for a message without a tag.
    pub(crate) tag: Option<Tag>,
}

impl PayloadHeader {
    /// Bytes of the header.
    pub(crate) const fn bytes(&self) -> usize {
        fixed_bytes(self.message_type)
    }

    /// Writes the header for a payload of `length` bytes to the beginning of `target`.
    pub(crate) fn encode(&self, length: usize, target: &mut [u8]) -> Result<(), EncodeError> {
        let length = payload_length(self.message_type, length)?;
        let mut writer = Writer::new(target, self.bytes())?;
        writer.u8(byte(self.message_type))?;
        writer.u16(self.port)?;
        writer.u16(self.federate)?;
        writer.u32(length)?;
        self.tag.map_or(Ok(()), |tag| writer.tag(tag))?;
        Ok(())
    }
}
