// SPDX-License-Identifier: Apache-2.0
//! The folder of each participant in the build folder, with its own secret and no other.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use lf_compiler::KEYS_HEADER;
use lf_compiler::plan::{Plan, Security};
use lf_linux::keys::{self, KeyFault};

use super::{KeyKind, KeyStore, header};
use crate::compile::KEYS;
use crate::failure::Failure;
use crate::private_files;

/// Where the keys of a run or a build come from.
#[derive(Clone, Copy)]
pub(crate) struct KeySource<'a> {
    /// The main LF file.
    pub(crate) file: &'a Path,
    /// The folder that the user names.
    pub(crate) given: Option<&'a Path>,
    /// The deployment file.
    pub(crate) deployment: Option<&'a Path>,
}

/// The folders of participants.
pub(crate) struct HandedOut {
    /// The folder around them.
    folder: PathBuf,
    security: Security,
    /// Whether the keys are for this run only.
    pub(crate) is_of_run: bool,
    /// The federates without a key, which the RTI refuses.
    pub(crate) strangers: Vec<String>,
}

impl KeySource<'_> {
    /// Returns whether the program asks for encryption, and its keys are still to be made.
    ///
    /// # Errors
    /// When the deployment file is wrong.
    pub(crate) fn is_missing(self, plan: &Plan) -> Result<bool, Failure> {
        let asks = !plan.target.security.is_none() && plan.is_federated();
        Ok(asks && self.given.is_none() && !KeyStore::of(self.file, plan, None, self.deployment)?.exists())
    }

    /// Hands out the keys of these participants below a build folder. Returns `None` if the program asks for no
    /// encryption.
    ///
    /// Where the program has no folder of keys, new ones can be made, which are in no other place.
    ///
    /// # Errors
    /// When keys are missing or wrong.
    pub(crate) fn hand_out(
        self,
        plan: &Plan,
        out: &Path,
        names: &[&str],
        may_be_new: bool,
    ) -> Result<Option<HandedOut>, Failure> {
        let folder = out.join(KEYS);
        if plan.target.security.is_none() || !plan.is_federated() {
            if let Some(given) = self.given {
                let (given, name) = (given.display(), &plan.name);
                return Err(Failure::message(format!(
                    "--keys {given}: {name} does not ask for encryption: write `security: noise` into its target \
                     declaration"
                )));
            }
            // Keys of an earlier build are of no use.
            let _ = fs::remove_dir_all(&folder);
            return Ok(None);
        }
        let store = KeyStore::of(self.file, plan, self.given, self.deployment)?;
        let is_of_run = may_be_new && self.given.is_none() && !store.exists();
        // They are gone at the end of this function, except for what the participants have got.
        let temporary = is_of_run.then(tempfile::tempdir).transpose()?;
        let store = match &temporary {
            None => store,
            Some(temporary) => {
                let store = KeyStore::at(temporary.path().join("keys"), plan)?;
                store.create(&[])?;
                store
            }
        };
        store.check()?;
        private_files::create_folder(&folder)?;
        let mut strangers = BTreeSet::new();
        for name in names {
            store.hand_out(plan, name, &folder.join(name), &mut strangers)?;
        }
        Ok(Some(HandedOut {
            folder,
            security: plan.target.security,
            is_of_run,
            strangers: strangers.into_iter().collect(),
        }))
    }
}

impl HandedOut {
    /// Writes the header with the keys of an image, into its folder: of a federate, of the RTI, or of both.
    ///
    /// # Errors
    /// When keys are wrong, or the file cannot be written.
    pub(crate) fn write_header(&self, image: &str, federate: Option<&str>, rti: Option<&str>) -> Result<(), Failure> {
        let read = |name: Option<&str>| name.map(|name| header::noise_keys(&self.folder.join(name))).transpose();
        let text = header::text(read(federate)?.as_ref(), read(rti)?.as_ref());
        Ok(private_files::replace(&self.folder.join(image).join(KEYS_HEADER), &text)?)
    }

    /// Returns the options by which a program finds its keys. Programs of LF's own compiler, and its RTI, have only
    /// those for their own certificate.
    ///
    /// # Errors
    /// When such a program cannot encrypt as this federation does.
    pub(crate) fn options(&self, name: &str, is_ours: bool) -> Result<Vec<OsString>, Failure> {
        let folder = self.folder.join(name);
        let is_verified = self.security != Security::UnverifiedTls;
        if is_ours && is_verified {
            return Ok(vec!["--keys".into(), folder.into()]);
        }
        if !self.security.is_tls() {
            let message = format!("--rti: only the RTI of lfz encrypts as `{}` asks", self.security.property());
            return Err(Failure::message(message));
        }
        let own = [keys::OWN_CERTIFICATE, keys::OWN_SECRET].map(|file| folder.join(file).into());
        let unverified = is_ours.then(|| "--unverified".into());
        Ok(["--tls".into()].into_iter().chain(own).chain(unverified).collect())
    }
}

impl KeyStore {
    /// Writes the folder of a participant.
    fn hand_out(
        &self,
        plan: &Plan,
        name: &str,
        folder: &Path,
        strangers: &mut BTreeSet<String>,
    ) -> Result<(), Failure> {
        let position = self.position(name)?;
        let mut files = vec![(keys::OWN_SECRET.to_owned(), self.own_secret(name)?)];
        match self.kind {
            KeyKind::Noise => files.push((keys::FEDERATION_SECRET.to_owned(), self.federation_secret()?)),
            KeyKind::Tls => files.push((keys::OWN_CERTIFICATE.to_owned(), self.known(name)?)),
        }
        let others: Vec<u16> = match position.checked_sub(1).and_then(|id| plan.federates.get(id)) {
            None => plan.federates.iter().map(|federate| federate.id).collect(),
            Some(federate) => {
                files.push((format!("{}.{}", keys::RTI, self.kind.ending()), self.known(&self.names[0])?));
                federate.peers_in().into_iter().chain(federate.peers_out()).collect()
            }
        };
        for id in BTreeSet::from_iter(others) {
            let other = &self.names[usize::from(id) + 1];
            match self.public(other)? {
                Some(part) => files.push((format!("{id}.{}", self.kind.ending()), part.text())),
                None => _ = strangers.insert(other.clone()),
            }
        }
        private_files::create_folder(folder)?;
        for (file, text) in &files {
            private_files::replace(&folder.join(file), text)?;
        }
        // What is not trusted any more must not stay.
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            let stays = |(file, _): &(String, String)| entry.file_name() == file.as_str();
            if entry.file_name() != KEYS_HEADER && !files.iter().any(stays) {
                private_files::remove(&entry.path())?;
            }
        }
        Ok(())
    }

    /// Returns the text of a participant's secret key, to which its public part belongs.
    fn own_secret(&self, name: &str) -> Result<String, Failure> {
        let (file, shown) = (self.secret_file(name), self.folder.display());
        let Some(public) = self.public(name)? else {
            return Err(Failure::message(format!("{name} has no key in {shown}: make one with `lfz keys new`")));
        };
        if !private_files::is_there(&file) {
            return Err(Failure::message(format!(
                "the secret key of {name} is not in {shown}: build where it was made, or replace it by \
                 `lfz keys distrust` and `lfz keys new`"
            )));
        }
        let secret = keys::read_secret(&file).map_err(Failure::from)?;
        if !public.is_of(&secret).map_err(|fault| Failure::from(fault.at(&file)))? {
            return Err(Failure::from(KeyFault::Unpaired(self.public_file(name)).at(&file)));
        }
        text_of(secret, &file)
    }

    fn federation_secret(&self) -> Result<String, Failure> {
        let file = self.folder.join(keys::FEDERATION_SECRET);
        let text = keys::read_secret(&file).map_err(Failure::from)?;
        keys::federation_secret(&text).map_err(|fault| Failure::from(fault.at(&file)))?;
        text_of(text, &file)
    }

    /// Returns the text of the public part of a participant that has to be trusted.
    fn known(&self, name: &str) -> Result<String, Failure> {
        let part = self.public(name)?.ok_or_else(|| Failure::from(missing().at(&self.public_file(name))))?;
        Ok(part.text())
    }
}

fn missing() -> KeyFault {
    KeyFault::System(std::io::ErrorKind::NotFound.into())
}

fn text_of(bytes: Vec<u8>, file: &Path) -> Result<String, Failure> {
    String::from_utf8(bytes).map_err(|_| Failure::from(KeyFault::Malformed("PEM").at(file)))
}
