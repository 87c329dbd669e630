// SPDX-License-Identifier: Apache-2.0
//! How two federates begin a connection with each other.
//!
//! Whoever sends over the connection makes it, and says who it is (`P2P_SENDING_FED_ID`); the other one, to whose
//! address the RTI has led it, answers with ACK or REJECT. There is one connection per direction. What is sent over it
//! afterwards is up to the owners: the untagged messages of physical connections, or tagged ones and absences.

use lf_wire::{DecodeError, Decoded, Limits, Message, MessageType, RejectCode, decode};

use crate::FederateId;

/// Bytes of `P2P_SENDING_FED_ID` before the federation id.
const HEADER_BYTES: usize = MessageType::P2pSendingFedId.fixed_bytes();

/// What a federate that has connected is to be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VisitorReply {
    /// Nothing yet: its introduction has at least this many bytes more.
    Incomplete(usize),
    /// It says that it is this federate: ACK if that one is awaited.
    Introduced(FederateId),
    /// REJECT with this code; the connection is then closed.
    Refuse(RejectCode),
}

/// The introduction of whoever has connected, as far as it has come. It is compared byte by byte, so that nobody who is
/// not known takes more memory than this.
#[derive(Clone, Copy, Debug, Default)]
pub struct Introduction {
    header: [u8; HEADER_BYTES],
    taken: usize,
    /// A byte of the federation id was another one.
    differs: bool,
}

impl Introduction {
    /// Takes what has come next, which has to be at most as many bytes as are missing.
    pub fn take(&mut self, bytes: &[u8], federation_id: &[u8]) {
        for &byte in bytes {
            match self.taken.checked_sub(HEADER_BYTES) {
                None => self.header[self.taken] = byte,
                Some(place) => self.differs |= federation_id.get(place) != Some(&byte),
            }
            self.taken += 1;
        }
    }

    /// What is to be told.
    pub fn judge(&self, federation_id: &[u8]) -> VisitorReply {
        if self.taken < HEADER_BYTES {
            return VisitorReply::Incomplete(HEADER_BYTES - self.taken);
        }
        let [message_type, low, high, length] = self.header;
        if message_type != MessageType::P2pSendingFedId.byte() {
            return VisitorReply::Refuse(RejectCode::WrongServer);
        }
        let whole = HEADER_BYTES + usize::from(length);
        if self.taken < whole {
            return VisitorReply::Incomplete(whole - self.taken);
        }
        if self.differs || usize::from(length) != federation_id.len() {
            return VisitorReply::Refuse(RejectCode::FederationIdMismatch);
        }
        VisitorReply::Introduced(FederateId(u16::from_le_bytes([low, high])))
    }
}

/// What a federate to which this one has connected thinks of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntroductionReply {
    /// Nothing yet.
    Incomplete,
    /// It takes this federate's messages.
    Accepted,
    /// It does not, and why.
    Rejected(RejectCode),
    /// It is no federate.
    Wrong(DecodeError),
}

/// Reads the answer to this federate's introduction.
pub fn read_answer(bytes: &[u8]) -> IntroductionReply {
    match decode(bytes, &Limits::NONE) {
        Ok(Decoded::Incomplete { .. }) => IntroductionReply::Incomplete,
        Ok(Decoded::Complete { message: Message::Ack, .. }) => IntroductionReply::Accepted,
        Ok(Decoded::Complete { message: Message::Reject(code), .. }) => IntroductionReply::Rejected(code),
        Ok(Decoded::Complete { .. }) => IntroductionReply::Rejected(RejectCode::UnexpectedMessage),
        Err(error) => IntroductionReply::Wrong(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ID: &[u8] = b"Unidentified Federation";

    /// Gives so many bytes at a time to a new introduction, never more than it says are missing.
    fn judge(bytes: &[u8], piece: usize) -> VisitorReply {
        let mut introduction = Introduction::default();
        let mut rest = bytes;
        loop {
            let arrival = introduction.judge(ID);
            let VisitorReply::Incomplete(missing) = arrival else { return arrival };
            let next = &rest[..rest.len().min(missing).min(piece)];
            if next.is_empty() {
                return arrival;
            }
            introduction.take(next, ID);
            rest = &rest[next.len()..];
        }
    }

    /// The bytes of recording 52b, in order: a wrong first message, another federation, the right one.
    #[test]
    fn arrivals_are_judged_as_in_the_recording() {
        let introduction = |id: &[u8]| [&[0x10, 0, 0, u8::try_from(id.len()).expect("it is short")][..], id].concat();
        for piece in [1, 3, 1000] {
            let judge = |bytes: &[u8]| judge(bytes, piece);
            assert_eq!(judge(&[0x12, 0, 0, 1]), VisitorReply::Refuse(RejectCode::WrongServer));
            let refused = VisitorReply::Refuse(RejectCode::FederationIdMismatch);
            for other in [&b"Another Federation"[..], b"Unidentified Federatiom", &ID[..5], b"", &[ID, b"s"].concat()] {
                assert_eq!(judge(&introduction(other)), refused);
            }
            let right = introduction(ID);
            assert_eq!(judge(&right), VisitorReply::Introduced(FederateId(0)));
            for length in 0..right.len() {
                let VisitorReply::Incomplete(missing) = judge(&right[..length]) else { panic!("{length} bytes") };
                assert!(missing <= right.len() - length);
            }
        }
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
