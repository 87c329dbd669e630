// SPDX-License-Identifier: Apache-2.0
//! Messages in and out of the stream buffers.

use crate::dialect::{PayloadHeader, decode_expected};
use crate::{DecodeError, Decoded, EncodeError, InBuffer, Limits, Message, MessageType, OutBuffer, PushError, Tag};

impl<B: AsRef<[u8]> + AsMut<[u8]>> InBuffer<B> {
    /// The message at the front and its length in bytes, or `None` if it is not whole yet. It stays there until the
    /// owner drops it with [`consume`](Self::consume).
    ///
    /// # Errors
    /// [`DecodeError`] if the bytes at the front cannot become a message within `limits`, or not in this buffer. They
    /// stay there.
    pub fn next(&self, limits: &Limits) -> Result<Option<(Message<'_>, usize)>, DecodeError> {
        self.next_expected(0, limits, |_| true)
    }

    /// As [`next`](Self::next), but behind the first `held` bytes; a message with more than a tag or a time only if its
    /// type is expected.
    ///
    /// # Errors
    /// As [`next`](Self::next); and [`DecodeError::Unexpected`].
    pub fn next_expected(
        &self,
        held: usize,
        limits: &Limits,
        expects: impl Fn(MessageType) -> bool,
    ) -> Result<Option<(Message<'_>, usize)>, DecodeError> {
        match decode_expected(self.bytes().get(held..).unwrap_or_default(), limits, expects)? {
            Decoded::Complete { message, len } => Ok(Some((message, len))),
            Decoded::Incomplete { need, message_type } if held == 0 && need > self.capacity() => {
                Err(DecodeError::LargerThanBuffer { message: message_type, needed: need, capacity: self.capacity() })
            }
            Decoded::Incomplete { .. } => Ok(None),
        }
    }
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> OutBuffer<B> {
    /// Pushes a message.
    ///
    /// # Errors
    /// [`EncodeError::NoRoom`] if there is less [`room`](Self::room) than [`Message::encoded_len`],
    /// [`EncodeError::Beyond`] if the wire cannot carry the message. Nothing has been pushed then.
    pub fn push(&mut self, message: &Message<'_>) -> Result<(), EncodeError> {
        let len = message.encode(self.claim(message.encoded_len())?)?;
        self.commit(len);
        Ok(())
    }

    /// Pushes a tagged message whose payload `payload` writes in place. It is given exactly `payload_bytes_max` bytes
    /// and returns how many of them it has used, which is returned here too.
    ///
    /// # Errors
    /// [`PushError::Encode`] if there is no room for the longest payload, [`PushError::Payload`] with the error of
    /// `payload`, [`PushError::PayloadOverrun`] if it returns more than it was given. Nothing has been pushed then.
    pub fn push_tagged_with<E>(
        &mut self,
        port: u16,
        federate: u16,
        tag: Tag,
        payload_bytes_max: usize,
        payload: impl FnOnce(&mut [u8]) -> Result<usize, E>,
    ) -> Result<usize, PushError<E>> {
        let header = PayloadHeader { message_type: MessageType::TaggedMessage, port, federate, tag: Some(tag) };
        self.push_payload(header, payload_bytes_max, payload)
    }

    /// As [`push_tagged_with`](Self::push_tagged_with), for a P2P_TAGGED_MESSAGE.
    ///
    /// # Errors
    /// As [`push_tagged_with`](Self::push_tagged_with).
    pub fn push_p2p_tagged_with<E>(
        &mut self,
        port: u16,
        federate: u16,
        tag: Tag,
        payload_bytes_max: usize,
        payload: impl FnOnce(&mut [u8]) -> Result<usize, E>,
    ) -> Result<usize, PushError<E>> {
        let header = PayloadHeader { message_type: MessageType::P2pTaggedMessage, port, federate, tag: Some(tag) };
        self.push_payload(header, payload_bytes_max, payload)
    }

    /// As [`push_tagged_with`](Self::push_tagged_with), for a P2P_MESSAGE, which has no tag.
    ///
    /// # Errors
    /// As [`push_tagged_with`](Self::push_tagged_with).
    pub fn push_p2p_with<E>(
        &mut self,
        port: u16,
        federate: u16,
        payload_bytes_max: usize,
        payload: impl FnOnce(&mut [u8]) -> Result<usize, E>,
    ) -> Result<usize, PushError<E>> {
        let header = PayloadHeader { message_type: MessageType::P2pMessage, port, federate, tag: None };
        self.push_payload(header, payload_bytes_max, payload)
    }

    fn push_payload<E>(
        &mut self,
        header: PayloadHeader,
        payload_bytes_max: usize,
        payload: impl FnOnce(&mut [u8]) -> Result<usize, E>,
    ) -> Result<usize, PushError<E>> {
        let needed = header.bytes().saturating_add(payload_bytes_max);
        let target = self.claim(needed).map_err(|error| PushError::Encode(error.into()))?;
        let (head, body) = target.split_at_mut(header.bytes());
        let written = payload(body).map_err(PushError::Payload)?;
        if written > payload_bytes_max {
            return Err(PushError::PayloadOverrun { written, given: payload_bytes_max });
        }
        header.encode(written, head).map_err(PushError::Encode)?;
        self.commit(header.bytes() + written);
        Ok(written)
    }
}
