// SPDX-License-Identifier: Apache-2.0
//! Where the texts of a program come from.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::characters::{check_size, cleaned};

/// Reads the files of a program for the compiler, which itself reads none.
pub trait SourceProvider: Sync {
    /// The text of the file at `path`.
    ///
    /// Paths are the main path as it was given, and imports relative to the importing file's folder, with `/` between
    /// the parts. `..` is left in where it follows a link, because there it leads elsewhere.
    ///
    /// # Errors
    /// Why there is no such text, as the end of a sentence: `it does not exist`.
    fn read(&self, path: &str) -> Result<String, String>;

    /// Whether there is a file or a folder at `path`, text or not.
    fn exists(&self, path: &str) -> bool {
        self.read(path).is_ok()
    }

    /// The one path of the file or folder that has no links and no `..` in it; nothing where there are no such paths,
    /// or nothing is at `path`.
    fn real_path(&self, _path: &str) -> Option<PathBuf> {
        None
    }
}

/// The text of a file, without what some editors add.
///
/// # Errors
/// Why there is none, as the end of a sentence.
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
