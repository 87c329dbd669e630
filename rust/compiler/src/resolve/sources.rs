// SPDX-License-Identifier: Apache-2.0
//! The sources of a program's texts.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::characters::{check_size, cleaned};

/// Reads the files of a program for the compiler, which itself reads none.
pub trait SourceProvider: Sync {
    /// Returns the text of the file at `path`.
    ///
    /// Paths are the main path as it was given, and imports relative to the importing file's folder, with `/` between
    /// the parts. `..` is left in where it follows a link, because there it leads elsewhere.
    ///
    /// # Errors
    /// Returns the reason why there is no such text, as the end of a sentence: `it does not exist`.
    fn read(&self, path: &str) -> Result<String, String>;

    /// Returns whether there is a file or a folder at `path`, text or not.
    fn exists(&self, path: &str) -> bool {
        self.read(path).is_ok()
    }

    /// Returns the one path of the file or folder that has no links and no `..` in it; `None` if the provider has no
    /// such paths, or nothing exists at `path`.
    fn real_path(&self, _path: &str) -> Option<PathBuf> {
        None
    }

    /// Returns the folders in which packages are searched after those of the program's own project.
    fn package_folders(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Returns the text of a file, without the additions of some editors.
///
/// # Errors
/// Returns the reason why there is none, as the end of a sentence.
pub(super) fn read(sources: &dyn SourceProvider, path: &str) -> Result<String, String> {
    let text = sources.read(path)?;
    check_size(text.len() as u64)?;
    Ok(match cleaned(&text) {
        Cow::Borrowed(same) if same.len() == text.len() => text,
        other => other.into_owned(),
    })
}

/// Texts by path.
impl SourceProvider for BTreeMap<String, String> {
    fn read(&self, path: &str) -> Result<String, String> {
        self.get(path).cloned().ok_or_else(|| "it does not exist".to_owned())
    }
}
