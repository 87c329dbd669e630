// SPDX-License-Identifier: Apache-2.0
//! The log events of connections that are not secure.

use core::fmt;

use lf_coordination::code::{Decode, Encode, Reader, Writer};
use lf_coordination::{Endpoint, IpAddress, Times, coded};
use lf_secure::{ChannelError, Hint, KEY_BYTES, Participant, PublicKey};
use lf_texts::say;

use crate::platform::RandomError;

/// The reason why a connection is not secure.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Insecurity(pub ChannelError);

/// A log event of encrypted connections.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum SecurityEvent {
    /// A connection is not used.
    Connection {
        /// The address of the other end.
        address: IpAddress,
        /// The reason.
        why: Insecurity,
        /// The number of times that this has happened.
        times: Times,
    },
    /// A datagram is ignored.
    Datagram {
        /// Where it claims to come from.
        from: Endpoint,
        /// The number of times that this has happened.
        times: Times,
    },
    /// A connection cannot be encrypted.
    NoRandom(RandomError),
}

impl fmt::Display for SecurityEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Connection { address, why: Insecurity(why), times } => {
                say!(f, "the connection with {address} is not secure and not used: {why}{times}")
            }
            Self::Datagram { from, times } => {
                say!(f, "a datagram that claims to come from {from} is not authentic, or old, and ignored{times}")
            }
            Self::NoRandom(error) => say!(f, "a connection cannot be encrypted: {error}"),
        }
    }
}

coded!(SecurityEvent { Connection { address, why, times }, Datagram { from, times }, NoRandom(error) });

impl Encode for Insecurity {
    fn encode(&self, to: &mut Writer<'_>) {
        match self.0 {
            ChannelError::Plain(byte) => numbers(to, 0, byte.into()),
            ChannelError::Version(byte) => numbers(to, 1, byte.into()),
            ChannelError::Handshake => to.small(2),
            ChannelError::UnknownKey(key) => {
                to.small(3);
                for word in key.bytes().as_chunks().0 {
                    to.number(u64::from_be_bytes(*word));
                }
            }
            ChannelError::Other { expected, found } => {
                to.small(4);
                to.small(number_of(expected));
                to.small(number_of(found));
            }
            ChannelError::Forged => to.small(5),
            ChannelError::Length(bytes) => numbers(to, 6, bytes.into()),
            ChannelError::Refused(hint) => numbers(to, 7, hint.byte().into()),
        }
    }
}

impl Decode for Insecurity {
    fn decode(from: &mut Reader<'_>) -> Option<Self> {
        let kind = from.number()?;
        Some(Self(match kind {
            0 => ChannelError::Plain(u8::decode(from)?),
            1 => ChannelError::Version(u8::decode(from)?),
            2 => ChannelError::Handshake,
            3 => {
                let mut key = [0; KEY_BYTES];
                for word in key.as_chunks_mut().0 {
                    *word = from.number()?.to_be_bytes();
                }
                ChannelError::UnknownKey(PublicKey::new(key))
            }
            4 => ChannelError::Other { expected: participant(from)?, found: participant(from)? },
            5 => ChannelError::Forged,
            6 => ChannelError::Length(u16::decode(from)?),
            7 => ChannelError::Refused(Hint::from_byte(u8::decode(from)?)),
            _ => return None,
        }))
    }
}

fn numbers(to: &mut Writer<'_>, kind: u32, number: u32) {
    to.small(kind);
    to.small(number);
}

/// Returns 0 for the RTI, and one more than its id for a federate.
fn number_of(participant: Participant) -> u32 {
    match participant {
        Participant::Rti => 0,
        Participant::Federate(id) => u32::from(id) + 1,
    }
}

fn participant(from: &mut Reader<'_>) -> Option<Participant> {
    match from.number()?.checked_sub(1) {
        None => Some(Participant::Rti),
        Some(id) => u16::try_from(id).ok().map(Participant::Federate),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reason_can_be_read_from_its_code() {
        let (key, participants) = (PublicKey::new([0xA7; 32]), [Participant::Rti, Participant::Federate(7)]);
        let [expected, found] = participants;
        for error in [
            ChannelError::Plain(1),
            ChannelError::Version(2),
            ChannelError::Handshake,
            ChannelError::UnknownKey(key),
            ChannelError::Other { expected, found },
            ChannelError::Forged,
            ChannelError::Length(9),
            ChannelError::Refused(Hint::Key),
        ] {
            let mut bytes = [0; 128];
            let count = Writer::write(&mut bytes, 7, &Insecurity(error));
            let code = core::str::from_utf8(&bytes[..count]).unwrap();
            let (_, mut reader) = Reader::new(code, |_| "").unwrap();
            assert_eq!(Insecurity::decode(&mut reader), Some(Insecurity(error)));
        }
    }
}
