// SPDX-License-Identifier: Apache-2.0
//! Writes generated files: only those that changed, so that cargo compiles no more than necessary, and removes earlier
//! ones that are no longer generated.

use std::collections::BTreeSet;
use std::fs;
use std::io::{self, ErrorKind};
use std::os::unix::fs::symlink;
use std::path::{Component, Path};

/// The list of the generated files in a folder, one path per line; no other file is ever removed.
pub(crate) const LIST: &str = ".generated";

/// Writes these files, given by their paths and their texts, and removes all others that were generated in the folder.
///
/// # Errors
/// When a file cannot be read, written or removed; the message names it.
pub(crate) fn write<'a>(out: &Path, files: impl IntoIterator<Item = (&'a str, &'a str)>) -> io::Result<()> {
    let mut list = BTreeSet::new();
    for (path, text) in files {
        check(path)?;
        write_changed(&out.join(path), text)?;
        list.insert(path);
    }
    for path in generated(out)?.iter().flatten().filter(|path| !list.contains(path.as_str())) {
        remove(out, path)?;
    }
    let list: String = list.iter().flat_map(|path| [*path, "\n"]).collect();
    write_changed(&out.join(LIST), &list)
}

/// Returns the paths of the generated files in a folder; `None` if there are none.
///
/// # Errors
/// When their list cannot be read; the message names it.
pub(crate) fn generated(out: &Path) -> io::Result<Option<Vec<String>>> {
    let text = match fs::read_to_string(out.join(LIST)) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(named(&error, &out.join(LIST))),
    };
    let paths: Vec<String> = text.lines().map(str::to_owned).collect();
    paths.iter().try_for_each(|path| check(path))?;
    Ok(Some(paths))
}

/// Removes the folders of a path in another folder, from the innermost on, until one is not empty.
pub(crate) fn remove_empty(out: &Path, path: &str) {
    for folder in Path::new(path).ancestors().skip(1).filter(|folder| !folder.as_os_str().is_empty()) {
        if fs::remove_dir(out.join(folder)).is_err() {
            break;
        }
    }
}

/// Makes symbolic links in a folder to these files, by which programs of other compilers are found.
///
/// # Errors
/// When one cannot be made; the message names it.
pub(crate) fn link_all<'a>(folder: &Path, links: impl Iterator<Item = (String, &'a Path)>) -> io::Result<()> {
    fs::create_dir_all(folder).map_err(|error| named(&error, folder))?;
    for (name, target) in links {
        let link = folder.join(name);
        if fs::read_link(&link).is_ok_and(|present| present == target) {
            continue;
        }
        match fs::remove_file(&link) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(named(&error, &link)),
            _ => symlink(target, &link).map_err(|error| named(&error, &link))?,
        }
    }
    Ok(())
}

/// Copies a file that is missing or older than its origin.
///
/// # Errors
/// When it cannot be copied; the message names it.
pub(crate) fn copy_newer(from: &Path, to: &Path) -> io::Result<()> {
    let modified = |path: &Path| fs::metadata(path).and_then(|metadata| metadata.modified());
    let (Ok(origin), copy) = (modified(from), modified(to)) else { return Ok(()) };
    if copy.is_ok_and(|copy| copy >= origin) {
        return Ok(());
    }
    fs::copy(from, to).map(|_| ()).map_err(|error| named(&error, to))
}

/// Refuses a path that leads out of the folder, which would be a defect that overwrites or removes a file of the user.
fn check(path: &str) -> io::Result<()> {
    let inside = !path.is_empty() && Path::new(path).components().all(|part| matches!(part, Component::Normal(_)));
    if inside { Ok(()) } else { Err(io::Error::other(format!("`{path}` is no path in the output folder"))) }
}

/// Writes a file, unless it has this text already.
///
/// # Errors
/// When it cannot be written; the message names it.
pub(crate) fn write_changed(path: &Path, text: &str) -> io::Result<()> {
    if fs::read(path).is_ok_and(|present| present == text.as_bytes()) {
        return Ok(());
    }
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|error| named(&error, folder))?;
    }
    fs::write(path, text).map_err(|error| named(&error, path))
}

fn remove(out: &Path, path: &str) -> io::Result<()> {
    match fs::remove_file(out.join(path)) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(named(&error, &out.join(path))),
        _ => {}
    }
    remove_empty(out, path);
    Ok(())
}

fn named(error: &io::Error, path: &Path) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {}", path.display(), reason(error)))
}

/// Returns the reason why a file cannot be written, as the end of a sentence.
pub(super) fn reason(error: &io::Error) -> String {
    match error.kind() {
        ErrorKind::AlreadyExists | ErrorKind::NotADirectory => "it is a file, and no folder".to_owned(),
        ErrorKind::IsADirectory => "it is a folder, and no file".to_owned(),
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => "it may not be written".to_owned(),
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::time::{Duration, SystemTime};

    use super::{copy_newer, write};

    #[test]
    fn only_what_changed_is_written() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        write(folder.path(), [("a/x.rs", "1"), ("y.toml", "2")]).expect("it can be written");
        let long_ago = SystemTime::now() - Duration::from_secs(3600);
        for path in ["a/x.rs", "y.toml"] {
            let file = fs::File::options().write(true).open(folder.path().join(path)).expect("it was written");
            file.set_modified(long_ago).expect("the file system has times");
        }
        write(folder.path(), [("a/x.rs", "1"), ("y.toml", "3")]).expect("it can be written");
        let age = |path: &str| fs::metadata(folder.path().join(path)).expect("it is there").modified().expect("a time");
        assert_eq!(age("a/x.rs"), long_ago);
        assert_ne!(age("y.toml"), long_ago);
        assert_eq!(fs::read_to_string(folder.path().join("y.toml")).expect("it is there"), "3");
    }

    #[test]
    fn files_that_are_no_longer_generated_are_removed_and_no_others() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        write(folder.path(), [("a/src/main.rs", "1"), ("b/main.rs", "2")]).expect("it can be written");
        fs::write(folder.path().join("b/mine.txt"), "keep").expect("it can be written");
        write(folder.path(), [("c.rs", "3")]).expect("it can be written");
        assert!(!folder.path().join("a").exists());
        assert!(!folder.path().join("b/main.rs").exists());
        assert!(folder.path().join("b/mine.txt").exists());
    }

    #[test]
    fn a_path_out_of_the_folder_is_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for path in ["../x", "/x", ""] {
            assert!(write(folder.path(), [(path, "1")]).is_err(), "{path}");
        }
    }

    #[test]
    fn a_copy_is_renewed_when_its_origin_is_newer() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (from, to) = (folder.path().join("from"), folder.path().join("to"));
        fs::write(&from, "1").expect("it can be written");
        fs::write(&to, "changed since").expect("it can be written");
        let file = fs::File::options().write(true).open(&from).expect("it was written");
        file.set_modified(SystemTime::now() - Duration::from_secs(3600)).expect("the file system has times");
        copy_newer(&from, &to).expect("nothing to do");
        assert_eq!(fs::read_to_string(&to).expect("it is there"), "changed since");
        file.set_modified(SystemTime::now() + Duration::from_secs(3600)).expect("the file system has times");
        copy_newer(&from, &to).expect("it can be copied");
        assert_eq!(fs::read_to_string(&to).expect("it is there"), "1");
    }
}
