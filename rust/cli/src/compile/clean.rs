// SPDX-License-Identifier: Apache-2.0
//! Removes generated and compiled files, and nothing else.

use std::fs::{self, File};
use std::io;
use std::path::Path;

use lf_compiler::trace_names;
use rustix::fs::{FlockOperation, fcntl_lock};

use super::files;
use super::places::{Folders, images, store};
use super::store::Freed;
use crate::args::{Places, Platform};
use crate::failure::Failure;
use crate::trace::MEASURED;

/// Removes the files of a program's builds, for both platforms. The program itself may have errors.
///
/// # Errors
/// When something cannot be removed, or a folder has not been generated.
pub(crate) fn clean_program(file: &Path, places: &Places, freed: &mut Freed) -> Result<(), Failure> {
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let folders = |platform: Platform| Folders::new(file, &name, platform, places);
    let mut all = vec![folders(Platform::Host)?, folders(Platform::Zephyr)?];
    if places.out.is_none() {
        all.push(folders(Platform::Host)?.for_editors());
    }
    for folders in all {
        clean_out(&folders.out, freed)?;
        folders.store.forget_program(&folders.out, freed)?;
        // Builds created these folders, which are empty now.
        for folder in folders.out.ancestors().take(4).take_while(|_| places.out.is_none()) {
            if fs::remove_dir(folder).is_err() && folder.exists() {
                break;
            }
        }
    }
    Ok(())
}

/// Removes the compiled files of all programs; their own folders stay.
///
/// # Errors
/// When something cannot be removed.
pub(crate) fn clean_all(places: &Places, freed: &mut Freed) -> Result<(), Failure> {
    store(places)?.forget_all(freed)?;
    Ok(forget_images(&images(places)?, freed)?)
}

/// Removes cargo's files of all images, by the means of CMake, unless Zephyr's build has locked them.
fn forget_images(folder: &Path, freed: &mut Freed) -> io::Result<()> {
    let lock = File::options().read(true).write(true).open(folder.join("lf-image.lock"));
    if lock.is_ok_and(|lock| fcntl_lock(&lock, FlockOperation::NonBlockingLockExclusive).is_err()) {
        freed.busy.push(folder.to_owned());
        return Ok(());
    }
    freed.remove(folder)
}

/// Removes the generated files in a folder, and the compiled and recorded ones there; a folder without generated files
/// belongs to the user.
fn clean_out(out: &Path, freed: &mut Freed) -> io::Result<()> {
    let Some(generated) = files::generated(out)? else { return Ok(()) };
    let locks = generated.iter().filter_map(|path| Some(format!("{}.lock", path.strip_suffix(".toml")?)));
    let others = ["Cargo.lock", trace_names::FILE, MEASURED, "target"].map(str::to_owned);
    for path in generated.iter().cloned().chain(locks).chain(others) {
        freed.remove(&out.join(&path))?;
        files::remove_empty(out, &path);
    }
    // The list comes last, so that a later call removes the files that could not be removed now.
    freed.remove(&out.join(files::LIST))
}
