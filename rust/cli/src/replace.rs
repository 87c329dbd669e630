// SPDX-License-Identifier: Apache-2.0
//! Replaces a file at once: nobody sees half of the new one, and an executable may be running meanwhile.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

/// Replaces the contents of a file, which keeps its permissions; a symbolic link stays one.
///
/// # Errors
/// When there is no such file, or none can be made beside it.
pub(crate) fn replace(file: &Path, contents: &[u8]) -> io::Result<()> {
    let file = fs::canonicalize(file)?;
    let mut new = tempfile::NamedTempFile::new_in(file.parent().unwrap_or(Path::new("/")))?;
    new.write_all(contents)?;
    fs::set_permissions(new.path(), fs::metadata(&file)?.permissions())?;
    new.persist(&file)?;
    Ok(())
}
