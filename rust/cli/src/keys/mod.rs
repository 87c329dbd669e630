// SPDX-License-Identifier: Apache-2.0
//! The keys of a federation: a folder that people make once, and what each participant gets of it.
//!
//! The folder has `NAME.key` for the secret key of each participant whose key was made here, `NAME.pub` (with TLS a
//! certificate, `NAME.crt`) for each that is trusted, and with Noise `federation.secret`. It ignores itself for git.

mod certificate;
mod handed_out;
mod header;
mod pair;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use lf_compiler::emit::rti_name;
use lf_compiler::plan::{Plan, Security};
use lf_linux::keys::{self, KeyError, KeyFault};

pub(crate) use handed_out::{HandedOut, KeySource};
use pair::{KeyKind, PublicPart};

use crate::compile::{KEYS, application, read_deployment};
use crate::failure::Failure;
use crate::private_files;

/// The file that keeps git from the others.
const IGNORE: &str = ".gitignore";
const IGNORED: &str = "# Secrets do not belong into a repository.\n*\n";

/// The folder of a federation's keys.
pub(crate) struct KeyStore {
    pub(crate) folder: PathBuf,
    pub(crate) program: String,
    kind: KeyKind,
    /// The RTI, then the federates in order of id.
    names: Vec<String>,
}

/// The keys of one participant in the folder.
pub(crate) struct KeyEntry<'a> {
    pub(crate) name: &'a str,
    /// Its public key or certificate, if it is trusted.
    pub(crate) public: Option<PublicPart>,
    /// Whether its secret key is here.
    pub(crate) has_secret: bool,
}

impl KeyStore {
    /// Returns the folder of a program's keys: a given one, that of the deployment file, or that beside `src`.
    ///
    /// # Errors
    /// When the program does not ask for encryption, or the deployment file is wrong.
    pub(crate) fn of(
        file: &Path,
        plan: &Plan,
        given: Option<&Path>,
        deployment: Option<&Path>,
    ) -> Result<Self, Failure> {
        let deployed = deployment.map(|path| read_deployment(path, plan)).transpose()?;
        let deployed = deployed.and_then(|deployment| deployment.keys).zip(deployment);
        let folder = match (given, deployed) {
            (Some(given), _) => given.to_owned(),
            (None, Some((keys, path))) => path.parent().unwrap_or(Path::new("")).join(keys),
            (None, None) => application(file)?.join(KEYS).join(&plan.name),
        };
        Self::at(folder, plan)
    }

    /// Returns the keys of a program in a folder.
    ///
    /// # Errors
    /// When the program does not ask for encryption.
    pub(crate) fn at(folder: PathBuf, plan: &Plan) -> Result<Self, Failure> {
        let name = &plan.name;
        if !plan.is_federated() {
            return Err(Failure::message(format!("{name} is not federated, so it has no connections and no keys")));
        }
        let kind = match plan.target.security {
            Security::None => {
                return Err(Failure::message(format!(
                    "{name} does not ask for encryption: write `security: noise` into its target declaration"
                )));
            }
            Security::Noise => KeyKind::Noise,
            Security::Tls | Security::UnverifiedTls => KeyKind::Tls,
        };
        let federates = plan.federates.iter().map(|federate| federate.name.clone());
        let names = std::iter::once(rti_name(plan)).chain(federates).collect();
        Ok(Self { folder, program: name.clone(), kind, names })
    }

    /// Returns whether there is such a folder.
    pub(crate) fn exists(&self) -> bool {
        self.folder.exists()
    }

    /// Makes the missing keys of these participants, or of all if there are none. Returns the names of those that have
    /// got some.
    ///
    /// # Errors
    /// When a name is unknown, or files cannot be written.
    pub(crate) fn create(&self, names: &[String]) -> Result<Vec<&str>, Failure> {
        names.iter().try_for_each(|name| self.position(name).map(drop))?;
        private_files::create_folder(&self.folder)?;
        keys::check_folder(&self.folder).map_err(Failure::from)?;
        private_files::create_if_missing(&self.folder.join(IGNORE), IGNORED)?;
        if self.kind == KeyKind::Noise {
            let text = keys::federation_text(&pair::random()?);
            private_files::create_if_missing(&self.folder.join(keys::FEDERATION_SECRET), &text)?;
        }
        let mut made = Vec::new();
        for name in self.names.iter().filter(|name| names.is_empty() || names.contains(name)) {
            let (secret, public) = (self.secret_file(name), self.public_file(name));
            if private_files::is_there(&secret) || private_files::is_there(&public) {
                continue;
            }
            let pair = self.kind.generate(name)?;
            private_files::create_if_missing(&public, &pair.public)?;
            private_files::create_if_missing(&secret, &pair.secret)?;
            made.push(name.as_str());
        }
        Ok(made)
    }

    /// Returns what the folder has of each participant.
    ///
    /// # Errors
    /// When the folder or a file is wrong.
    pub(crate) fn entries(&self) -> Result<Vec<KeyEntry<'_>>, Failure> {
        self.check()?;
        self.names.iter().map(|name| self.entry(name)).collect()
    }

    fn entry<'a>(&self, name: &'a str) -> Result<KeyEntry<'a>, Failure> {
        Ok(KeyEntry { name, public: self.public(name)?, has_secret: self.secret_file(name).exists() })
    }

    /// Trusts a participant's public key or certificate in a file.
    ///
    /// # Errors
    /// When there is none in the file, or the participant has another one.
    pub(crate) fn trust(&self, name: &str, file: &Path) -> Result<PublicPart, Failure> {
        self.position(name)?;
        let text = keys::read_public(file).map_err(Failure::from)?;
        let part = self.kind.public_part(&text).map_err(|fault| Failure::from(fault.at(file)))?;
        private_files::create_folder(&self.folder)?;
        private_files::create_if_missing(&self.folder.join(IGNORE), IGNORED)?;
        self.check()?;
        if let Some(other) = self.public(name)?
            && other != part
        {
            return Err(Failure::message(format!(
                "{name} has another key already, {}, and that of {} is {}: if the old one is lost or was stolen, \
                 `lfz keys distrust` it before",
                other.fingerprint(),
                file.display(),
                part.fingerprint(),
            )));
        }
        let same = |other: &KeyEntry<'_>| other.name != name && other.public.as_ref() == Some(&part);
        if let Some(other) = self.entries()?.iter().find(|other| same(other)) {
            let message =
                format!("{} is the key of {}, and no two participants have one key", file.display(), other.name);
            return Err(Failure::message(message));
        }
        private_files::create_if_missing(&self.public_file(name), &part.text())?;
        Ok(part)
    }

    /// Removes the keys of a participant. Returns its id if it is a federate.
    ///
    /// # Errors
    /// When it had none, or files cannot be removed.
    pub(crate) fn distrust(&self, name: &str) -> Result<Option<u16>, Failure> {
        let position = self.position(name)?;
        self.check()?;
        let files = [self.public_file(name), self.secret_file(name)];
        if !files.iter().any(|file| private_files::is_there(file)) {
            return Err(Failure::message(format!("{name} has no key, so nobody trusts it")));
        }
        files.iter().try_for_each(|file| private_files::remove(file))?;
        Ok(position.checked_sub(1).and_then(|id| u16::try_from(id).ok()))
    }

    /// Returns the public key or certificate of a participant, if it is trusted.
    fn public(&self, name: &str) -> Result<Option<PublicPart>, Failure> {
        let file = self.public_file(name);
        match keys::read_public(&file) {
            Ok(text) => self.kind.public_part(&text).map(Some).map_err(|fault| Failure::from(fault.at(&file))),
            Err(KeyError { fault: KeyFault::System(error), .. }) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(Failure::from(error)),
        }
    }

    /// Refuses a folder that is missing, open to others, or of the other kind of encryption.
    fn check(&self) -> Result<(), Failure> {
        let shown = self.folder.display();
        if !self.exists() {
            return Err(Failure::message(format!(
                "{} has no keys, which would be in {shown}: make them with `lfz keys new`",
                self.program
            )));
        }
        keys::check_folder(&self.folder).map_err(Failure::from)?;
        let other = self.kind.other();
        let mut names = self.names.iter().map(|name| self.folder.join(format!("{name}.{}", other.ending())));
        match names.find(|file| file.exists()) {
            Some(file) => Err(Failure::from(KeyFault::OtherKind(other.property()).at(&file))),
            None => Ok(()),
        }
    }

    fn position(&self, name: &str) -> Result<usize, Failure> {
        self.names.iter().position(|known| known == name).ok_or_else(|| {
            let known = self.names.join(", ");
            Failure::message(format!("{} has no participant `{name}`; it has {known}", self.program))
        })
    }

    fn secret_file(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.key"))
    }

    fn public_file(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.{}", self.kind.ending()))
    }
}

/// Removes the copies of a federate's public key that participants of this program have, where `lfz` has built them.
///
/// # Errors
/// When one cannot be removed.
pub(crate) fn remove_copies(file: &Path, program: &str, id: u16) -> Result<usize, Failure> {
    let builds = application(file)?.join("build/lfz").join(program);
    let mut removed = 0;
    for folder in ["host", "zephyr"].iter().flat_map(|platform| folders_in(&builds.join(platform).join(KEYS))) {
        for ending in [keys::PUBLIC, keys::CERTIFICATE] {
            let copy = folder.join(format!("{id}.{ending}"));
            if copy.exists() {
                private_files::remove(&copy)?;
                removed += 1;
            }
        }
    }
    Ok(removed)
}

fn folders_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).filter(|path| path.is_dir()).collect()
}
