// SPDX-License-Identifier: Apache-2.0
//! Removing what was generated and compiled, and nothing else.

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

/// Removes what builds of a program have left, for both platforms. The program itself need not be right any more.
///
/// # Errors
/// When something cannot be removed, or a folder has not been generated.
pub(crate) fn clean_program(file: &Path, places: &Places, freed: &mut Freed) -> Result<(), Failure> {
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    for platform in [Platform::Host, Platform::Zephyr] {
        let folders = Folders::new(file, &name, platform, places)?;
        clean_out(&folders.out, freed)?;
        folders.store.forget_program(&folders.out, freed)?;
        // Folders that are empty now were made for it.
        for folder in folders.out.ancestors().take(4).take_while(|_| places.out.is_none()) {
            if fs::remove_dir(folder).is_err() && folder.exists() {
                break;
            }
        }
    }
    Ok(())
}

/// Removes what is compiled of all programs; what is in their own folders stays.
///
/// # Errors
/// When something cannot be removed.
pub(crate) fn clean_all(places: &Places, freed: &mut Freed) -> Result<(), Failure> {
    store(places)?.forget_all(freed)?;
    Ok(forget_images(&images(places)?, freed)?)
}

/// Removes what cargo keeps of all images, unless Zephyr's build has locked it, by the way of CMake.
fn forget_images(folder: &Path, freed: &mut Freed) -> io::Result<()> {
    let lock = File::options().read(true).write(true).open(folder.join("lf-image.lock"));
    if lock.is_ok_and(|lock| fcntl_lock(&lock, FlockOperation::NonBlockingLockExclusive).is_err()) {
        freed.busy.push(folder.to_owned());
        return Ok(());
    }
    freed.remove(folder)
}

/// Removes the generated files in a folder, and what was compiled or recorded there; a folder without generated files
/// belongs to the user.
fn clean_out(out: &Path, freed: &mut Freed) -> io::Result<()> {
    let Some(generated) = files::generated(out)? else { return Ok(()) };
    let locks = generated.iter().filter_map(|path| Some(format!("{}.lock", path.strip_suffix(".toml")?)));
    let others = ["Cargo.lock", trace_names::FILE, MEASURED, "target"].map(str::to_owned);
    for path in generated.iter().cloned().chain(locks).chain(others) {
        freed.remove(&out.join(&path))?;
        files::remove_empty(out, &path);
    }
    // The list comes last, so that what could not be removed now is removed the next time.
    freed.remove(&out.join(files::LIST))
}
