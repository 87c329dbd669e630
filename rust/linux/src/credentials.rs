// SPDX-License-Identifier: Apache-2.0
//! The encryption of the connections of a program, as its command line says.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::keys::{KeyError, Keys, NoiseKeys, TlsKeys};
use crate::platform::Linux;

/// The encryption of the connections of a program.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Credentials {
    /// Nothing.
    #[default]
    None,
    /// The keys in this folder, which say how.
    Keys(PathBuf),
    /// TLS with this certificate and its key, with whomever it is.
    Unverified {
        /// The file of the certificate.
        certificate: PathBuf,
        /// The file of its key.
        key: PathBuf,
    },
}

/// The reason why connections cannot be encrypted.
#[derive(Debug)]
pub enum CredentialsError {
    /// The program asks for encryption, and has no keys.
    Missing,
    /// A virtual network has no TLS.
    Virtual,
    /// A file is wrong.
    Key(KeyError),
    /// TLS does not take what is in a folder or a file.
    Tls {
        /// The folder or the file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
}

impl fmt::Display for CredentialsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing => f.write_str(
                "this program encrypts its connections, and has no keys: start it by `lfz run`, or with --keys and the \
                 folder that `lfz build` has made for it",
            ),
            Self::Virtual => f.write_str("a virtual network has no TLS: write `security: noise` instead"),
            Self::Key(error) => error.fmt(f),
            Self::Tls { path, reason } => write!(f, "{}: {reason}", path.display()),
        }
    }
}

impl std::error::Error for CredentialsError {}

impl From<KeyError> for CredentialsError {
    fn from(error: KeyError) -> Self {
        Self::Key(error)
    }
}

impl Credentials {
    /// Encrypts the connections of a program by TLS, or returns the keys for Noise.
    ///
    /// # Errors
    /// When keys are missing or wrong.
    pub(crate) fn encrypt(&self, host: &mut Linux) -> Result<Option<NoiseKeys>, CredentialsError> {
        match self {
            Self::None => Ok(None),
            Self::Keys(folder) => match Keys::read(folder)? {
                Keys::Noise(keys) => Ok(Some(keys)),
                Keys::Tls(_) if host.is_virtual() => Err(CredentialsError::Virtual),
                Keys::Tls(keys) => verified(host, folder, keys).map(|()| None),
            },
            Self::Unverified { .. } if host.is_virtual() => Err(CredentialsError::Virtual),
            Self::Unverified { certificate, key } => unverified(host, certificate, key).map(|()| None),
        }
    }
}

#[cfg(feature = "tls")]
fn verified(host: &mut Linux, folder: &Path, keys: TlsKeys) -> Result<(), CredentialsError> {
    use crate::tls::Tls;
    let tls = Tls::verified(keys);
    host.encrypt(Box::new(
        tls.map_err(|error| CredentialsError::Tls { path: folder.to_owned(), reason: error.to_string() })?,
    ));
    Ok(())
}

#[cfg(feature = "tls")]
fn unverified(host: &mut Linux, certificate: &Path, key: &Path) -> Result<(), CredentialsError> {
    use crate::keys::{read_public, read_secret};
    use crate::tls::Tls;
    let tls = Tls::unverified(&read_public(certificate)?, &read_secret(key)?);
    let path = || certificate.to_owned();
    host.encrypt(Box::new(tls.map_err(|error| CredentialsError::Tls { path: path(), reason: error.to_string() })?));
    Ok(())
}

#[cfg(not(feature = "tls"))]
fn verified(_host: &mut Linux, folder: &Path, _keys: TlsKeys) -> Result<(), CredentialsError> {
    Err(CredentialsError::without_tls(folder))
}

#[cfg(not(feature = "tls"))]
fn unverified(_host: &mut Linux, certificate: &Path, _key: &Path) -> Result<(), CredentialsError> {
    Err(CredentialsError::without_tls(certificate))
}

#[cfg(not(feature = "tls"))]
impl CredentialsError {
    fn without_tls(path: &Path) -> Self {
        let reason = "this program has no TLS in it: write `comm-type: TLS` into its target declaration".to_owned();
        Self::Tls { path: path.to_owned(), reason }
    }
}
