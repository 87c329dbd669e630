// SPDX-License-Identifier: Apache-2.0
//! The folders of the generated crates, the compiled programs and the runtime crates.
//!
//! Users name folders in any form: relative, through symbolic links, with `..`. This module resolves each name once, as
//! the system resolves it. No other module compares paths as text.

use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf, absolute};

use super::files::reason;
use super::store::{Store, hash_of};
use crate::args::{Places, Platform};

/// Every folder that a build uses, as absolute paths without symbolic links.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Folders {
    /// The generated crates, which form a workspace.
    pub(crate) out: PathBuf,
    /// Cargo's intermediate results.
    pub(crate) store: Store,
    /// The repository with the runtime crates.
    pub(crate) home: PathBuf,
}

impl Folders {
    /// Returns the folders for a program; `name` is the program's name.
    ///
    /// # Errors
    /// When there is no current folder, the runtime crates are not where they should be, or cargo cannot work in a
    /// folder of this name.
    pub(crate) fn new(file: &Path, name: &str, platform: Platform, places: &Places) -> io::Result<Self> {
        if let Ok(current) = current() {
            text_of(&current)?;
        }
        let home = home(places)?;
        let out = match &places.out {
            Some(out) => out.clone(),
            None => application(file)?.join("build/lfz").join(name).join(platform_folder(platform)),
        };
        let out = resolved(&out).map_err(|error| named_by("--out", &error))?;
        usable(&out, "--out")?;
        Ok(Self { out, store: store(places)?, home })
    }

    /// Returns these folders with one for crates that tools of editors read, beside that of the build.
    pub(crate) fn for_editors(mut self) -> Self {
        self.out.set_file_name("editor");
        self
    }

    /// Returns the folder of the compiled programs of this program alone.
    pub(crate) fn target(&self) -> PathBuf {
        self.out.join("target")
    }

    /// Returns the version of the generated packages, which depends on their folder: cargo itself compares only their
    /// names and their paths within the workspace, and would take one program for another of the same name.
    pub(crate) fn version(&self) -> String {
        format!("0.0.0+{:016x}", hash_of(&self.out))
    }
}

/// Returns the folder of cargo's intermediate results.
///
/// # Errors
/// When there is no current folder, or cargo cannot work in a folder of this name.
pub(crate) fn store(places: &Places) -> io::Result<Store> {
    let folder = match (&places.target_dir, std::env::var_os("CARGO_TARGET_DIR")) {
        (Some(folder), _) => resolved(folder).map_err(|error| named_by("--target-dir", &error))?,
        (None, Some(folder)) => resolved(Path::new(&folder))?.join("lf"),
        (None, None) => home(places)?.join("target/lf"),
    };
    usable(&folder, "--target-dir")?;
    Ok(Store::new(folder))
}

/// Returns the folder of cargo's intermediate results of images, which the west commands use.
///
/// # Errors
/// When there is no current folder.
pub(crate) fn images(places: &Places) -> io::Result<PathBuf> {
    let target = std::env::var_os("CARGO_TARGET_DIR").map(|folder| resolved(Path::new(&folder)));
    Ok(target.unwrap_or_else(|| Ok(home(places)?.join("target")))?.join("lf-zephyr"))
}

/// Returns the application's folder: that around `src`, or that of the file if it is not in a `src` folder.
///
/// # Errors
/// When there is no current folder, or `..` leads out of a folder that does not exist.
pub(crate) fn application(file: &Path) -> io::Result<PathBuf> {
    let file = from_root(file)?;
    let folder = file.parent().unwrap_or(&file);
    // A folder has the name that the user gives it, which for a symbolic link is the link's name; `..` is no name.
    let folder = if folder.file_name().is_some() { folder.to_owned() } else { fs::canonicalize(folder)? };
    Ok(match folder.parent() {
        Some(application) if folder.file_name() == Some(OsStr::new("src")) => application.to_owned(),
        _ => folder,
    })
}

/// Returns the folder in which this program was started.
///
/// # Errors
/// When it does not exist any more.
pub(crate) fn current() -> io::Result<PathBuf> {
    std::env::current_dir().map_err(|error| {
        let message = "the folder that this was started in is gone; change to another one by `cd`";
        io::Error::new(error.kind(), message)
    })
}

/// Returns the path from the root on, with the names that the user gives its folders.
///
/// # Errors
/// When it begins in the current folder and there is none.
pub(crate) fn from_root(path: &Path) -> io::Result<PathBuf> {
    if path.is_relative() {
        current()?;
    }
    absolute(path)
}

/// Returns the path as text, which compilers need.
///
/// # Errors
/// When it is no text; the error names the part to rename.
#[expect(clippy::unnecessary_debug_formatting, reason = "it shows the bytes that are no text")]
pub(crate) fn text_of(path: &Path) -> io::Result<&str> {
    path.to_str().ok_or_else(|| {
        let part = path.iter().find(|part| part.to_str().is_none()).unwrap_or(path.as_os_str());
        io::Error::other(format!(
            "compilers take only paths that are UTF-8 text: rename {part:?} in {}",
            path.display()
        ))
    })
}

/// Returns the path as the system resolves it, without `..` and symbolic links. The parts that do not exist yet keep
/// the names that they will have.
fn resolved(path: &Path) -> io::Result<PathBuf> {
    let mut found = PathBuf::new();
    for part in from_root(path)?.components() {
        match part {
            Component::ParentDir => _ = found.pop(),
            part => found.push(part),
        }
        match fs::canonicalize(&found) {
            Ok(real) => found = real,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => {
                let message = format!("{}: {}", found.display(), reason(&error));
                return Err(io::Error::new(error.kind(), message));
            }
        }
    }
    Ok(found)
}

/// Returns the reason why a folder cannot be used, with the option that names another one.
pub(super) fn named_by(option: &str, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{error}; name another folder with {option}"))
}

/// Refuses a folder in which cargo cannot work, with the option that names another one.
fn usable(folder: &Path, option: &str) -> io::Result<()> {
    let shown = folder.display();
    let wrong = match folder.to_str() {
        None => "is no UTF-8 text",
        // Cargo passes the linker a list of folders separated by this character.
        Some(text) if text.contains(':') => "contains `:`",
        Some(_) => return Ok(()),
    };
    Err(io::Error::other(format!(
        "cargo cannot work in the folder {shown}, whose path {wrong}; name another folder with {option}"
    )))
}

fn platform_folder(platform: Platform) -> &'static str {
    match platform {
        Platform::Host => "host",
        Platform::Zephyr => "zephyr",
    }
}

/// Returns the folder with the runtime's sources: that of this program, unless the user names another one.
pub(crate) fn home(places: &Places) -> io::Result<PathBuf> {
    let home = match &places.home {
        Some(home) => resolved(home)?,
        None => crate::home::folder()?,
    };
    if home.join("rust/linux/Cargo.toml").is_file() {
        return Ok(home);
    }
    let place = home.display();
    Err(io::Error::other(format!(
        "the runtime crates are not in {place}; name the lf-zephyr-rs repository with --home or in LFZ_HOME"
    )))
}

#[cfg(test)]
mod tests;
