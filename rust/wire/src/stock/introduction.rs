// SPDX-License-Identifier: Apache-2.0
//! P2P_SENDING_FED_ID as far as it has come, for a receiver that knows the expected federation id.

use super::layouts::{byte, fixed_bytes};
use crate::MessageType;
use crate::bytes::Reader;

/// The first bytes of a connection between two federates: all of P2P_SENDING_FED_ID but the federation id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntroductionHeader {
    /// The beginning lacks at least this many bytes.
    Incomplete(usize),
    /// It is another message.
    Other,
    /// The federation id follows.
    From {
        /// The connecting federate's id.
        federate: u16,
        /// Whether it declares to be transient.
        is_transient: bool,
        /// Length of the federation id that it announces, in bytes.
        federation_id_bytes: u8,
    },
}

impl IntroductionHeader {
    /// Bytes before the federation id, at most.
    pub const BYTES_MAX: usize = fixed_bytes(MessageType::P2pSendingFedId) + 1;

    /// Reads the beginning of a connection that has at most a header. The right federation id has `federation_id_bytes`
    /// bytes. The length of an id of one byte is also the mark of a transient federate, and then no federate is taken
    /// for transient.
    pub fn read(bytes: &[u8], federation_id_bytes: usize) -> Self {
        let mut reader = Reader::new(bytes);
        if let Err(short) = reader.require(fixed_bytes(MessageType::P2pSendingFedId)) {
            return Self::Incomplete(short.need - bytes.len());
        }
        if reader.u8() != byte(MessageType::P2pSendingFedId) {
            return Self::Other;
        }
        let federate = reader.u16();
        let is_length = federation_id_bytes == 1 && bytes.get(reader.at()) == Some(&1);
        let is_transient = if is_length { None } else { reader.flag() };
        match reader.require(reader.at() + 1) {
            Err(short) => Self::Incomplete(short.need - bytes.len()),
            Ok(()) => {
                Self::From { federate, is_transient: is_transient == Some(true), federation_id_bytes: reader.u8() }
            }
        }
    }
}
