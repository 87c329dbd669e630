// SPDX-License-Identifier: Apache-2.0
//! The texts that an editor has open, in the place of those on disk.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lf_compiler::SourceProvider;
use lf_compiler::characters::decode;
use lsp_types::Uri;
use url::Url;

use crate::compile::Files;

/// The open files, by their paths. Two paths of one file are one where the file exists.
#[derive(Clone, Default)]
pub(super) struct Buffers {
    open: BTreeMap<PathBuf, Buffer>,
}

#[derive(Clone)]
struct Buffer {
    /// The path as the editor knows it.
    path: String,
    text: String,
}

impl Buffers {
    /// Sets the text of a file, and returns whether that is another one.
    pub(super) fn set(&mut self, uri: &Uri, text: String) -> bool {
        let Some(path) = path_of(uri) else { return false };
        // The compiler's texts have line feeds, and its places are in them.
        let text = decode(text.clone().into_bytes()).unwrap_or(text);
        let old = self.open.insert(real(&path), Buffer { path, text: text.clone() });
        old.is_none_or(|old| old.text != text)
    }

    /// Forgets a file, and returns whether it was open.
    pub(super) fn close(&mut self, uri: &Uri) -> bool {
        path_of(uri).is_some_and(|path| self.open.remove(&real(&path)).is_some())
    }

    /// Sets the text of a file by its path; it counts as open.
    pub(super) fn replace(&mut self, path: &str, text: String) {
        let known = self.open.get(&real(path)).map(|buffer| buffer.path.clone());
        let path_of_editor = known.unwrap_or_else(|| path.to_owned());
        self.open.insert(real(path), Buffer { path: path_of_editor, text });
    }

    /// Returns the paths of the open files.
    pub(super) fn paths(&self) -> impl Iterator<Item = &str> {
        self.open.values().map(|buffer| buffer.path.as_str())
    }

    /// Returns the path of a file that the editor has open, and its text.
    pub(super) fn get(&self, uri: &Uri) -> Option<(&str, &str)> {
        let buffer = self.open.get(&real(&path_of(uri)?))?;
        Some((&buffer.path, &buffer.text))
    }

    /// Returns the name by which the editor knows a file.
    pub(super) fn uri(&self, path: &str) -> Option<String> {
        let path = self.open.get(&real(path)).map_or(path, |buffer| &buffer.path);
        Url::from_file_path(std::path::absolute(path).ok()?).ok().map(String::from)
    }
}

impl SourceProvider for Buffers {
    fn read(&self, path: &str) -> Result<String, String> {
        match self.open.get(&real(path)) {
            Some(buffer) => decode(buffer.text.clone().into_bytes()),
            None => Files.read(path),
        }
    }

    fn exists(&self, path: &str) -> bool {
        self.open.contains_key(&real(path)) || Files.exists(path)
    }

    fn real_path(&self, path: &str) -> Option<PathBuf> {
        Files.real_path(path)
    }

    fn package_folders(&self) -> Vec<String> {
        Files.package_folders()
    }
}

/// Returns the path that names a file on this computer.
fn path_of(uri: &Uri) -> Option<String> {
    let path = Url::parse(uri.as_str()).ok()?.to_file_path().ok()?;
    path.to_str().map(str::to_owned)
}

fn real(path: &str) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| Path::new(path).to_owned())
}
