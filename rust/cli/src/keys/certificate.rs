// SPDX-License-Identifier: Apache-2.0
//! Certificates for TLS: each is its participant's own, and the others know it whole, so that no authority is needed.

use lf_linux::keys::KeyFault;
use rcgen::{CertificateParams, DistinguishedName, DnType, KeyPair};

/// Makes a secret key (ECDSA, P-256) and a certificate for it, both as PEM.
pub(super) fn generate(name: &str) -> Result<(String, String), String> {
    let made = || -> Result<_, rcgen::Error> {
        let key = KeyPair::generate()?;
        let mut params = CertificateParams::default();
        params.distinguished_name = DistinguishedName::new();
        params.distinguished_name.push(DnType::CommonName, name);
        let certificate = params.self_signed(&key)?;
        Ok((key.serialize_pem(), certificate.pem()))
    };
    made().map_err(|error| format!("no certificate for {name}: {error}"))
}

/// Returns whether a secret key, as PEM, is that of a certificate in DER.
pub(super) fn is_pair(secret: &[u8], certificate: &[u8]) -> Result<bool, KeyFault> {
    lf_linux::tls::is_pair(secret, certificate).ok_or(KeyFault::Malformed("secret key (PEM)"))
}
