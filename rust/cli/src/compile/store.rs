// SPDX-License-Identifier: Apache-2.0
//! The store of cargo's files of all programs, in one folder:
//!
//! - `runtime/KEY`: the crates of this repository, compiled once for all programs that need them alike. Its lock is
//!   held while cargo brings them up to date, and while a program takes them over.
//! - `programs/KEY`: the intermediate results of one program, with hard links to files of the former. Its lock is held
//!   while the program is compiled, so different programs are compiled side by side.
//!
//! Of both only the latest are kept, and of programs only those whose generated crates are still there. The folder
//! `editor` has what rust-analyzer has cargo check; cargo itself locks it.

use std::fs::{self, File};
use std::hash::{DefaultHasher, Hash, Hasher as _};
use std::io::{self, ErrorKind};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use rustix::fs::{FlockOperation, flock};

use super::files;
use crate::terminal;

/// The maximum number of compiled runtimes: they differ by target language, features and the kind of build. Each takes
/// about 200 MB.
const RUNTIMES_MAX: usize = 8;

/// The maximum number of programs with intermediate results, at some 5 MB each, beside shared files.
const PROGRAMS_MAX: usize = 64;

/// The file that names the owner of a folder's intermediate results: the folder of the generated crates.
const OWNER: &str = "owner";

/// The kind of what tools of editors have cargo check.
const EDITOR: &str = "editor";

/// The folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Store {
    folder: PathBuf,
}

/// A folder in the store that no other process uses meanwhile.
#[derive(Debug)]
pub(super) struct Locked {
    pub(super) folder: PathBuf,
    /// The system unlocks it when it is closed, also when this program is killed.
    _lock: File,
}

/// The bytes that were freed on the disk, and the folders that are still in use.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Freed {
    /// In bytes.
    pub(crate) size: u64,
    /// Folders with a running build.
    pub(crate) busy: Vec<PathBuf>,
}

impl Store {
    pub(super) fn new(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// Returns the compiled runtime for programs with these needs.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(super) fn runtime(&self, needs: &str) -> io::Result<Locked> {
        self.lock("runtime", &format!("{:016x}", hash_of(needs)), RUNTIMES_MAX, "the runtime crates")
    }

    /// Returns the intermediate results of the program whose crates are generated in a folder.
    ///
    /// # Errors
    /// When they cannot be written.
    pub(super) fn program(&self, out: &Path) -> io::Result<Locked> {
        let locked = self.lock("programs", &program_key(out), PROGRAMS_MAX, "this program")?;
        files::write_changed(&locked.folder.join(OWNER), &out.to_string_lossy())?;
        Ok(locked)
    }

    /// Returns the folder for what tools of editors have cargo check.
    pub(super) fn editor(&self) -> PathBuf {
        self.folder.join(EDITOR).join("check")
    }

    /// Removes the stored files of the program whose crates are generated in a folder.
    ///
    /// # Errors
    /// When something cannot be removed.
    pub(crate) fn forget_program(&self, out: &Path, freed: &mut Freed) -> io::Result<()> {
        remove_unused(&self.folder.join("programs").join(program_key(out)), freed)
    }

    /// Removes all stored files.
    ///
    /// # Errors
    /// When something cannot be removed.
    pub(crate) fn forget_all(&self, freed: &mut Freed) -> io::Result<()> {
        for kind in ["programs", "runtime", EDITOR] {
            for (folder, _) in entries(&self.folder.join(kind))? {
                remove_unused(&folder, freed)?;
            }
        }
        Ok(())
    }

    /// Locks a folder of its kind, and removes those that were not used for the longest time.
    fn lock(&self, kind: &str, key: &str, count_max: usize, what: &str) -> io::Result<Locked> {
        let parent = self.folder.join(kind);
        let folder = parent.join(key);
        fs::create_dir_all(&folder).map_err(|error| not_written(&folder, &error))?;
        let path = lock_of(&folder);
        let lock = File::create(&path).map_err(|error| not_written(&path, &error))?;
        if flock(&lock, FlockOperation::NonBlockingLockExclusive).is_err() {
            terminal::inform(format_args!("Waiting until another lfz has compiled {what}"));
            flock(&lock, FlockOperation::LockExclusive)?;
        }
        // Another process may have removed it before it was locked.
        fs::create_dir_all(&folder)?;
        lock.set_modified(SystemTime::now())?;
        let mut others = entries(&parent)?;
        others.retain(|(other, _)| *other != folder);
        others.sort_by_key(|(_, used)| std::cmp::Reverse(*used));
        let (orphans, others): (Vec<_>, Vec<_>) = others.into_iter().partition(|(other, _)| is_orphan(other));
        for (other, _) in orphans.into_iter().chain(others.into_iter().skip(count_max - 1)) {
            // A failure does not matter; a later build can remove the folder.
            let _ = remove_unused(&other, &mut Freed::default());
        }
        Ok(Locked { folder, _lock: lock })
    }
}

/// Returns a number that is equal for equal values.
pub(super) fn hash_of(value: &(impl Hash + ?Sized)) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

fn program_key(out: &Path) -> String {
    format!("{:016x}", hash_of(out))
}

fn lock_of(folder: &Path) -> PathBuf {
    folder.with_extension("lock")
}

fn not_written(path: &Path, error: &io::Error) -> io::Error {
    let (path, reason) = (path.display(), files::reason(error));
    io::Error::new(error.kind(), format!("cannot write {path}: {reason}; name another folder with --target-dir"))
}

/// Returns whether the program of a folder does not exist any more.
fn is_orphan(folder: &Path) -> bool {
    fs::read_to_string(folder.join(OWNER)).is_ok_and(|out| !Path::new(&out).exists())
}

/// Returns the folders in a folder, with their times of use.
fn entries(parent: &Path) -> io::Result<Vec<(PathBuf, SystemTime)>> {
    let found = match fs::read_dir(parent) {
        Ok(found) => found,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(error),
    };
    let mut folders = Vec::new();
    for entry in found {
        let path = entry?.path();
        if path.is_dir() {
            let used = fs::metadata(lock_of(&path)).and_then(|metadata| metadata.modified());
            folders.push((path, used.unwrap_or(SystemTime::UNIX_EPOCH)));
        }
    }
    Ok(folders)
}

/// Removes a folder of the store, unless a build uses it.
fn remove_unused(folder: &Path, freed: &mut Freed) -> io::Result<()> {
    let path = lock_of(folder);
    let lock = match File::options().read(true).open(&path) {
        Ok(lock) => Some(lock),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(error) => return Err(error),
    };
    if let Some(lock) = &lock
        && flock(lock, FlockOperation::NonBlockingLockExclusive).is_err()
    {
        freed.busy.push(folder.to_owned());
        return Ok(());
    }
    // The lock's file stays: a process that waits for it would otherwise lock a deleted file.
    freed.remove(folder)
}

impl Freed {
    /// Removes a file or a folder with all its contents; a missing one is no error.
    ///
    /// # Errors
    /// When something cannot be removed.
    pub(crate) fn remove(&mut self, path: &Path) -> io::Result<()> {
        let metadata = match fs::symlink_metadata(path) {
            Ok(metadata) => metadata,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
            Err(error) => return Err(error),
        };
        let removed = if metadata.is_dir() {
            for entry in fs::read_dir(path)? {
                self.remove(&entry?.path())?;
            }
            fs::remove_dir(path)
        } else {
            // A file with another name is not free yet.
            self.size += if metadata.nlink() == 1 { metadata.blocks() * 512 } else { 0 };
            fs::remove_file(path)
        };
        removed.map_err(|error| io::Error::new(error.kind(), format!("cannot remove {}: {error}", path.display())))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::{Freed, PROGRAMS_MAX, Store};

    fn count(store: &Path) -> usize {
        let entries = fs::read_dir(store.join("programs")).expect("it is there");
        entries.filter(|entry| entry.as_ref().expect("it can be read").path().is_dir()).count()
    }

    #[test]
    fn two_programs_are_locked_at_once_and_what_somebody_builds_in_is_not_removed() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let store = Store::new(folder.path().join("store"));
        let outs = ["a", "b"].map(|name| folder.path().join(name));
        for out in &outs {
            fs::create_dir(out).expect("it can be made");
        }
        let first = store.program(&outs[0]).expect("it can be written");
        let second = store.program(&outs[1]).expect("nobody waits for another program");
        assert_ne!(first.folder, second.folder);
        let mut freed = Freed::default();
        store.forget_all(&mut freed).expect("nothing is removed");
        assert_eq!((freed.size, freed.busy.len(), second.folder.is_dir()), (0, 2, true));
        fs::write(second.folder.join("x"), [1; 5000]).expect("it can be written");
        drop((first, second));
        store.forget_program(&outs[1], &mut freed).expect("it can be removed");
        assert!(freed.size >= 5000, "{freed:?}");
        assert_eq!(count(&folder.path().join("store")), 1);
    }

    #[test]
    fn stored_builds_are_bounded_and_belong_to_programs_that_exist() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let store = Store::new(folder.path().join("store"));
        for number in 0..PROGRAMS_MAX + 5 {
            let out = folder.path().join(number.to_string());
            fs::create_dir(&out).expect("it can be made");
            drop(store.program(&out).expect("it can be written"));
        }
        assert_eq!(count(&folder.path().join("store")), PROGRAMS_MAX);
        for number in 0..PROGRAMS_MAX + 4 {
            fs::remove_dir(folder.path().join(number.to_string())).expect("it is there");
        }
        let last = folder.path().join((PROGRAMS_MAX + 4).to_string());
        drop(store.program(&last).expect("it can be written"));
        assert_eq!(count(&folder.path().join("store")), 1);
    }
}
