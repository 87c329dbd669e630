// SPDX-License-Identifier: Apache-2.0
//! Handshake patterns of Noise, as data.

/// An end of a connection.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Role {
    /// The end that connects, and begins the handshake.
    Initiator,
    /// The end that accepts.
    Responder,
}

/// A step of a handshake message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Token {
    /// The sender's ephemeral public key.
    E,
    /// The sender's static public key.
    S,
    /// The shared secret of both ephemeral keys.
    Ee,
    /// That of the initiator's ephemeral and the responder's static key.
    Es,
    /// That of the initiator's static and the responder's ephemeral key.
    Se,
    /// That of both static keys.
    Ss,
    /// The federation's secret.
    Psk,
}

/// A handshake pattern.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Pattern {
    /// The name of the whole protocol.
    pub protocol: &'static str,
    /// Whether the responder knows the initiator's static key before.
    pub knows_initiator: bool,
    /// Whether the initiator knows the responder's static key before.
    pub knows_responder: bool,
    /// The messages, the first of which is the initiator's.
    pub messages: &'static [&'static [Token]],
}

impl Pattern {
    /// Both ends show their static keys, encrypted, and only to those that know the federation's secret.
    pub const XX_PSK0: Self = Self {
        protocol: "Noise_XXpsk0_25519_ChaChaPoly_SHA256",
        knows_initiator: false,
        knows_responder: false,
        messages: &[&[Token::Psk, Token::E], &[Token::E, Token::Ee, Token::S, Token::Es], &[Token::S, Token::Se]],
    };

    /// Returns whether the federation's secret is part of it: then ephemeral keys count as key material, too.
    pub(crate) fn has_psk(&self) -> bool {
        self.messages.iter().any(|tokens| tokens.contains(&Token::Psk))
    }
}
