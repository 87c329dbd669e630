// SPDX-License-Identifier: Apache-2.0
//! The keys of one participant of an encrypted federation: a folder of files.
//!
//! | file | in it |
//! |---|---|
//! | `own.key` | the participant's secret key |
//! | `own.crt` | with TLS: its certificate |
//! | `federation.secret` | with Noise: the federation's secret |
//! | `rti.pub`, or with TLS `rti.crt` | the public key or the certificate of the RTI |
//! | `0.pub`, or with TLS `0.crt` | that of the federate with this id |
//!
//! A participant without a file here is a stranger. `lfz build` and `lfz run` make these folders, one per participant.

mod file;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

pub use file::{
    KEY_BYTES, KeyError, KeyFault, certificate, certificate_text, check_folder, federation_secret, federation_text,
    public_key, public_text, read_public, read_secret, secret_key, secret_text,
};

/// The file of a participant's own secret key.
pub const OWN_SECRET: &str = "own.key";
/// The file of its own certificate.
pub const OWN_CERTIFICATE: &str = "own.crt";
/// The file of the federation's secret.
pub const FEDERATION_SECRET: &str = "federation.secret";
/// The name of the RTI among those of others.
pub const RTI: &str = "rti";
/// The ending of public keys.
pub const PUBLIC: &str = "pub";
/// The ending of certificates.
pub const CERTIFICATE: &str = "crt";

/// The keys of a participant.
#[derive(Debug)]
pub enum Keys {
    /// Of one whose connections are encrypted by Noise.
    Noise(NoiseKeys),
    /// Of one whose connections are encrypted by TLS.
    Tls(TlsKeys),
}

/// The keys of a participant whose connections are encrypted by Noise.
pub struct NoiseKeys {
    /// Its secret key.
    pub own: [u8; KEY_BYTES],
    /// The federation's secret.
    pub federation: [u8; KEY_BYTES],
    /// The public keys of the others.
    pub others: Others<[u8; KEY_BYTES]>,
}

/// The keys of a participant whose connections are encrypted by TLS.
pub struct TlsKeys {
    /// Its secret key, as PEM.
    pub own: Vec<u8>,
    /// Its certificate, in DER.
    pub certificate: Vec<u8>,
    /// The certificates of the others, in DER.
    pub others: Others<Vec<u8>>,
}

/// The public keys or certificates of the other participants.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Others<K> {
    /// The RTI, unless this is the RTI's own folder.
    pub rti: Option<K>,
    /// The federates, by id.
    pub federates: BTreeMap<u16, K>,
}

impl std::fmt::Debug for NoiseKeys {
    /// Secrets are not printed.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NoiseKeys").field("others", &self.others).finish_non_exhaustive()
    }
}

impl std::fmt::Debug for TlsKeys {
    /// Secrets are not printed.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TlsKeys").field("others", &self.others).finish_non_exhaustive()
    }
}

impl Keys {
    /// Reads the folder of a participant.
    ///
    /// # Errors
    /// When a file is missing, wrong, or open to other users.
    pub fn read(folder: &Path) -> Result<Self, KeyError> {
        check_folder(folder)?;
        let own = folder.join(OWN_SECRET);
        let secret = read_secret(&own)?;
        if folder.join(OWN_CERTIFICATE).exists() {
            let certificate = public_of(&folder.join(OWN_CERTIFICATE), certificate)?;
            let others = Others::read(folder, CERTIFICATE, self::certificate)?;
            return Ok(Self::Tls(TlsKeys { own: secret, certificate, others }));
        }
        let federation = folder.join(FEDERATION_SECRET);
        let shared = read_secret(&federation)?;
        Ok(Self::Noise(NoiseKeys {
            own: secret_key(&secret).map_err(|fault| fault.at(&own))?,
            federation: federation_secret(&shared).map_err(|fault| fault.at(&federation))?,
            others: Others::read(folder, PUBLIC, public_key)?,
        }))
    }
}

impl<K> Others<K> {
    /// Reads the files with this ending.
    fn read(folder: &Path, ending: &str, parse: fn(&[u8]) -> Result<K, KeyFault>) -> Result<Self, KeyError> {
        let mut others = Self { rti: None, federates: BTreeMap::new() };
        let unread = |error| KeyFault::System(error).at(folder);
        for entry in fs::read_dir(folder).map_err(unread)? {
            let path = entry.map_err(unread)?.path();
            if path.extension().is_none_or(|found| found != ending) {
                continue;
            }
            let name = path.file_stem().and_then(|name| name.to_str()).unwrap_or_default();
            if name == RTI {
                others.rti = Some(public_of(&path, parse)?);
            } else if let Ok(id) = name.parse() {
                others.federates.insert(id, public_of(&path, parse)?);
            }
        }
        Ok(others)
    }
}

fn public_of<K>(path: &Path, parse: fn(&[u8]) -> Result<K, KeyFault>) -> Result<K, KeyError> {
    parse(&read_public(path)?).map_err(|fault| fault.at(path))
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt as _;
    use std::path::PathBuf;

    use super::*;

    /// Returns a folder for a participant that knows the RTI and federate 3.
    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let write = |name: &str, text: String| {
            let path: PathBuf = folder.path().join(name);
            fs::write(&path, text).expect("it can be written");
            fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).expect("it is ours");
        };
        write(OWN_SECRET, secret_text(&[1; KEY_BYTES]));
        write(FEDERATION_SECRET, federation_text(&[2; KEY_BYTES]));
        write("rti.pub", public_text(&[3; KEY_BYTES]));
        write("3.pub", public_text(&[4; KEY_BYTES]));
        write("notes.txt", "no key".to_owned());
        folder
    }

    #[test]
    fn a_folder_has_the_keys_of_a_participant() {
        let folder = folder();
        let Keys::Noise(keys) = Keys::read(folder.path()).expect("all are right") else { panic!("they are of Noise") };
        assert_eq!((keys.own[0], keys.federation[0]), (1, 2));
        let federates = BTreeMap::from([(3, [4; KEY_BYTES])]);
        assert_eq!(keys.others, Others { rti: Some([3; KEY_BYTES]), federates });
        assert!(!format!("{keys:?}").contains("own"), "secrets are not printed");
    }

    #[test]
    fn what_is_missing_or_cut_is_named() {
        for name in [OWN_SECRET, FEDERATION_SECRET] {
            let folder = folder();
            fs::remove_file(folder.path().join(name)).expect("it is there");
            let error = Keys::read(folder.path()).expect_err("it is missing").to_string();
            assert!(error.starts_with("there is no file ") && error.ends_with(name), "{error}");
        }
        let folder = folder();
        fs::write(folder.path().join("3.pub"), "-----BEGIN PUBLIC KEY-----\nMCow").expect("it can be written");
        let error = Keys::read(folder.path()).expect_err("it is cut").to_string();
        assert!(error.contains("3.pub is not complete"), "{error}");
    }
}
