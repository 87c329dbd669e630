// SPDX-License-Identifier: Apache-2.0
//! Files of keys: who may read and change them, and what is in them.
//!
//! They are in the usual formats (PEM around PKCS #8 and X.509), so that other tools read and make them, too.

use std::fmt;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, Read};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use rustix::fs::OFlags;

/// The length of a key of X25519, and of the federation's secret, in bytes.
pub const KEY_BYTES: usize = 32;
/// The label of a secret key.
const SECRET_LABEL: &str = "PRIVATE KEY";
/// The label of a public key.
const PUBLIC_LABEL: &str = "PUBLIC KEY";
/// The label of a certificate.
const CERTIFICATE_LABEL: &str = "CERTIFICATE";
/// The label of the federation's secret.
const FEDERATION_LABEL: &str = "LF FEDERATION SECRET";

/// The bytes before a secret key of X25519 in PKCS #8 (RFC 8410).
const SECRET_PREFIX: [u8; 16] =
    [0x30, 0x2e, 0x02, 0x01, 0x00, 0x30, 0x05, 0x06, 0x03, 0x2b, 0x65, 0x6e, 0x04, 0x22, 0x04, 0x20];
/// The bytes before a public key of X25519 in X.509's form (RFC 8410).
const PUBLIC_PREFIX: [u8; 12] = [0x30, 0x2a, 0x30, 0x05, 0x06, 0x03, 0x2b, 0x65, 0x6e, 0x03, 0x21, 0x00];

/// The longest file that can have a key or a certificate in it, in bytes.
const FILE_BYTES_MAX: u64 = 1 << 16;
/// The permissions of others to read a file, to change it or to run it.
const OTHERS: u32 = 0o077;
/// The permissions of others to change a file.
const OTHERS_WRITE: u32 = 0o022;

/// The reason why a file or a folder of keys is not used.
#[derive(Debug)]
pub struct KeyError {
    /// The file or the folder.
    pub path: PathBuf,
    /// The reason.
    pub fault: KeyFault,
}

/// A fault of a file of keys.
#[derive(Debug)]
pub enum KeyFault {
    /// The system's error.
    System(io::Error),
    /// It is a folder, a pipe or a device.
    NoFile,
    /// It is longer than any key.
    TooLong,
    /// Others may read it; these are its permissions.
    ReadableByOthers(u32),
    /// Others may change it; these are its permissions.
    WritableByOthers(u32),
    /// It is not complete, or is of another format: this was expected.
    Malformed(&'static str),
    /// It has a secret key where a public one is expected.
    SecretInstead,
    /// It has a public key where a secret one is expected.
    PublicInstead,
    /// It is of another kind of encryption, for which this has to be in a program.
    OtherKind(&'static str),
    /// The public key beside it is another one.
    Unpaired(PathBuf),
}

impl fmt::Display for KeyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.path.display();
        match &self.fault {
            KeyFault::System(error) if error.kind() == io::ErrorKind::NotFound => write!(f, "there is no file {path}"),
            KeyFault::System(error) => write!(f, "{path} cannot be read: {error}"),
            KeyFault::NoFile => write!(f, "{path} is no file, and a key is expected there"),
            KeyFault::TooLong => write!(f, "{path} is no file with a key: it has more than {FILE_BYTES_MAX} bytes"),
            KeyFault::ReadableByOthers(mode) => {
                write!(f, "{path} is a secret, and other users may read it (mode {mode:04o}): ")?;
                write!(f, "if nobody has, `chmod 600 {path}`, and else make a new key")
            }
            KeyFault::WritableByOthers(mode) => {
                write!(f, "other users may change {path} (mode {mode:04o}), and with it whom this program trusts: ")?;
                write!(f, "`chmod go-w {path}`, and compare the fingerprints of `lfz keys show`")
            }
            KeyFault::Malformed(expected) => {
                write!(f, "{path} is not complete, or is no {expected}: copy it again from where it was made")
            }
            KeyFault::SecretInstead => {
                write!(f, "{path} has a secret key, and a public one is expected there: hand nobody secret keys")
            }
            KeyFault::PublicInstead => write!(f, "{path} has a public key, and a secret one is expected there"),
            KeyFault::OtherKind(word) => write!(f, "{path} is a key for programs with `{word}`, and not for this one"),
            KeyFault::Unpaired(public) => {
                let public = public.display();
                write!(f, "{path} and {public} do not belong together: one of them was swapped for another one")
            }
        }
    }
}

impl std::error::Error for KeyError {}

impl KeyFault {
    /// Returns the error of a file.
    pub fn at(self, path: &Path) -> KeyError {
        KeyError { path: path.to_owned(), fault: self }
    }
}

/// Returns the contents of a file that only its owner can read.
///
/// # Errors
/// When others can read or change it, or it cannot be read.
pub fn read_secret(path: &Path) -> Result<Vec<u8>, KeyError> {
    read(path, |mode| if mode & OTHERS == 0 { Ok(()) } else { Err(KeyFault::ReadableByOthers(mode)) })
}

/// Returns the contents of a file that only its owner can change.
///
/// # Errors
/// When others can change it, or it cannot be read.
pub fn read_public(path: &Path) -> Result<Vec<u8>, KeyError> {
    read(path, |mode| if mode & OTHERS_WRITE == 0 { Ok(()) } else { Err(KeyFault::WritableByOthers(mode)) })
}

/// Refuses a folder whose files others can replace.
///
/// # Errors
/// When others can, or there is none.
pub fn check_folder(path: &Path) -> Result<(), KeyError> {
    let at = |fault: KeyFault| fault.at(path);
    let mode = permissions(&path.metadata().map_err(|error| at(KeyFault::System(error)))?);
    if mode & OTHERS_WRITE == 0 { Ok(()) } else { Err(at(KeyFault::WritableByOthers(mode))) }
}

/// Returns the contents of a file, the permissions of which are acceptable. They are those of the opened file, however
/// its name changes meanwhile.
fn read(path: &Path, accept: impl Fn(u32) -> Result<(), KeyFault>) -> Result<Vec<u8>, KeyError> {
    let open = || -> Result<Vec<u8>, KeyFault> {
        // A pipe without a writer must not make this program wait.
        let flags = OFlags::NONBLOCK.bits().cast_signed();
        let file = OpenOptions::new().read(true).custom_flags(flags).open(path).map_err(KeyFault::System)?;
        let metadata = file.metadata().map_err(KeyFault::System)?;
        if !metadata.is_file() {
            return Err(KeyFault::NoFile);
        }
        accept(permissions(&metadata))?;
        contents(&file)
    };
    open().map_err(|fault| fault.at(path))
}

fn contents(file: &File) -> Result<Vec<u8>, KeyFault> {
    let mut bytes = Vec::new();
    file.take(FILE_BYTES_MAX + 1).read_to_end(&mut bytes).map_err(KeyFault::System)?;
    if bytes.len() as u64 > FILE_BYTES_MAX { Err(KeyFault::TooLong) } else { Ok(bytes) }
}

fn permissions(metadata: &Metadata) -> u32 {
    metadata.mode() & 0o7777
}

/// Returns the secret key of X25519 in the text of a file.
///
/// # Errors
/// When there is none.
pub fn secret_key(text: &[u8]) -> Result<[u8; KEY_BYTES], KeyFault> {
    let part = only_part(text, "secret key of X25519 (PEM, PKCS #8)")?;
    match part.tag() {
        SECRET_LABEL => raw(part.contents(), &SECRET_PREFIX).ok_or(KeyFault::OtherKind("comm-type: TLS")),
        PUBLIC_LABEL | CERTIFICATE_LABEL => Err(KeyFault::PublicInstead),
        _ => Err(KeyFault::Malformed("secret key of X25519 (PEM, PKCS #8)")),
    }
}

/// Returns the public key of X25519 in the text of a file.
///
/// # Errors
/// When there is none.
pub fn public_key(text: &[u8]) -> Result<[u8; KEY_BYTES], KeyFault> {
    let part = only_part(text, "public key of X25519 (PEM)")?;
    match part.tag() {
        PUBLIC_LABEL => raw(part.contents(), &PUBLIC_PREFIX).ok_or(KeyFault::Malformed("public key of X25519 (PEM)")),
        CERTIFICATE_LABEL => Err(KeyFault::OtherKind("comm-type: TLS")),
        tag if is_secret(tag) => Err(KeyFault::SecretInstead),
        _ => Err(KeyFault::Malformed("public key of X25519 (PEM)")),
    }
}

/// Returns the federation's secret in the text of a file.
///
/// # Errors
/// When there is none.
pub fn federation_secret(text: &[u8]) -> Result<[u8; KEY_BYTES], KeyFault> {
    let part = only_part(text, "secret of a federation")?;
    let secret = (part.tag() == FEDERATION_LABEL).then(|| raw(part.contents(), &[])).flatten();
    secret.ok_or(KeyFault::Malformed("secret of a federation"))
}

/// Returns the certificate in the text of a file, in DER.
///
/// # Errors
/// When there is none.
pub fn certificate(text: &[u8]) -> Result<Vec<u8>, KeyFault> {
    let part = only_part(text, "certificate (PEM)")?;
    match part.tag() {
        CERTIFICATE_LABEL => Ok(part.into_contents()),
        PUBLIC_LABEL => Err(KeyFault::OtherKind("security: noise")),
        tag if is_secret(tag) => Err(KeyFault::SecretInstead),
        _ => Err(KeyFault::Malformed("certificate (PEM)")),
    }
}

/// Returns the text of a file with a secret key.
pub fn secret_text(key: &[u8; KEY_BYTES]) -> String {
    text(SECRET_LABEL, &[&SECRET_PREFIX[..], key].concat())
}

/// Returns the text of a file with a public key.
pub fn public_text(key: &[u8; KEY_BYTES]) -> String {
    text(PUBLIC_LABEL, &[&PUBLIC_PREFIX[..], key].concat())
}

/// Returns the text of a file with a certificate, given in DER.
pub fn certificate_text(der: &[u8]) -> String {
    text(CERTIFICATE_LABEL, der)
}

/// Returns the text of a file with the federation's secret.
pub fn federation_text(secret: &[u8; KEY_BYTES]) -> String {
    text(FEDERATION_LABEL, secret)
}

fn text(label: &str, contents: &[u8]) -> String {
    let config = pem::EncodeConfig::new().set_line_ending(pem::LineEnding::LF);
    pem::encode_config(&pem::Pem::new(label, contents), config)
}

fn is_secret(label: &str) -> bool {
    label.ends_with(SECRET_LABEL) || label == FEDERATION_LABEL
}

/// Returns the only part of a file.
fn only_part(text: &[u8], expected: &'static str) -> Result<pem::Pem, KeyFault> {
    let parts = pem::parse_many(text).unwrap_or_default();
    let [part]: [pem::Pem; 1] = parts.try_into().map_err(|_| KeyFault::Malformed(expected))?;
    Ok(part)
}

/// Returns the key behind a prefix.
fn raw(contents: &[u8], prefix: &[u8]) -> Option<[u8; KEY_BYTES]> {
    contents.strip_prefix(prefix)?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    fn file(folder: &tempfile::TempDir, name: &str, text: &str, mode: u32) -> PathBuf {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("it can be written");
        fs::set_permissions(&path, fs::Permissions::from_mode(mode)).expect("it is ours");
        path
    }

    #[test]
    fn keys_are_the_same_after_writing_and_reading() {
        let key: [u8; KEY_BYTES] = core::array::from_fn(|index| u8::try_from(index * 7).unwrap_or(0));
        assert_eq!(secret_key(secret_text(&key).as_bytes()).expect("it is one"), key);
        assert_eq!(public_key(public_text(&key).as_bytes()).expect("it is one"), key);
        assert_eq!(federation_secret(federation_text(&key).as_bytes()).expect("it is one"), key);
    }

    /// `openssl genpkey -algorithm X25519`, and `openssl pkey -pubout` of it.
    #[test]
    fn keys_of_openssl_are_understood() {
        let secret = "-----BEGIN PRIVATE KEY-----\n\
                      MC4CAQAwBQYDK2VuBCIEINgnfjrlvD+UCLyKEOG34rUfSfdHbH2K85Ru9Mc12W9N\n\
                      -----END PRIVATE KEY-----\n";
        let public = "-----BEGIN PUBLIC KEY-----\n\
                      MCowBQYDK2VuAyEAF30+10XOP7xrem6WC1a0Am58pJC8Rn1oDuJ+NlQ3xWk=\n\
                      -----END PUBLIC KEY-----\n";
        let (own, shown) = (secret_key(secret.as_bytes()), public_key(public.as_bytes()));
        let (own, shown) = (own.expect("it is one"), shown.expect("it is one"));
        assert_eq!((own[..4].to_vec(), shown[..2].to_vec()), (vec![0xd8, 0x27, 0x7e, 0x3a], vec![0x17, 0x7d]));
        // The same text comes out again.
        assert_eq!((secret_text(&own), public_text(&shown)), (secret.to_owned(), public.to_owned()));
    }

    #[test]
    fn each_mistake_has_a_sentence_of_its_own() {
        let key = [7; KEY_BYTES];
        let (secret, public, federation) = (secret_text(&key), public_text(&key), federation_text(&key));
        let certificate_text = text(CERTIFICATE_LABEL, &[0x30, 0]);
        let told = |fault: KeyFault| fault.at(Path::new("k")).to_string();
        let not_secret = |text: &str| told(secret_key(text.as_bytes()).expect_err("it is none"));
        let not_public = |text: &str| told(public_key(text.as_bytes()).expect_err("it is none"));
        assert_eq!(not_secret(&public), "k has a public key, and a secret one is expected there");
        assert!(not_public(&secret).contains("hand nobody secret keys"));
        assert!(not_public(&federation).contains("hand nobody secret keys"));
        assert!(not_public(&certificate_text).contains("`comm-type: TLS`"));
        assert!(not_secret(&text(SECRET_LABEL, &[0x30, 0])).contains("`comm-type: TLS`"));
        assert!(told(certificate(public.as_bytes()).expect_err("it is none")).contains("`security: noise`"));
        for cut in [0, 1, 30, secret.len() - 30, secret.len() - 2] {
            assert!(not_secret(&secret[..cut]).contains("is not complete"), "{cut}");
        }
        // Two keys in one file are none: which one is meant?
        assert!(not_secret(&format!("{secret}{secret}")).contains("is not complete"));
        assert!(told(federation_secret(secret.as_bytes()).expect_err("it is none")).contains("secret of a federation"));
    }

    #[test]
    fn files_that_others_can_read_or_change_are_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for mode in [0o640, 0o604, 0o660, 0o666] {
            let path = file(&folder, "a b.key", "", mode);
            let error = read_secret(&path).expect_err("others can read it").to_string();
            assert!(error.contains("`chmod 600 ") && error.contains(&format!("{mode:04o}")), "{error}");
        }
        for mode in [0o600, 0o400] {
            assert!(read_secret(&file(&folder, "right.key", "", mode)).is_ok());
        }
        for mode in [0o664, 0o646] {
            let error = read_public(&file(&folder, "a.pub", "", mode)).expect_err("others can change it").to_string();
            assert!(error.contains("`chmod go-w "), "{error}");
        }
        assert!(read_public(&file(&folder, "b.pub", "", 0o644)).is_ok());
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o770)).expect("it is ours");
        assert!(check_folder(folder.path()).expect_err("others can change it").to_string().contains("0770"));
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o700)).expect("it is ours");
        assert!(check_folder(folder.path()).is_ok());
    }

    /// None of these makes a program wait, or read without end.
    #[test]
    fn what_is_no_file_is_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let pipe = folder.path().join("pipe");
        let mode = rustix::fs::Mode::from_raw_mode(0o600);
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, mode, 0).expect("it can be made");
        for path in [&pipe, folder.path()] {
            assert!(read_secret(path).expect_err("it is no file").to_string().contains("is no file"));
        }
        let long = file(&folder, "long", &"x".repeat(70_000), 0o600);
        assert!(read_secret(&long).expect_err("it is too long").to_string().contains("65536"));
        let missing = read_secret(&folder.path().join("missing")).expect_err("there is none").to_string();
        assert!(missing.starts_with("there is no file "));
        // A link is what it leads to.
        let open = file(&folder, "open", "", 0o644);
        std::os::unix::fs::symlink(&open, folder.path().join("link")).expect("it can be made");
        assert!(read_secret(&folder.path().join("link")).is_err());
    }
}
