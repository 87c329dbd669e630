// SPDX-License-Identifier: Apache-2.0
//! Waits for changes of the files of which a program is made.
//!
//! Editors replace files by new ones, so folders are watched, and changes of other files in them do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::mem::MaybeUninit;
use std::os::fd::OwnedFd;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::inotify::{self, CreateFlags, ReadFlags, Reader, WatchFlags};
use rustix::io::Errno;
use walkdir::{DirEntry, WalkDir};

use crate::compile::compile;
use crate::failure::Failure;

/// The time without changes after which a change is complete: programs that replace several files do so one after the
/// other.
const SETTLED: Duration = Duration::from_millis(100);

/// The files of a program.
pub(crate) struct Watch {
    inotify: OwnedFd,
    program: PathBuf,
    /// The watched folders, by their numbers.
    watched: BTreeMap<i32, PathBuf>,
    files: BTreeSet<PathBuf>,
    /// Folders in which every file counts.
    folders: BTreeSet<PathBuf>,
}

impl Watch {
    /// Watches the files of a program, and others.
    ///
    /// # Errors
    /// When the system has no means left to watch files.
    pub(crate) fn of(program: &Path, others: &[PathBuf]) -> Result<Self, Failure> {
        let inotify = inotify::init(CreateFlags::CLOEXEC | CreateFlags::NONBLOCK).map_err(unwatched)?;
        let program = program.to_owned();
        let (watched, files, folders) = (BTreeMap::new(), BTreeSet::new(), BTreeSet::new());
        let mut watch = Self { inotify, program, watched, files, folders };
        for other in others {
            watch.add_file(other)?;
        }
        watch.renew()?;
        Ok(watch)
    }

    /// Watches the files of which the program is made now, too. A program with errors has those that were read.
    fn renew(&mut self) -> Result<(), Failure> {
        let compilation = compile(&self.program)?;
        self.add_file(&self.program.clone())?;
        for (_, source) in compilation.diagnostics.sources().iter() {
            self.add_file(Path::new(source.path()))?;
        }
        let Some(plan) = compilation.plan else { return Ok(()) };
        let c = &plan.target.c;
        for file in c.files.iter().chain(&c.sources).chain(&c.headers).chain(&c.cmake) {
            self.add_file(Path::new(&file.path))?;
        }
        for folder in &c.folders {
            self.add_folder(Path::new(&folder.path))?;
        }
        for module in &plan.target.cargo.modules {
            let file = Path::new(&module.path);
            // A module in a folder has more files there.
            if file.file_name() == Some(OsStr::new("mod.rs")) {
                self.add_folder(file.parent().unwrap_or(file))?;
            } else {
                self.add_file(file)?;
            }
        }
        for folder in plan.target.cargo.dependencies.iter().filter_map(|dependency| dependency.path.as_ref()) {
            self.add_folder(Path::new(folder))?;
        }
        Ok(())
    }

    /// Watches a file, also at the end of a symbolic link. It need not exist.
    fn add_file(&mut self, file: &Path) -> Result<(), Failure> {
        let real = fs::canonicalize(file).ok();
        for file in [Some(file.to_owned()), real].into_iter().flatten() {
            let parent = file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
            if let (Ok(parent), Some(name)) = (fs::canonicalize(parent), file.file_name()) {
                self.add_watch(&parent)?;
                self.files.insert(parent.join(name));
            }
        }
        Ok(())
    }

    /// Watches all files in a folder, without hidden ones and those that cargo makes.
    fn add_folder(&mut self, folder: &Path) -> Result<(), Failure> {
        let Ok(folder) = fs::canonicalize(folder) else { return Ok(()) };
        let counts = |entry: &DirEntry| {
            let name = entry.file_name().as_bytes();
            entry.depth() == 0 || !(name.starts_with(b".") || name == b"target")
        };
        let entries = WalkDir::new(&folder).into_iter().filter_entry(counts).filter_map(Result::ok);
        for entry in entries.filter(|entry| entry.file_type().is_dir()) {
            self.add_watch(entry.path())?;
            self.folders.insert(entry.into_path());
        }
        Ok(())
    }

    fn add_watch(&mut self, folder: &Path) -> Result<(), Failure> {
        let changes = WatchFlags::CLOSE_WRITE | WatchFlags::MOVED_TO | WatchFlags::DELETE | WatchFlags::ONLYDIR;
        match inotify::add_watch(&self.inotify, folder, changes) {
            Ok(number) => self.watched.insert(number, folder.to_owned()),
            // It has been removed since it was found, which changes the program by itself.
            Err(Errno::NOENT | Errno::NOTDIR) => None,
            Err(error) => return Err(unwatched(error)),
        };
        Ok(())
    }

    /// Waits until files have changed and no others change, and returns the first one. From then on, the files of the
    /// changed program are watched.
    ///
    /// # Errors
    /// When the system's calls fail.
    pub(crate) fn wait(&mut self) -> Result<PathBuf, Failure> {
        let mut first = None;
        loop {
            let limit = first.is_some().then(|| Timespec::try_from(SETTLED).unwrap_or_default());
            let mut descriptors = [PollFd::new(&self.inotify, PollFlags::IN)];
            match poll(&mut descriptors, limit.as_ref()) {
                Ok(0) => {
                    if let Some(first) = first {
                        self.renew()?;
                        return Ok(first);
                    }
                }
                Ok(_) => first = first.or(self.changed()?),
                Err(Errno::INTR) => {}
                Err(error) => return Err(io::Error::from(error).into()),
            }
        }
    }

    /// Returns the first of the changed files that count, if there is one.
    fn changed(&self) -> Result<Option<PathBuf>, Failure> {
        let mut buffer = [MaybeUninit::uninit(); 4096];
        let mut reader = Reader::new(&self.inotify, &mut buffer);
        let mut first = None;
        loop {
            let event = match reader.next() {
                Ok(event) => event,
                Err(Errno::WOULDBLOCK) => return Ok(first),
                Err(error) => return Err(io::Error::from(error).into()),
            };
            if event.events().contains(ReadFlags::QUEUE_OVERFLOW) {
                first = first.or_else(|| Some(self.program.clone()));
                continue;
            }
            let Some((folder, name)) = self.watched.get(&event.wd()).zip(event.file_name()) else { continue };
            let file = folder.join(OsStr::from_bytes(name.to_bytes()));
            if first.is_none() && self.is_part(folder, &file) {
                first = Some(file);
            }
        }
    }

    /// Returns whether a file may be a part of the program: any LF file may be one that an import names.
    fn is_part(&self, folder: &Path, file: &Path) -> bool {
        let is_lf = file.extension() == Some(OsStr::new("lf"));
        self.files.contains(file) || self.folders.contains(folder) || is_lf
    }
}

/// Returns the failure of watching, with what to do.
fn unwatched(error: Errno) -> Failure {
    let hint = match error {
        Errno::NOSPC | Errno::MFILE => "; raise fs.inotify.max_user_watches or max_user_instances by sysctl",
        _ => "",
    };
    Failure::message(format!("changes of files cannot be watched: {error}{hint}"))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::Watch;

    const PROGRAM: &str =
        "target Rust { rust-include: \"m.rs\" }\nimport A from \"lib/A.lf\"\nmain reactor {\n  a = new A()\n}\n";

    /// Files of the program are written in place, replaced, and imported anew; others do not count.
    #[test]
    fn changes_of_all_files_of_a_program_are_seen_and_no_others() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().canonicalize().expect("it is there").join(name);
        fs::create_dir(path("lib")).expect("it can be made");
        for (name, text) in [("P.lf", PROGRAM), ("lib/A.lf", "target Rust\nreactor A {\n}\n"), ("m.rs", "")] {
            fs::write(path(name), text).expect("it can be written");
        }
        let mut watch = Watch::of(&path("P.lf"), &[path("moves.txt")]).expect("there are watches left");
        let mut changed = |name: &str| {
            fs::write(path("other.txt"), "").expect("it can be written");
            fs::write(path("new"), PROGRAM.replace("a = new", "b = new")).expect("it can be written");
            fs::rename(path("new"), path(name)).expect("it is in the same folder");
            watch.wait().expect("it can wait")
        };
        for name in ["P.lf", "m.rs", "moves.txt", "lib/A.lf", "lib/New.lf"] {
            assert_eq!(changed(name), path(name));
        }
        fs::remove_file(path("m.rs")).expect("it is there");
        assert_eq!(watch.wait().expect("it can wait"), path("m.rs"));
    }
}
