// SPDX-License-Identifier: Apache-2.0
//! Files that only this user can read. None is written through a symbolic link, and none is ever half there.

use std::fs::{self, DirBuilder, OpenOptions};
use std::io::{self, ErrorKind, Write as _};
use std::os::unix::fs::{DirBuilderExt as _, OpenOptionsExt as _};
use std::path::Path;

/// Creates a folder, and those around it, if it is missing.
///
/// # Errors
/// When it cannot be created; the message names it.
pub(crate) fn create_folder(path: &Path) -> io::Result<()> {
    let created = DirBuilder::new().recursive(true).mode(0o700).create(path);
    created.map_err(|error| named(&error, path, "cannot be made"))
}

/// Creates a file, unless there is one. Returns whether it was missing.
///
/// # Errors
/// When it cannot be written; the message names it.
pub(crate) fn create_if_missing(path: &Path, text: &str) -> io::Result<bool> {
    match fs::symlink_metadata(path) {
        Ok(_) => Ok(false),
        Err(error) if error.kind() == ErrorKind::NotFound => replace(path, text).map(|()| true),
        Err(error) => Err(named(&error, path, "cannot be read")),
    }
}

/// Creates a file, or puts it in the place of one or of a link.
///
/// # Errors
/// When it cannot be written; the message names it.
pub(crate) fn replace(path: &Path, text: &str) -> io::Result<()> {
    if fs::read(path).is_ok_and(|old| old == text.as_bytes()) && is_private(path) {
        return Ok(());
    }
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    let part = Path::new(&part);
    let write = || -> io::Result<()> {
        // It may be left from a program that was killed.
        remove(part)?;
        let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(part)?;
        file.write_all(text.as_bytes())?;
        file.sync_all()?;
        fs::rename(part, path)
    };
    write().map_err(|error| named(&error, path, "cannot be written"))
}

/// Removes a file or a link, if there is one.
///
/// # Errors
/// When it cannot be removed; the message names it.
pub(crate) fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(named(&error, path, "cannot be removed")),
        _ => Ok(()),
    }
}

/// Returns whether there is a file or a link of this name.
pub(crate) fn is_there(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok()
}

fn is_private(path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    fs::symlink_metadata(path).is_ok_and(|found| found.is_file() && found.mode() & 0o777 == 0o600)
}

fn named(error: &io::Error, path: &Path, what: &str) -> io::Error {
    io::Error::new(error.kind(), format!("{} {what}: {error}", path.display()))
}
