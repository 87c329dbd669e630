// SPDX-License-Identifier: Apache-2.0
//! The files of the repository: what git tracks or would track.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process;

/// Every file of the repository, with its text.
pub(crate) struct Tree {
    /// The repository.
    pub(crate) root: PathBuf,
    /// The files, sorted by path.
    pub(crate) files: Vec<File>,
}

/// One file.
pub(crate) struct File {
    /// Relative to the repository, with `/`.
    pub(crate) path: String,
    /// In bytes.
    pub(crate) size: u64,
    /// `None` when it is not UTF-8 text.
    pub(crate) text: Option<String>,
}

impl File {
    /// Returns the ending of the name, or the whole name when it has none.
    pub(crate) fn kind(&self) -> &str {
        let name = self.path.rsplit('/').next().unwrap_or(&self.path);
        name.rsplit('.').next().unwrap_or(name)
    }
}

impl Tree {
    /// Reads the tree; without git (an unpacked archive), all files but those in build folders.
    pub(crate) fn read(root: &Path) -> io::Result<Self> {
        let arguments = ["ls-files", "--cached", "--others", "--exclude-standard"];
        let mut paths: Vec<String> = match process::captured(Command::new("git").current_dir(root).args(arguments)) {
            Some(list) => list.lines().map(str::to_owned).collect(),
            None => walk(root, "")?,
        };
        paths.sort();
        paths.dedup();
        let mut files = Vec::new();
        for path in paths {
            let full = root.join(&path);
            // A tracked file may have been deleted and not yet committed, and a link may lead out of the tree.
            if fs::symlink_metadata(&full).is_ok_and(|metadata| metadata.is_file()) {
                let bytes = fs::read(&full)?;
                files.push(File { path, size: bytes.len() as u64, text: String::from_utf8(bytes).ok() });
            }
        }
        Ok(Self { root: root.to_path_buf(), files })
    }
}

fn walk(root: &Path, below: &str) -> io::Result<Vec<String>> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(root.join(below))? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let path = if below.is_empty() { name.clone() } else { format!("{below}/{name}") };
        if !entry.file_type()?.is_dir() {
            paths.push(path);
        } else if !matches!(name.as_str(), "target" | "build" | "__pycache__" | "node_modules")
            && !name.starts_with('.')
        {
            paths.extend(walk(root, &path)?);
        }
    }
    Ok(paths)
}
