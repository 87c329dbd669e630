// SPDX-License-Identifier: Apache-2.0
//! How two federates begin a connection with each other.
//!
//! Whoever sends over the connection makes it, and says who it is (`P2P_SENDING_FED_ID`); the other one, to whose
//! address the RTI has led it, answers with ACK or REJECT. There is one connection per direction. What is sent over it
//! afterwards is up to the owners: the untagged messages of physical connections, or tagged ones and absences.

use lf_wire::june_2026::{Decoded, Message, MessageType, RejectCode, decode};
use lf_wire::{DecodeError, Limits};

use crate::FederateId;

/// What a federate that has connected is to be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// Nothing yet: its introduction has at least this many bytes.
    Incomplete(usize),
    /// ACK: it is this federate, and its introduction has this many bytes.
    Welcome(FederateId, usize),
    /// REJECT with this code; the connection is then closed.
    Refuse(RejectCode),
}

/// Judges the first bytes that a federate sends. `is_awaited` says of which federates a connection is still to come.
pub fn judge_arrival(bytes: &[u8], federation_id: &[u8], is_awaited: impl FnOnce(FederateId) -> bool) -> Arrival {
    let header = MessageType::P2pSendingFedId.fixed_bytes();
    if bytes.len() < header {
        return Arrival::Incomplete(header);
    }
    if bytes[0] != MessageType::P2pSendingFedId.byte() {
        return Arrival::Refuse(RejectCode::WrongServer);
    }
    let limits = Limits { federation_id_bytes_max: usize::from(u8::MAX), ..Limits::NONE };
    match decode(bytes, &limits) {
        Ok(Decoded::Incomplete { need, .. }) => Arrival::Incomplete(need),
        Ok(Decoded::Complete { message: Message::P2pSendingFedId { federate, federation_id: theirs }, len }) => {
            if theirs != federation_id {
                Arrival::Refuse(RejectCode::FederationIdMismatch)
            } else if is_awaited(FederateId(federate)) {
                Arrival::Welcome(FederateId(federate), len)
            } else {
                Arrival::Refuse(RejectCode::IdOutOfRange)
            }
        }
        Ok(Decoded::Complete { .. }) | Err(_) => Arrival::Refuse(RejectCode::UnexpectedMessage),
    }
}

/// What a federate to which this one has connected thinks of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
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
pub fn read_answer(bytes: &[u8]) -> Answer {
    match decode(bytes, &Limits::NONE) {
        Ok(Decoded::Incomplete { .. }) => Answer::Incomplete,
        Ok(Decoded::Complete { message: Message::Ack, .. }) => Answer::Accepted,
        Ok(Decoded::Complete { message: Message::Reject(code), .. }) => Answer::Rejected(code),
        Ok(Decoded::Complete { .. }) => Answer::Rejected(RejectCode::UnexpectedMessage),
        Err(error) => Answer::Wrong(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ID: &[u8] = b"Unidentified Federation";

    /// The bytes of recording 52b, in order: a wrong first message, another federation, the right one.
    #[test]
    fn arrivals_are_judged_as_in_the_recording() {
        let judge = |bytes: &[u8]| judge_arrival(bytes, ID, |federate| federate == FederateId(0));
        assert_eq!(judge(&[0x12, 0, 0, 1]), Arrival::Refuse(RejectCode::WrongServer));
        let introduction = |id: &[u8]| [&[0x10, 0, 0, u8::try_from(id.len()).expect("it is short")][..], id].concat();
        let refused = Arrival::Refuse(RejectCode::FederationIdMismatch);
        assert_eq!(judge(&introduction(b"Another Federation")), refused);
        let right = introduction(ID);
        assert_eq!(judge(&right), Arrival::Welcome(FederateId(0), right.len()));
        for length in 0..right.len() {
            assert!(matches!(judge(&right[..length]), Arrival::Incomplete(need) if need > length));
        }
        let stranger = judge_arrival(&right, ID, |_| false);
        assert_eq!(stranger, Arrival::Refuse(RejectCode::IdOutOfRange));
    }

    #[test]
    fn answers_are_told_apart() {
        assert_eq!(read_answer(&[]), Answer::Incomplete);
        assert_eq!(read_answer(&[255]), Answer::Accepted);
        assert_eq!(read_answer(&[0]), Answer::Incomplete);
        assert_eq!(read_answer(&[0, 5]), Answer::Rejected(RejectCode::WrongServer));
        assert_eq!(read_answer(&[4]), Answer::Rejected(RejectCode::UnexpectedMessage));
        assert!(matches!(read_answer(&[99]), Answer::Wrong(_)));
    }
}
