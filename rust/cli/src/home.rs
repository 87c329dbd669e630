// SPDX-License-Identifier: Apache-2.0
//! The folder with the runtime's sources: those of the repository in which this program was built, or those that an
//! installed program has in itself, which it unpacks once into the user's cache.

use std::io;
use std::path::PathBuf;

/// Returns the folder.
///
/// # Errors
/// When the user has no folder for caches, or it cannot be written to.
#[cfg(not(embedded_runtime))]
#[allow(clippy::unnecessary_wraps, reason = "an installed program may fail")]
pub(crate) fn folder() -> io::Result<PathBuf> {
    use std::path::Path;

    Ok(Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap_or(Path::new("/")).to_path_buf())
}

#[cfg(embedded_runtime)]
pub(crate) fn folder() -> io::Result<PathBuf> {
    use std::{env, fs};

    use flate2::read::GzDecoder;
    use tar::Archive;

    /// The sources, as `cargo xtask dist` has packed them.
    static RUNTIME: &[u8] = include_bytes!("../runtime.tar.gz");

    let named = |name: &str| env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let caches = named("XDG_CACHE_HOME").or_else(|| named("HOME").map(|home| home.join(".cache")));
    let caches = caches.filter(|folder| folder.is_absolute()).ok_or_else(|| {
        io::Error::other("there is no folder for the runtime: set HOME or XDG_CACHE_HOME, or name it with --home")
    })?;
    let parent = caches.join("lfz");
    let folder = parent.join(concat!(env!("CARGO_PKG_VERSION"), "-", env!("LFZ_COMMIT")));
    if folder.is_dir() {
        return Ok(folder);
    }
    let named = |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", parent.display()));
    fs::create_dir_all(&parent).map_err(named)?;
    // Others see all of it or nothing, and several may begin at once.
    let unpacked = tempfile::Builder::new().prefix(".unpacked-").tempdir_in(&parent).map_err(named)?;
    Archive::new(GzDecoder::new(RUNTIME)).unpack(unpacked.path()).map_err(named)?;
    let unpacked = unpacked.keep();
    if let Err(error) = fs::rename(&unpacked, &folder) {
        let _ = fs::remove_dir_all(&unpacked);
        if !folder.is_dir() {
            return Err(named(error));
        }
    }
    Ok(folder)
}
