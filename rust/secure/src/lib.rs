// SPDX-License-Identifier: Apache-2.0
//! Encrypted and authenticated connections between the participants of a federation, without a heap and without I/O.
//!
//! A [`Keyring`] has the keys of one participant. A [`Channel`] is one end of a connection: its owner passes it what
//! the network brings and takes what has to be sent, as from the state machines of `lf-coordination`. A [`Handshake`]
//! is one of the Noise Protocol Framework (revision 34), by X25519, ChaCha20-Poly1305 and SHA-256; [`Pattern::XX_PSK0`]
//! is the one that channels use. Random numbers come from the owner.
#![no_std]
#![forbid(unsafe_code)]

mod channel;
mod cipher;
#[cfg(feature = "datagrams")]
mod datagram;
mod error;
mod handshake;
mod keyring;
mod keys;
mod pattern;
mod symmetric;

pub use channel::{Channel, ChannelStage, HANDSHAKE_BYTES, MARK, RECORD_OVERHEAD, REKEY_RECORDS};
#[cfg(feature = "datagrams")]
pub use datagram::{DATAGRAM_OVERHEAD, DatagramKeys};
pub use error::{ChannelError, HandshakeError, Hint};
pub use handshake::{Handshake, HandshakeKeys, Session};
pub use keyring::{Keyring, Member, Participant};
pub use keys::{FederationSecret, KEY_BYTES, PublicKey, StaticSecret};
pub use pattern::{Pattern, Role, Token};
