// SPDX-License-Identifier: Apache-2.0
//! The introduction at the beginning of a connection between two federates.
//!
//! The sending federate makes the connection and introduces itself (`P2P_SENDING_FED_ID`); the receiver, whose address
//! came from the RTI, answers with ACK or REJECT. There is one connection per direction. The owners decide what is sent
//! over it afterwards: untagged messages of physical connections, or tagged ones and absences.

use lf_wire::{DecodeError, IntroductionHeader, MessageType, RejectCode};

use crate::FederateId;

/// The reply to a federate that has connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntroductionVerdict {
    /// No reply yet: the introduction lacks at least this many bytes.
    Incomplete(usize),
    /// It introduces itself as this federate: ACK if that one is expected.
    Introduced(FederateId),
    /// REJECT with this code; the connection is then closed.
    Refuse(RejectCode),
    /// It introduces itself as this federate, and as transient: ACK if a transient one is expected.
    Transient(FederateId),
}

/// The introduction of a federate that has connected, as far as it has come. It is compared byte by byte, so that an
/// unknown peer takes no more memory than this.
#[derive(Clone, Copy, Debug, Default)]
pub struct Introduction {
    header: [u8; IntroductionHeader::BYTES_MAX],
    /// Received bytes of the header.
    header_len: usize,
    /// Received bytes of the federation id.
    id_len: usize,
    /// Whether a byte of the federation id differs.
    differs: bool,
}

impl Introduction {
    /// Takes the next bytes, at most as many as are missing.
    pub fn take(&mut self, bytes: &[u8], federation_id: &[u8]) {
        for &byte in bytes {
            if let IntroductionHeader::Incomplete(_) = self.header(federation_id) {
                if let Some(place) = self.header.get_mut(self.header_len) {
                    *place = byte;
                }
                self.header_len += 1;
            } else {
                self.differs |= federation_id.get(self.id_len) != Some(&byte);
                self.id_len += 1;
            }
        }
    }

    fn header(&self, federation_id: &[u8]) -> IntroductionHeader {
        IntroductionHeader::read(self.header.get(..self.header_len).unwrap_or_default(), federation_id.len())
    }

    /// Returns the reply.
    pub fn judge(&self, federation_id: &[u8]) -> IntroductionVerdict {
        match self.header(federation_id) {
            IntroductionHeader::Incomplete(missing) => IntroductionVerdict::Incomplete(missing),
            IntroductionHeader::Other => IntroductionVerdict::Refuse(RejectCode::WrongServer),
            IntroductionHeader::From { federate, is_transient, federation_id_bytes } => {
                match usize::from(federation_id_bytes).checked_sub(self.id_len) {
                    Some(missing @ 1..) => IntroductionVerdict::Incomplete(missing),
                    _ if self.differs || usize::from(federation_id_bytes) != federation_id.len() => {
                        IntroductionVerdict::Refuse(RejectCode::FederationIdMismatch)
                    }
                    _ if is_transient => IntroductionVerdict::Transient(FederateId(federate)),
                    _ => IntroductionVerdict::Introduced(FederateId(federate)),
                }
            }
        }
    }
}

/// The answer of a federate to which this one has connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntroductionReply {
    /// No answer yet.
    Incomplete,
    /// It accepts this federate's messages.
    Accepted,
    /// It refuses them, with this code.
    Rejected(RejectCode),
    /// It is not a federate.
    Wrong(DecodeError),
}

/// Reads the answer to this federate's introduction.
pub fn read_answer(bytes: &[u8]) -> IntroductionReply {
    let Some(&first) = bytes.first() else { return IntroductionReply::Incomplete };
    match (MessageType::from_byte(first), bytes.get(1)) {
        (Some(MessageType::Ack), _) => IntroductionReply::Accepted,
        (Some(MessageType::Reject), None) => IntroductionReply::Incomplete,
        (Some(MessageType::Reject), Some(&code)) => IntroductionReply::Rejected(RejectCode::from_byte(code)),
        (Some(_), _) => IntroductionReply::Rejected(RejectCode::UnexpectedMessage),
        (None, _) => IntroductionReply::Wrong(DecodeError::UnknownType { found: first }),
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    const ID: &[u8] = b"Unidentified Federation";

    /// Passes `piece` bytes at a time to a new introduction, never more than are missing.
    fn judge(bytes: &[u8], id: &[u8], piece: usize) -> IntroductionVerdict {
        let mut introduction = Introduction::default();
        let mut rest = bytes;
        loop {
            let arrival = introduction.judge(id);
            let IntroductionVerdict::Incomplete(missing) = arrival else { return arrival };
            let next = &rest[..rest.len().min(missing).min(piece)];
            if next.is_empty() {
                return arrival;
            }
            introduction.take(next, id);
            rest = &rest[next.len()..];
        }
    }

    /// Returns an introduction of federate 0 as LF 0.12 sends it, and as LF 0.13 does.
    fn introductions(id: &[u8]) -> [Vec<u8>; 2] {
        let length = u8::try_from(id.len()).expect("it is short");
        [[&[16, 0, 0, length][..], id].concat(), [&[16, 0, 0, 0, length][..], id].concat()]
    }

    /// The bytes of recording 52b, in order: a wrong first message, another federation, the right one.
    #[test]
    fn arrivals_of_both_releases_are_judged_as_in_the_recording() {
        for piece in [1, 3, 1000] {
            let judge = |bytes: &[u8]| judge(bytes, ID, piece);
            assert_eq!(judge(&[0x12, 0, 0, 1]), IntroductionVerdict::Refuse(RejectCode::WrongServer));
            let refused = IntroductionVerdict::Refuse(RejectCode::FederationIdMismatch);
            for other in [&b"Another Federation"[..], b"Unidentified Federatiom", &ID[..5], &[ID, b"s"].concat()] {
                assert_eq!(introductions(other).map(|bytes| judge(&bytes)), [refused; 2]);
            }
            for right in introductions(ID) {
                assert_eq!(judge(&right), IntroductionVerdict::Introduced(FederateId(0)));
                for length in 0..right.len() {
                    let IntroductionVerdict::Incomplete(missing) = judge(&right[..length]) else {
                        panic!("{length} bytes")
                    };
                    assert!(missing <= right.len() - length);
                }
            }
        }
    }

    /// A federation id of one byte has its length where a transient federate has its mark.
    #[test]
    fn a_federation_id_of_one_byte_is_understood_in_both_forms() {
        for id in [&b"x"[..], b"\x01", b"\x00"] {
            let found = introductions(id).map(|bytes| judge(&bytes, id, 1));
            assert_eq!(found, [IntroductionVerdict::Introduced(FederateId(0)); 2], "{id:?}");
        }
    }

    #[test]
    fn a_transient_federate_is_known_as_one() {
        let bytes = [&[16, 7, 0, 1, 23][..], ID].concat();
        assert_eq!(judge(&bytes, ID, 1), IntroductionVerdict::Transient(FederateId(7)));
    }

    #[test]
    fn answers_are_told_apart() {
        assert_eq!(read_answer(&[]), IntroductionReply::Incomplete);
        assert_eq!(read_answer(&[255]), IntroductionReply::Accepted);
        assert_eq!(read_answer(&[0]), IntroductionReply::Incomplete);
        assert_eq!(read_answer(&[0, 5]), IntroductionReply::Rejected(RejectCode::WrongServer));
        assert_eq!(read_answer(&[4]), IntroductionReply::Rejected(RejectCode::UnexpectedMessage));
        assert!(matches!(read_answer(&[99]), IntroductionReply::Wrong(_)));
    }
}
