// SPDX-License-Identifier: Apache-2.0
//! A handshake of the Noise Protocol Framework: the tokens of its pattern, one message after the other.

use zeroize::{Zeroize, ZeroizeOnDrop, Zeroizing};

use crate::cipher::{Cipher, TAG_BYTES};
#[cfg(feature = "datagrams")]
use crate::datagram::DatagramKeys;
use crate::error::HandshakeError;
use crate::keys::{FederationSecret, KEY_BYTES, PublicKey, StaticSecret};
use crate::pattern::{Pattern, Role, Token};
use crate::symmetric::{HASH_BYTES, Symmetric};

/// The purpose of the keys of the connection itself, in Noise's terms: none.
const OF_CONNECTION: &[u8] = &[];
/// The purpose of the keys of datagrams that belong to the connection.
#[cfg(feature = "datagrams")]
const OF_DATAGRAMS: &[u8] = b"lf-zephyr-rs datagrams";

/// The secrets of one end, which a handshake uses but does not keep.
#[derive(Clone, Copy, Debug)]
pub struct HandshakeKeys<'a> {
    /// Its static secret.
    pub secret: &'a StaticSecret,
    /// The public half of the former.
    pub public: &'a PublicKey,
    /// The federation's secret.
    pub federation: &'a FederationSecret,
}

/// One end of a handshake. Call [`Handshake::write`] and [`Handshake::read`] in turns, the initiator first to write,
/// until [`Handshake::is_complete`]; after an error it can only be dropped.
#[derive(Zeroize, ZeroizeOnDrop)]
pub struct Handshake {
    symmetric: Symmetric,
    #[zeroize(skip)]
    pattern: &'static Pattern,
    #[zeroize(skip)]
    role: Role,
    /// The number of messages so far.
    step: u8,
    ephemeral: StaticSecret,
    #[zeroize(skip)]
    remote_ephemeral: Option<PublicKey>,
    #[zeroize(skip)]
    remote_static: Option<PublicKey>,
}

/// The keys of a connection, from a complete handshake.
pub struct Session {
    pub(crate) sending: Cipher,
    pub(crate) receiving: Cipher,
}

impl Handshake {
    /// Begins a handshake. `ephemeral` is new for each connection and random. Both ends have to know the same
    /// `prologue`. `remote` is the other end's static key, where the pattern says that it is known before.
    pub fn new(
        pattern: &'static Pattern,
        role: Role,
        prologue: &[u8],
        credentials: HandshakeKeys<'_>,
        ephemeral: StaticSecret,
        remote: Option<PublicKey>,
    ) -> Self {
        let mut symmetric = Symmetric::new(pattern.protocol);
        symmetric.mix_hash(prologue);
        let (initiator, responder) = match role {
            Role::Initiator => (Some(*credentials.public), remote),
            Role::Responder => (remote, Some(*credentials.public)),
        };
        let known = [initiator.filter(|_| pattern.knows_initiator), responder.filter(|_| pattern.knows_responder)];
        for key in known.iter().flatten() {
            symmetric.mix_hash(key.bytes());
        }
        Self { symmetric, pattern, role, step: 0, ephemeral, remote_ephemeral: None, remote_static: remote }
    }

    /// Returns whether all messages have been sent.
    pub fn is_complete(&self) -> bool {
        usize::from(self.step) == self.pattern.messages.len()
    }

    /// Returns whether the next message is this end's.
    pub fn is_writer(&self) -> bool {
        !self.is_complete() && self.step.is_multiple_of(2) == (self.role == Role::Initiator)
    }

    /// Returns the other end's static key, once it is known. It is proved when the handshake is complete.
    pub fn remote(&self) -> Option<&PublicKey> {
        self.remote_static.as_ref()
    }

    /// Returns the hash of all messages, which both ends have, once the handshake is complete.
    pub fn hash(&self) -> &[u8; HASH_BYTES] {
        self.symmetric.hash()
    }

    /// Writes the next message into `message` and returns its length.
    ///
    /// # Errors
    /// [`HandshakeError::Turn`] if it is not this end's turn, [`HandshakeError::Room`] if `message` is too short,
    /// [`HandshakeError::Key`] for a bad key of the other end.
    pub fn write(
        &mut self,
        credentials: HandshakeKeys<'_>,
        payload: &[u8],
        message: &mut [u8],
    ) -> Result<usize, HandshakeError> {
        let tokens = self.next_tokens(true)?;
        let mut len = 0;
        for token in tokens {
            match token {
                Token::E => {
                    let public = self.ephemeral.public();
                    append(message, &mut len, public.bytes())?;
                    self.mix_ephemeral(&public);
                }
                Token::S => self.append_encrypted(message, &mut len, credentials.public.bytes())?,
                token => self.mix(*token, credentials)?,
            }
        }
        self.append_encrypted(message, &mut len, payload)?;
        self.step += 1;
        Ok(len)
    }

    /// Reads the other end's next message and returns its payload, which is decrypted in place.
    ///
    /// # Errors
    /// [`HandshakeError::Turn`] if it is this end's turn, [`HandshakeError::Forged`] if the message is not authentic or
    /// too short, [`HandshakeError::Key`] for a bad key of the other end.
    pub fn read<'m>(
        &mut self,
        credentials: HandshakeKeys<'_>,
        message: &'m mut [u8],
    ) -> Result<&'m mut [u8], HandshakeError> {
        let tokens = self.next_tokens(false)?;
        let mut rest = message;
        for token in tokens {
            match token {
                Token::E => {
                    let (key, behind) = rest.split_first_chunk_mut().ok_or(HandshakeError::Forged)?;
                    let public = PublicKey::new(*key);
                    rest = behind;
                    self.remote_ephemeral = Some(public);
                    self.mix_ephemeral(&public);
                }
                Token::S => {
                    let tag_bytes = if self.symmetric.has_key() { TAG_BYTES } else { 0 };
                    let parts = rest.split_at_mut_checked(KEY_BYTES + tag_bytes);
                    let (key, behind) = parts.ok_or(HandshakeError::Forged)?;
                    self.symmetric.decrypt_and_hash(key).map_err(|_| HandshakeError::Forged)?;
                    let key = key.first_chunk().ok_or(HandshakeError::Forged)?;
                    self.remote_static = Some(PublicKey::new(*key));
                    rest = behind;
                }
                token => self.mix(*token, credentials)?,
            }
        }
        let count = self.symmetric.decrypt_and_hash(rest).map_err(|_| HandshakeError::Forged)?;
        self.step += 1;
        Ok(rest.get_mut(..count).unwrap_or_default())
    }

    /// Returns the keys of the connection, once the handshake is complete.
    pub fn session(&self) -> Option<Session> {
        let keys = self.is_complete().then(|| self.split(OF_CONNECTION))?;
        let [sending, receiving] = keys.map(Cipher::new);
        Some(Session { sending, receiving })
    }

    /// Returns the keys of datagrams, once the handshake is complete. `remote_name` is the other end's name of its
    /// connection.
    #[cfg(feature = "datagrams")]
    pub fn datagram_keys(&self, remote_name: u32) -> Option<DatagramKeys> {
        let keys = self.is_complete().then(|| self.split(OF_DATAGRAMS))?;
        Some(DatagramKeys::new(keys.map(Zeroizing::new), remote_name))
    }

    /// Returns a key to send and one to receive.
    fn split(&self, purpose: &[u8]) -> [[u8; KEY_BYTES]; 2] {
        let [to_responder, to_initiator] = self.symmetric.split(purpose);
        match self.role {
            Role::Initiator => [to_responder, to_initiator],
            Role::Responder => [to_initiator, to_responder],
        }
    }

    fn next_tokens(&self, writes: bool) -> Result<&'static [Token], HandshakeError> {
        let tokens = self.pattern.messages.get(usize::from(self.step)).copied();
        tokens.filter(|_| self.is_writer() == writes).ok_or(HandshakeError::Turn)
    }

    fn mix_ephemeral(&mut self, public: &PublicKey) {
        self.symmetric.mix_hash(public.bytes());
        if self.pattern.has_psk() {
            self.symmetric.mix_key(public.bytes());
        }
    }

    /// Mixes in what both ends compute for a token.
    fn mix(&mut self, token: Token, credentials: HandshakeKeys<'_>) -> Result<(), HandshakeError> {
        let initiates = self.role == Role::Initiator;
        let (own_is_static, remote_is_static) = match token {
            Token::Psk => {
                self.symmetric.mix_key_and_hash(credentials.federation.bytes());
                return Ok(());
            }
            Token::E | Token::S => return Ok(()),
            Token::Ee => (false, false),
            Token::Ss => (true, true),
            Token::Es => (!initiates, initiates),
            Token::Se => (initiates, !initiates),
        };
        let own = if own_is_static { credentials.secret } else { &self.ephemeral };
        let remote = if remote_is_static { self.remote_static } else { self.remote_ephemeral };
        let shared = remote.and_then(|remote| own.shared_with(&remote)).ok_or(HandshakeError::Key)?;
        self.symmetric.mix_key(Zeroizing::new(shared).as_slice());
        Ok(())
    }

    fn append_encrypted(&mut self, message: &mut [u8], len: &mut usize, bytes: &[u8]) -> Result<(), HandshakeError> {
        let begin = *len;
        append(message, len, bytes)?;
        let tag = self.symmetric.encrypt_and_hash(message.get_mut(begin..*len).unwrap_or_default());
        tag.map_or(Ok(()), |tag| append(message, len, &tag))
    }
}

/// Writes bytes behind the first `len` ones.
fn append(message: &mut [u8], len: &mut usize, bytes: &[u8]) -> Result<(), HandshakeError> {
    let end = *len + bytes.len();
    message.get_mut(*len..end).ok_or(HandshakeError::Room)?.copy_from_slice(bytes);
    *len = end;
    Ok(())
}

impl core::fmt::Debug for Handshake {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Handshake").field("role", &self.role).field("step", &self.step).finish_non_exhaustive()
    }
}

impl core::fmt::Debug for Session {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Session").finish_non_exhaustive()
    }
}

impl Session {
    /// Encrypts the next message in place and returns its tag.
    pub fn seal(&mut self, bytes: &mut [u8]) -> [u8; TAG_BYTES] {
        self.sending.encrypt(&[], bytes)
    }

    /// Decrypts the other end's next message in place.
    ///
    /// # Errors
    /// [`HandshakeError::Forged`] if it is not the next one, or was changed.
    pub fn open(&mut self, bytes: &mut [u8], tag: &[u8; TAG_BYTES]) -> Result<(), HandshakeError> {
        self.receiving.decrypt(&[], bytes, tag).map_err(|_| HandshakeError::Forged)
    }
}
