// SPDX-License-Identifier: Apache-2.0
//! TLS 1.3 over the connections of a program, by rustls.
//!
//! Each participant has a certificate of its own, and knows those of the others as a whole: there is no authority, and
//! no name or date in a certificate counts. LF's own programs verify nobody and show no certificate as clients, so with
//! them connections can be encrypted and nothing more.

mod session;
#[cfg(test)]
mod tests;
mod verifier;

use std::fmt;
use std::sync::Arc;

use rustls::client::Resumption;
use rustls::crypto::{CryptoProvider, ring};
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName};
use rustls::server::NoServerSessionStorage;
use rustls::sign::{CertifiedKey, SingleCertAndKey};
use rustls::version::TLS13;
use rustls::{ClientConfig, ClientConnection, InconsistentKeys, ServerConfig, ServerConnection};

use crate::keys::TlsKeys;
use crate::sockets::{Encryption, Secured};
use session::Session;
use verifier::Verifier;

/// The name of the server in a handshake, which nobody looks at and which is not sent.
const ANY_NAME: &str = "lf";

/// The settings of all connections of a program.
#[derive(Clone)]
pub struct Tls {
    client: Arc<ClientConfig>,
    server: Arc<ServerConfig>,
    verifier: Arc<Verifier>,
}

/// A certificate and its key that TLS cannot use.
#[derive(Debug)]
pub struct TlsError(String);

impl fmt::Display for TlsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for TlsError {}

impl fmt::Debug for Tls {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tls").field("verifier", &self.verifier).finish_non_exhaustive()
    }
}

impl Tls {
    /// Returns settings by which both ends of each connection prove who they are.
    ///
    /// # Errors
    /// When the participant's certificate and its key do not belong together, or are of a kind that is not supported.
    pub fn verified(keys: TlsKeys) -> Result<Self, TlsError> {
        let own = certified(vec![keys.certificate.into()], &keys.own)?;
        Self::new(own, Verifier::of(keys.others))
    }

    /// Returns settings by which connections are encrypted, with whomever it is: `certificate` and `key` are the texts
    /// of files.
    ///
    /// # Errors
    /// When there is no certificate or no key in them, or they do not belong together.
    pub fn unverified(certificate: &[u8], key: &[u8]) -> Result<Self, TlsError> {
        let chain: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(certificate).collect();
        let chain = chain.ok().filter(|chain| !chain.is_empty());
        let chain = chain.ok_or_else(|| TlsError("there is no certificate (PEM) in the first file".to_owned()))?;
        Self::new(certified(chain, key)?, Verifier::of_anybody())
    }

    fn new(own: CertifiedKey, verifier: Verifier) -> Result<Self, TlsError> {
        let (own, verifier) = (Arc::new(SingleCertAndKey::from(own)), Arc::new(verifier));
        let unsupported = |error: rustls::Error| TlsError(format!("TLS cannot be set up: {error}"));
        let mut client = ClientConfig::builder_with_provider(provider())
            .with_protocol_versions(&[&TLS13])
            .map_err(unsupported)?
            .dangerous()
            .with_custom_certificate_verifier(verifier.clone())
            .with_client_cert_resolver(own.clone());
        client.enable_sni = false;
        client.resumption = Resumption::disabled();
        let mut server = ServerConfig::builder_with_provider(provider())
            .with_protocol_versions(&[&TLS13])
            .map_err(unsupported)?
            .with_client_cert_verifier(verifier.clone())
            .with_cert_resolver(own);
        server.session_storage = Arc::new(NoServerSessionStorage {});
        server.send_tls13_tickets = 0;
        Ok(Self { client: Arc::new(client), server: Arc::new(server), verifier })
    }
}

impl Encryption for Tls {
    fn connecting(&self) -> Option<Box<dyn Secured>> {
        let name = ServerName::try_from(ANY_NAME).ok()?;
        let connection = ClientConnection::new(self.client.clone(), name).ok()?;
        Some(Box::new(Session::new(connection.into(), self.verifier.clone())))
    }

    fn accepting(&self) -> Option<Box<dyn Secured>> {
        let connection = ServerConnection::new(self.server.clone()).ok()?;
        Some(Box::new(Session::new(connection.into(), self.verifier.clone())))
    }
}

/// Returns whether a secret key, as PEM, is that of a certificate in DER; `None` if one of them is neither.
pub fn is_pair(secret: &[u8], certificate: &[u8]) -> Option<bool> {
    let key = PrivateKeyDer::from_pem_slice(secret).ok()?;
    match CertifiedKey::from_der(vec![certificate.to_vec().into()], key, &provider()) {
        Ok(_) => Some(true),
        Err(rustls::Error::InconsistentKeys(InconsistentKeys::KeyMismatch)) => Some(false),
        Err(_) => None,
    }
}

fn certified(chain: Vec<CertificateDer<'static>>, key: &[u8]) -> Result<CertifiedKey, TlsError> {
    let key = PrivateKeyDer::from_pem_slice(key)
        .map_err(|_| TlsError("there is no secret key (PEM) in the file of the key".to_owned()))?;
    CertifiedKey::from_der(chain, key, &provider()).map_err(|error| match error {
        rustls::Error::InconsistentKeys(InconsistentKeys::KeyMismatch) => {
            TlsError("the certificate and the key do not belong together".to_owned())
        }
        error => TlsError(format!("the certificate or the key cannot be used: {error}")),
    })
}

fn provider() -> Arc<CryptoProvider> {
    Arc::new(ring::default_provider())
}
