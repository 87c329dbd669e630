// SPDX-License-Identifier: Apache-2.0
//! Generated crates for tools of editors, which read them and build no program.

use std::io;
use std::path::{Path, PathBuf};

use lf_compiler::deployment::Deployment;
use lf_compiler::emit::Emitted;
use lf_compiler::plan::Plan;

use super::files;
use super::lock::Lock;
use super::places::{Folders, home, store};
use crate::args::{Places, Platform};
use crate::failure::Failure;

/// The crates of all federates of a program for this computer.
pub(crate) struct ReadableCode {
    /// The generated files, and their source map.
    pub(crate) emitted: Emitted,
    /// The folder for it; builds have another one.
    pub(crate) folder: PathBuf,
    lock: Lock,
}

impl ReadableCode {
    /// Generates the crates of a plan, and writes nothing.
    ///
    /// # Errors
    /// When the plan cannot be emitted, or the folder's name is none for cargo.
    pub(crate) fn new(file: &Path, plan: &Plan) -> Result<Self, Failure> {
        let folders = Folders::new(file, &plan.name, Platform::Host, &places())?.for_editors();
        let emitted = super::emitted(plan, &Deployment::default(), &folders)?;
        Ok(Self { emitted, folder: folders.out, lock: Lock::of(file, plan) })
    }

    /// Writes files to the folder, and the versions of their crates.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub(crate) fn write<'a>(&self, all: impl IntoIterator<Item = (&'a str, &'a str)>) -> io::Result<()> {
        files::write(&self.folder, all)?;
        self.lock.give(&home(&places())?.join("Cargo.lock"), &self.folder)
    }

    /// Returns the folder for what cargo makes for such tools.
    ///
    /// # Errors
    /// When there is no folder for cargo.
    pub(crate) fn cargo_folder() -> io::Result<PathBuf> {
        Ok(store(&places())?.editor())
    }
}

/// Returns the places that a user names outside of a command line.
fn places() -> Places {
    Places { home: std::env::var_os("LFZ_HOME").map(PathBuf::from), ..Places::default() }
}
