// SPDX-License-Identifier: Apache-2.0
//! Places in the program for those in generated files, as debugging information has them.

use std::collections::HashMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use lf_compiler::emit::SourceMap;

/// A folder with generated files, and the way back from them to the program.
pub(crate) struct Generated<'a> {
    /// The folder.
    pub(crate) folder: &'a Path,
    /// The map of the files in it.
    pub(crate) map: &'a SourceMap,
    /// The folder from which relative paths of the program count.
    pub(crate) current: &'a Path,
}

/// A place in the program. The column counts bytes, from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// The absolute path of the file.
    pub(super) file: PathBuf,
    pub(super) line: u64,
    pub(super) column: u64,
}

/// The places of generated code. Maps count columns in characters and compilers in bytes, so the texts are read.
pub(super) struct Origins<'a> {
    generated: &'a Generated<'a>,
    /// The folder without symbolic links, as the compiler names it.
    folder: PathBuf,
    /// The folders of compiled files that have been looked up, without symbolic links, if they lie in it. Each table of
    /// lines names hundreds of files of the runtime and of the standard library, in the same few folders.
    folders: HashMap<PathBuf, Option<PathBuf>>,
    texts: HashMap<PathBuf, Vec<String>>,
}

impl<'a> Origins<'a> {
    /// Returns the places of the files in a folder.
    ///
    /// # Errors
    /// When the folder does not exist.
    pub(super) fn new(generated: &'a Generated<'a>) -> io::Result<Self> {
        Ok(Self {
            generated,
            folder: fs::canonicalize(generated.folder)?,
            folders: HashMap::new(),
            texts: HashMap::new(),
        })
    }

    /// Returns the path of a generated file in the folder; `None` for a file from elsewhere.
    pub(super) fn generated(&mut self, path: &Path) -> Option<String> {
        if path.is_relative() {
            return self.without_beginning(path);
        }
        // What was compiled elsewhere need not exist here.
        let parent = path.parent()?;
        let own = &self.folder;
        let real = || fs::canonicalize(parent).ok().filter(|folder| folder.starts_with(own));
        let folder = self.folders.entry(parent.to_owned()).or_insert_with(real).as_ref()?;
        let path = fs::canonicalize(folder.join(path.file_name()?)).ok()?;
        Some(path.strip_prefix(&self.folder).ok()?.to_str()?.to_owned())
    }

    /// Returns the path of a generated file in the folder, by a path without the place of the repository, as in images:
    /// the folder's own path ends with the beginning of that.
    fn without_beginning(&self, path: &Path) -> Option<String> {
        let beginning = path.ancestors().find(|part| *part != Path::new("") && self.folder.ends_with(part))?;
        let rest = path.strip_prefix(beginning).ok()?;
        self.folder.join(rest).is_file().then(|| rest.to_str().map(str::to_owned))?
    }

    /// Returns the place in the program of what stands at a place in a generated file; `None` for scaffolding.
    pub(super) fn place(&mut self, generated: &str, line: u64, column: u64) -> Option<Place> {
        let (number, byte) = (usize::try_from(line).ok()?, usize::try_from(column).ok()?.checked_sub(1)?);
        let path = self.folder.join(generated);
        let before = self.line(&path, number)?.get(..byte)?.chars().count();
        let map = self.generated.map;
        if !map.is_verbatim(generated, number, before + 1) {
            return None;
        }
        let (lf, line, column) = map.to_lf(generated, number, before + 1)?;
        let file = self.generated.current.join(lf);
        // A file that has been edited since may have a shorter line.
        let before = self.line(&file, line).map(|text| text.chars().take(column - 1).map(char::len_utf8).sum());
        let column = before.unwrap_or(column - 1) + 1;
        Some(Place { file, line: u64::try_from(line).ok()?, column: u64::try_from(column).ok()? })
    }

    /// Returns the line of this number, from 1, of a file.
    fn line(&mut self, path: &Path, number: usize) -> Option<&str> {
        let lines = self
            .texts
            .entry(path.to_owned())
            .or_insert_with(|| fs::read_to_string(path).unwrap_or_default().lines().map(str::to_owned).collect());
        lines.get(number.checked_sub(1)?).map(String::as_str)
    }
}
