// SPDX-License-Identifier: Apache-2.0
//! Messages in and out of the stream buffers.

#[cfg(feature = "transients")]
use crate::dialect::decode_to_transient;
use crate::dialect::{PayloadHeader, decode_expected};
use crate::{DecodeError, Decoded, EncodeError, InBuffer, Limits, Message, MessageType, OutBuffer, PushError, Tag};

impl<B: AsRef<[u8]> + AsMut<[u8]>> InBuffer<B> {
    /// Returns the message at the front and its length in bytes, or `None` if it is incomplete. It stays there until
    /// the owner drops it with [`consume`](Self::consume).
    ///
    /// # Errors
    /// [`DecodeError`] if the bytes at the front cannot become a message within `limits`, or not in this buffer. They
    /// stay there.
    pub fn next(&self, limits: &Limits) -> Result<Option<(Message<'_>, usize)>, DecodeError> {
        self.next_expected(0, limits, |_| true)
    }

    /// Returns the message behind the first `held` bytes, like [`next`](Self::next); one with more than a tag or a time
    /// only if its type is expected.
    ///
    /// # Errors
    /// Those of [`next`](Self::next); and [`DecodeError::Unexpected`].
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

#[cfg(feature = "transients")]
impl<B: AsRef<[u8]> + AsMut<[u8]>> InBuffer<B> {
    /// Returns the message at the front, which the RTI has sent to a transient federate, like [`next`](Self::next).
    ///
    /// # Errors
    /// Those of [`next_expected`](Self::next_expected).
    pub fn next_to_transient(
        &self,
        limits: &Limits,
        expects: impl Fn(MessageType) -> bool,
    ) -> Result<Option<(Message<'_>, usize)>, DecodeError> {
        match decode_to_transient(self.bytes(), limits, expects)? {
            Decoded::Complete { message, len } => Ok(Some((message, len))),
            Decoded::Incomplete { .. } => Ok(None),
        }
    }
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> OutBuffer<B> {
    /// Pushes a message.
    ///
    /// # Errors
    /// [`EncodeError::NoRoom`] if there is less [`room`](Self::room) than [`Message::encoded_len`],
    /// [`EncodeError::LengthOverflow`] if the wire cannot carry the message. Nothing has been pushed then.
    pub fn push(&mut self, message: &Message<'_>) -> Result<(), EncodeError> {
        let len = message.encode(self.claim(message.encoded_len())?)?;
        self.commit(len);
        Ok(())
    }

    /// Pushes a tagged message whose payload `payload` writes in place, into exactly `payload_bytes_max` bytes.
    /// `payload` returns how many of them it has used, and so does this function.
    ///
    /// # Errors
    /// [`PushError::Encode`] if there is no room for the longest payload, [`PushError::Payload`] with the error of
    /// `payload`, [`PushError::PayloadOverrun`] if it returns more than `payload_bytes_max`. Nothing has been pushed
    /// then.
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

    /// Pushes a P2P_TAGGED_MESSAGE, or a P2P_MESSAGE without a tag, like [`push_tagged_with`](Self::push_tagged_with).
    ///
    /// # Errors
    /// Those of [`push_tagged_with`](Self::push_tagged_with).
    pub fn push_p2p_with<E>(
        &mut self,
        port: u16,
        federate: u16,
        tag: Option<Tag>,
        payload_bytes_max: usize,
        payload: impl FnOnce(&mut [u8]) -> Result<usize, E>,
    ) -> Result<usize, PushError<E>> {
        let message_type = tag.map_or(MessageType::P2pMessage, |_| MessageType::P2pTaggedMessage);
        self.push_payload(PayloadHeader { message_type, port, federate, tag }, payload_bytes_max, payload)
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
