// SPDX-License-Identifier: Apache-2.0
//! From generated code back to the program.

use std::path::Path;

use lf_compiler::emit::Emitted;

use super::rustc::{Origin, Place};
use super::source::Program;

/// The program behind the generated crates in a folder.
pub(super) struct LfOrigin<'a> {
    program: &'a Program,
    emitted: &'a Emitted,
    out: &'a Path,
}

impl<'a> LfOrigin<'a> {
    pub(super) fn new(program: &'a Program, emitted: &'a Emitted, out: &'a Path) -> Self {
        Self { program, emitted, out }
    }
}

impl Origin for LfOrigin<'_> {
    fn place(&self, generated: &str, line: usize, column: usize) -> Option<Place> {
        // rustc names files of the workspace relative to it, others by their full path.
        let path = Path::new(generated);
        let path = path.strip_prefix(self.out).unwrap_or(path).to_str()?;
        let map = &self.emitted.source_map;
        let (lf_path, lf_line, lf_column) = map.to_lf(path, line, column)?;
        let verbatim = map.is_verbatim(path, line, column);
        Some(Place { path: lf_path.to_owned(), line: lf_line, column: lf_column, verbatim })
    }

    fn text(&self, path: &str) -> Option<&str> {
        let mut files = self.program.diagnostics.sources().iter();
        files.find(|(_, file)| file.path() == path).map(|(_, file)| file.text())
    }
}
