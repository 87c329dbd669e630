// SPDX-License-Identifier: Apache-2.0
//! From generated code back to the program, which is LF and files of Rust that are part of it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use lf_compiler::emit::Emitted;
use lf_compiler::plan::Plan;

use super::rustc::{LfPlace, Origin};
use super::scopes::Scope;
use super::source::Program;

/// The program behind the generated crates in a folder.
pub(super) struct LfOrigin<'a> {
    program: &'a Program,
    emitted: &'a Emitted,
    out: &'a Path,
    included: BTreeMap<String, String>,
    scopes: Vec<Scope>,
    current: PathBuf,
}

impl<'a> LfOrigin<'a> {
    pub(super) fn new(program: &'a Program, emitted: &'a Emitted, out: &'a Path) -> Self {
        let (included, scopes) = (included(&program.plan), Scope::all(&program.plan));
        let current = std::env::current_dir().unwrap_or_default();
        Self { program, emitted, out, included, scopes, current }
    }
}

impl LfOrigin<'_> {
    /// An absolute path as people want it: from the current folder on, if it is in there.
    fn shown<'p>(&self, path: &'p str) -> &'p str {
        Path::new(path).strip_prefix(&self.current).ok().and_then(Path::to_str).unwrap_or(path)
    }
}

impl Origin for LfOrigin<'_> {
    fn place(&self, generated: &str, line: usize, column: usize) -> Option<LfPlace> {
        if self.included.contains_key(generated) {
            return Some(LfPlace { path: self.shown(generated).to_owned(), line, column, verbatim: true });
        }
        // The C compiler has been told where in the program its lines are.
        let mut sources = self.program.diagnostics.sources().iter();
        if sources.any(|(_, file)| file.path() == generated) {
            return Some(LfPlace { path: generated.to_owned(), line, column, verbatim: true });
        }
        // rustc names files of the workspace relative to it, others by their full path.
        let path = Path::new(generated);
        let path = path.strip_prefix(self.out).unwrap_or(path).to_str()?;
        let map = &self.emitted.source_map;
        let (lf_path, lf_line, lf_column) = map.to_lf(path, line, column)?;
        let verbatim = map.is_verbatim(path, line, column);
        Some(LfPlace { path: lf_path.to_owned(), line: lf_line, column: lf_column, verbatim })
    }

    fn text(&self, path: &str) -> Option<&str> {
        let mut files = self.program.diagnostics.sources().iter();
        let own = files.find(|(_, file)| file.path() == path).map(|(_, file)| file.text());
        let mut included = self.included.iter();
        own.or_else(|| included.find(|(included, _)| self.shown(included) == path).map(|(_, text)| text.as_str()))
    }

    fn scopes(&self) -> &[Scope] {
        &self.scopes
    }
}

/// The files that the program includes, by their absolute paths, as compilers name them. Those that cannot be read
/// these complain about themselves.
pub(super) fn included(plan: &Plan) -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    for module in &plan.target.cargo.modules {
        let Ok(path) = std::path::absolute(&module.path) else { continue };
        match path.parent().filter(|_| path.ends_with("mod.rs")) {
            Some(folder) => add_folder(folder, &mut files),
            None => add_file(&path, &mut files),
        }
    }
    let c = &plan.target.c;
    for path in c.sources.iter().chain(&c.headers).filter_map(|file| std::path::absolute(&file.path).ok()) {
        add_file(&path, &mut files);
    }
    files
}

fn add_folder(folder: &Path, files: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            add_folder(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            add_file(&path, files);
        }
    }
}

fn add_file(path: &Path, files: &mut BTreeMap<String, String>) {
    if let (Some(name), Ok(text)) = (path.to_str(), fs::read_to_string(path)) {
        files.insert(name.to_owned(), text);
    }
}
