// SPDX-License-Identifier: Apache-2.0
//! Pairs of a secret and a public part: keys of X25519 for Noise, certificates for TLS.

use std::fmt::Write as _;

use lf_compiler::plan::Security;
use lf_linux::keys::{self, KEY_BYTES, KeyFault};
use lf_secure::StaticSecret;
use sha2::{Digest as _, Sha256};

use super::certificate;
use crate::failure::Failure;

/// The bytes of a key or a hash that a fingerprint shows: nobody makes another key with the same 80 bits.
const FINGERPRINT_BYTES: usize = 10;

/// The kind of a federation's keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum KeyKind {
    Noise,
    Tls,
}

/// The text of both files of a new pair.
pub(super) struct PairText {
    pub(super) secret: String,
    pub(super) public: String,
}

/// The part of a pair that others know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum PublicPart {
    /// A public key of X25519.
    Key([u8; KEY_BYTES]),
    /// A certificate in DER.
    Certificate(Vec<u8>),
}

impl PublicPart {
    /// Returns a text that is as good as unique, and short enough to be compared by eye or on the telephone.
    pub(crate) fn fingerprint(&self) -> String {
        let bytes = match self {
            // Messages about connections show whole keys, which begin with this.
            Self::Key(key) => key.to_vec(),
            Self::Certificate(der) => Sha256::digest(der).to_vec(),
        };
        bytes.iter().take(FINGERPRINT_BYTES).fold(String::new(), |mut text, byte| {
            // Writing to a String cannot fail.
            let _ = write!(text, "{byte:02x}");
            text
        })
    }

    /// Returns whether the secret key in the text of a file belongs to it.
    pub(super) fn is_of(&self, secret: &[u8]) -> Result<bool, KeyFault> {
        match self {
            Self::Key(public) => Ok(StaticSecret::new(keys::secret_key(secret)?).public().bytes() == public),
            Self::Certificate(der) => certificate::is_pair(secret, der),
        }
    }

    /// Returns the text of a file with it.
    pub(crate) fn text(&self) -> String {
        match self {
            Self::Key(key) => keys::public_text(key),
            Self::Certificate(der) => keys::certificate_text(der),
        }
    }
}

impl KeyKind {
    /// Returns the ending of files with public parts.
    pub(super) fn ending(self) -> &'static str {
        match self {
            Self::Noise => keys::PUBLIC,
            Self::Tls => keys::CERTIFICATE,
        }
    }

    /// Returns the target property of programs with this kind.
    pub(super) fn property(self) -> &'static str {
        match self {
            Self::Noise => Security::Noise.property(),
            Self::Tls => Security::Tls.property(),
        }
    }

    pub(super) fn other(self) -> Self {
        match self {
            Self::Noise => Self::Tls,
            Self::Tls => Self::Noise,
        }
    }

    /// Makes a pair for a participant.
    pub(super) fn generate(self, name: &str) -> Result<PairText, Failure> {
        match self {
            Self::Noise => {
                let secret = StaticSecret::new(random()?);
                let public = keys::public_text(secret.public().bytes());
                Ok(PairText { secret: keys::secret_text(secret.bytes()), public })
            }
            Self::Tls => {
                let (secret, public) = certificate::generate(name).map_err(Failure::message)?;
                Ok(PairText { secret, public })
            }
        }
    }

    /// Returns the public part in the text of a file.
    pub(super) fn public_part(self, text: &[u8]) -> Result<PublicPart, KeyFault> {
        match self {
            Self::Noise => keys::public_key(text).map(PublicPart::Key),
            Self::Tls => keys::certificate(text).map(PublicPart::Certificate),
        }
    }
}

/// Returns random bytes of the system.
pub(super) fn random() -> Result<[u8; KEY_BYTES], Failure> {
    let mut bytes = [0; KEY_BYTES];
    getrandom::fill(&mut bytes)
        .map_err(|error| Failure::message(format!("the system gives no random numbers, which keys are: {error}")))?;
    Ok(bytes)
}
