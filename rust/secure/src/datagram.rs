// SPDX-License-Identifier: Apache-2.0
//! Datagrams under keys of a connection: each is encrypted, numbered, and accepted at most once and in order.

use zeroize::Zeroizing;

use crate::cipher::{TAG_BYTES, decrypt, encrypt};
use crate::keys::KEY_BYTES;

/// The length of the name of the receiver's connection, which the receiver has chosen.
const NAME_BYTES: usize = 4;
/// The length of the number.
const NUMBER_BYTES: usize = 8;
/// The number of bytes that a datagram is longer than its content.
pub const DATAGRAM_OVERHEAD: usize = NAME_BYTES + NUMBER_BYTES + TAG_BYTES;

/// The keys and counters of the datagrams of one connection.
pub struct DatagramKeys {
    sending: Zeroizing<[u8; KEY_BYTES]>,
    receiving: Zeroizing<[u8; KEY_BYTES]>,
    /// The name that the other end has given to its connection.
    remote_name: u32,
    /// The number of the next datagram to send.
    next: u64,
    /// The smallest number that is accepted.
    least: u64,
}

impl DatagramKeys {
    pub(crate) fn new([sending, receiving]: [Zeroizing<[u8; KEY_BYTES]>; 2], remote_name: u32) -> Self {
        Self { sending, receiving, remote_name, next: 0, least: 0 }
    }

    /// Returns the name of the connection that a datagram is for, if it is long enough to have one.
    pub fn name_in(datagram: &[u8]) -> Option<u32> {
        datagram.first_chunk().copied().map(u32::from_be_bytes)
    }

    /// Encrypts a datagram into `buffer` and returns its length, or `None` if that is too short.
    pub fn seal(&mut self, content: &[u8], buffer: &mut [u8]) -> Option<usize> {
        let len = content.len() + DATAGRAM_OVERHEAD;
        let (head, rest) = buffer.get_mut(..len)?.split_at_mut(NAME_BYTES + NUMBER_BYTES);
        let (text, tag) = rest.split_last_chunk_mut()?;
        let (name, number) = head.split_first_chunk_mut()?;
        *name = self.remote_name.to_be_bytes();
        number.copy_from_slice(&self.next.to_be_bytes());
        text.copy_from_slice(content);
        *tag = encrypt(&self.sending, self.next, name, text);
        self.next = self.next.saturating_add(1);
        Some(len)
    }

    /// Decrypts a datagram in place and returns its content, or `None` if it is not one of this connection that is
    /// newer than all before: then it has no effect.
    pub fn open<'d>(&mut self, datagram: &'d mut [u8]) -> Option<&'d mut [u8]> {
        let (name, rest) = datagram.split_first_chunk_mut::<NAME_BYTES>()?;
        let (number, rest) = rest.split_first_chunk_mut()?;
        let (text, tag) = rest.split_last_chunk_mut()?;
        let number = u64::from_be_bytes(*number);
        if number < self.least || number == u64::MAX {
            return None;
        }
        decrypt(&self.receiving, number, name, text, tag).ok()?;
        self.least = number + 1;
        Some(text)
    }
}

impl core::fmt::Debug for DatagramKeys {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("DatagramKeys").field("next", &self.next).field("least", &self.least).finish_non_exhaustive()
    }
}
