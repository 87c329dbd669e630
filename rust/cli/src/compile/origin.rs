// SPDX-License-Identifier: Apache-2.0
//! Maps generated code back to the program, which is LF and files of Rust that are part of it.

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
    pub(super) current: PathBuf,
}

impl<'a> LfOrigin<'a> {
    pub(super) fn new(program: &'a Program, emitted: &'a Emitted, out: &'a Path) -> Self {
        let (included, scopes) = (included(&program.plan), Scope::all(&program.plan));
        let current = std::env::current_dir().unwrap_or_default();
        Self { program, emitted, out, included, scopes, current }
    }
}

impl LfOrigin<'_> {
    /// Returns an absolute path in the form for users: relative to the current folder, if it is in there.
    fn shown<'p>(&self, path: &'p str) -> &'p str {
        Path::new(path).strip_prefix(&self.current).ok().and_then(Path::to_str).unwrap_or(path)
    }
}

impl Origin for LfOrigin<'_> {
    fn place(&self, generated: &str, line: usize, column: usize) -> Option<LfPlace> {
        // `#line` directives gave the C compiler the places of its lines in the program.
        let mut sources = self.program.diagnostics.sources().iter();
        if sources.any(|(_, file)| file.path() == generated) {
            return Some(LfPlace { path: generated.to_owned(), line, column, verbatim: true });
        }
        if let Some(path) = known(&self.included, generated) {
            return Some(LfPlace { path: self.shown(path).to_owned(), line, column, verbatim: true });
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

/// Returns the file among these that a compiler's path names. The compiler may have found it by another path than the
/// user: through include folders, `..` and symbolic links.
pub(super) fn known<'f, T>(files: &'f BTreeMap<String, T>, generated: &str) -> Option<&'f str> {
    if !Path::new(generated).is_absolute() {
        return None;
    }
    let path = fs::canonicalize(generated).ok()?;
    files.get_key_value(path.to_str()?).map(|(path, _)| path.as_str())
}

/// Returns the files that the program includes, by their absolute paths without symbolic links. Compilers themselves
/// report unreadable files.
pub(super) fn included(plan: &Plan) -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    for module in &plan.target.cargo.modules {
        let Ok(path) = fs::canonicalize(&module.path) else { continue };
        match path.parent().filter(|_| module.path.ends_with("mod.rs")) {
            Some(folder) => add_folder(folder, &["rs"], &mut files),
            None => add_file(&path, &mut files),
        }
    }
    let c = &plan.target.c;
    let named = [&c.sources, &c.headers, &c.files, &c.cmake].into_iter().flatten().map(|file| Path::new(&file.path));
    // Only CMake knows which files beside one of its own are compiled.
    for path in named.chain(c.cmake.iter().filter_map(|cmake| Path::new(&cmake.path).parent())) {
        match fs::canonicalize(if path.as_os_str().is_empty() { Path::new(".") } else { path }) {
            Ok(path) if path.is_dir() => add_folder(&path, &["c", "h", "cc", "cpp", "cxx", "hpp"], &mut files),
            Ok(path) => add_file(&path, &mut files),
            Err(_) => {}
        }
    }
    files
}

/// Adds the files in a folder that have one of these extensions.
fn add_folder(folder: &Path, extensions: &[&str], files: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            // Results of builds are no sources, and there can be many.
            let name = entry.file_name();
            if ["build", "target", "src-gen", "fed-gen"].iter().any(|built| name == *built)
                || name.to_string_lossy().starts_with('.')
            {
                continue;
            }
            add_folder(&path, extensions, files);
        } else if path.extension().is_some_and(|extension| extensions.iter().any(|one| extension == *one)) {
            add_file(&path, files);
        }
    }
}

fn add_file(path: &Path, files: &mut BTreeMap<String, String>) {
    if let (Some(name), Ok(text)) = (path.to_str(), fs::read_to_string(path)) {
        files.insert(name.to_owned(), text);
    }
}
