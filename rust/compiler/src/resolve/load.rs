// SPDX-License-Identifier: Apache-2.0
//! The files of a program: the main one and those that it imports.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::paths::{PACKAGE_FOLDERS, identity, in_package, join, normalize};
use super::sources::{SourceProvider, read};
use crate::characters::cleaned;
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Span, did_you_mean};
use crate::lexical::Language;
use crate::syntax::ast::{Import, ImportSource, ImportedReactor, Name, SourceUnit};
use crate::syntax::parse;

/// The maximum nesting of imports.
const DEPTH_MAX: usize = 200;

/// The number of a reactor in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct ReactorId {
    pub(crate) unit: usize,
    pub(crate) reactor: usize,
}

/// A file of a program.
#[derive(Debug)]
pub(crate) struct Unit {
    pub(crate) path: String,
    pub(crate) ast: SourceUnit,
    /// The reactors that can be instantiated in this file, by their names there.
    pub(crate) scope: BTreeMap<String, ReactorId>,
}

/// All files of a program, the main one first; a unit's position is that of its text in the source map.
#[derive(Debug)]
pub(crate) struct Program {
    pub(crate) units: Vec<Unit>,
}

impl Program {
    /// Returns the language of a file: that of its own target declaration, or else that of the main file.
    pub(crate) fn language(&self, unit: usize) -> Language {
        let target = |unit: usize| self.units.get(unit)?.ast.target.as_ref();
        let named = [unit, 0].into_iter().find_map(|unit| Language::named(&target(unit)?.name.text));
        named.unwrap_or_default()
    }

    /// Returns the name in the target declaration that counts for the language of a file: the main file's, if that has
    /// the same language.
    pub(crate) fn target_name(&self, unit: usize) -> &str {
        let named = |unit: usize| self.units.get(unit)?.ast.target.as_ref().map(|target| target.name.text.as_str());
        let is_main = self.language(unit) == self.language(0);
        [if is_main { 0 } else { unit }, unit].into_iter().find_map(named).unwrap_or_default()
    }
}

/// Reads the main file and all imports. Returns `None` if the main file cannot be read.
pub(crate) fn load(path: &str, sources: &dyn SourceProvider, diagnostics: &mut Diagnostics) -> Option<Program> {
    let mut loader = Loader { sources, diagnostics, units: Vec::new(), by_identity: BTreeMap::new(), depth: 0 };
    let path = normalize(sources, path);
    match read(sources, &path) {
        Ok(text) => {
            loader.add(&path, &text);
            Some(Program { units: loader.units })
        }
        Err(reason) => {
            let file = loader.diagnostics.sources_mut().add(path.clone(), String::new());
            let message = format!("cannot read `{path}`: {reason}");
            let longer = format!("{path}.lf");
            let hint = if sources.read(&longer).is_ok() {
                format!("did you mean `{longer}`?")
            } else {
                "name the file of LF that has the main reactor".to_owned()
            };
            let diagnostic = Diagnostic::new(Code::MissingFile, Span::new(file, 0, 0), message);
            loader.diagnostics.push(diagnostic.hint(hint));
            None
        }
    }
}

/// Reads one file without its imports.
pub(crate) fn alone(path: &str, text: &str, diagnostics: &mut Diagnostics) -> Program {
    let text = cleaned(text);
    let file = diagnostics.sources_mut().add(path.to_owned(), text.clone().into_owned());
    let (ast, found) = parse(file, path, &text);
    diagnostics.extend(found);
    Program { units: vec![Unit { path: path.to_owned(), ast, scope: BTreeMap::new() }] }
}

/// Returns whether a path is that of a file of LF, or of micro LF.
fn is_lf(path: &str) -> bool {
    Path::new(path)
        .extension()
        .is_some_and(|extension| ["lf", "ulf"].iter().any(|own| extension.eq_ignore_ascii_case(own)))
}

struct Loader<'a> {
    sources: &'a dyn SourceProvider,
    diagnostics: &'a mut Diagnostics,
    units: Vec<Unit>,
    /// The files by identity, because one file can have several names.
    by_identity: BTreeMap<PathBuf, usize>,
    /// The number of files whose imports are being followed, each of which imports the next one.
    depth: usize,
}

impl Loader<'_> {
    /// Adds a file and its imports; returns its position.
    fn add(&mut self, path: &str, text: &str) -> usize {
        let file = self.diagnostics.sources_mut().add(path.to_owned(), text.to_owned());
        let (ast, found) = parse(file, path, text);
        self.diagnostics.extend(found);
        let unit = self.units.len();
        let scope = self.own_reactors(unit, &ast);
        let imports = ast.imports.clone();
        self.units.push(Unit { path: path.to_owned(), ast, scope });
        self.by_identity.insert(identity(self.sources, path), unit);
        self.depth += 1;
        for import in &imports {
            self.import(unit, import);
        }
        self.depth -= 1;
        unit
    }

    fn own_reactors(&mut self, unit: usize, ast: &SourceUnit) -> BTreeMap<String, ReactorId> {
        let mut scope = BTreeMap::new();
        for (reactor, declared) in ast.reactors.iter().enumerate() {
            let Some(name) = &declared.name else { continue };
            if let Some(ReactorId { reactor: first, .. }) = scope.get(&name.text) {
                let first: &crate::syntax::ast::Reactor = &ast.reactors[*first];
                self.duplicate(name, first.span());
            } else {
                scope.insert(name.text.clone(), ReactorId { unit, reactor });
            }
        }
        scope
    }

    fn duplicate(&mut self, name: &Name, first: Span) {
        let message = format!("there is already a reactor `{}` in this file", name.text);
        self.diagnostics.push(
            Diagnostic::new(Code::DuplicateName, name.span, message)
                .also(first, "the first one")
                .hint("rename one of them; an imported reactor can be renamed by `import X as Y from …`"),
        );
    }

    fn import(&mut self, unit: usize, import: &Import) {
        let own = &self.units[unit].path;
        match &import.source {
            ImportSource::File(name) => {
                let path = join(self.sources, own, &name.text);
                self.import_from(unit, &[path], name, &import.reactors, import.span);
            }
            // Without a file name, each reactor is in a file of its name.
            ImportSource::Package(name) if !is_lf(&name.text) => {
                for imported in &import.reactors {
                    let file = format!("{}/{}.lf", name.text, imported.name.text);
                    let paths = self.in_package(unit, &file);
                    self.import_from(unit, &paths, name, std::slice::from_ref(imported), import.span);
                }
            }
            ImportSource::Package(name) => {
                let paths = self.in_package(unit, &name.text);
                self.import_from(unit, &paths, name, &import.reactors, import.span);
            }
        }
    }

    /// Returns the possible paths of a package's file, by its own ending and by the other one of LF.
    fn in_package(&self, unit: usize, file: &str) -> Vec<String> {
        let other = match file.strip_suffix(".ulf") {
            Some(stem) => format!("{stem}.lf"),
            None => format!("{}.ulf", file.trim_end_matches(".lf")),
        };
        let own = &self.units[unit].path;
        [file, &other].into_iter().flat_map(|file| in_package(self.sources, own, file)).collect()
    }

    /// Imports reactors from the first of these files that exists.
    fn import_from(&mut self, unit: usize, paths: &[String], name: &Name, reactors: &[ImportedReactor], span: Span) {
        let known = |path: &String| self.by_identity.contains_key(&identity(self.sources, path));
        let there = |path: &&String| known(path) || self.sources.read(path).is_ok();
        let Some(path) = paths.iter().find(there).or(paths.first()) else { return };
        let Some(from) = self.imported_unit(path, name, span) else { return };
        for imported in reactors {
            let found = self.units[from]
                .ast
                .reactors
                .iter()
                .position(|reactor| reactor.name.as_ref().is_some_and(|name| name.text == imported.name.text));
            let Some(reactor) = found else {
                let names = self.units[from].ast.reactors.iter().filter_map(|reactor| reactor.name.as_ref());
                let message = format!("`{path}` has no reactor `{}`", imported.name.text);
                let hint = did_you_mean(&imported.name.text, names.map(|name| name.text.as_str()));
                self.diagnostics
                    .push(Diagnostic::new(Code::MissingImport, imported.name.span, message).hint_maybe(hint));
                continue;
            };
            let local = imported.alias.as_ref().unwrap_or(&imported.name);
            let id = ReactorId { unit: from, reactor };
            match self.units[unit].scope.get(&local.text).copied() {
                Some(first) if first != id => {
                    let first = self.units[first.unit].ast.reactors[first.reactor].span();
                    self.duplicate(local, first);
                }
                _ => {
                    self.units[unit].scope.insert(local.text.clone(), id);
                }
            }
        }
    }

    fn imported_unit(&mut self, path: &str, name: &Name, span: Span) -> Option<usize> {
        if let Some(known) = self.by_identity.get(&identity(self.sources, path)).copied() {
            // Files may import each other: the reactors of an open file are known already.
            return Some(known);
        }
        if self.depth >= DEPTH_MAX {
            let message = format!("files import each other more than {DEPTH_MAX} levels deep");
            let hint = "import what is needed directly from the file that has it";
            self.diagnostics.push(Diagnostic::new(Code::NestingTooDeep, span, message).hint(hint));
            return None;
        }
        match read(self.sources, path) {
            Ok(text) => Some(self.add(path, &text)),
            Err(reason) => {
                let message = format!("cannot read `{path}`: {reason}");
                let package = path.contains(PACKAGE_FOLDERS[0]);
                let hint = if package {
                    "packages lie in `lf-packages/` or `build/lfc_include/`, beside the folder `src` of this file, or \
                     in a folder that the environment variable `LF_PACKAGES` names"
                } else {
                    "the path is relative to the folder of this file"
                };
                self.diagnostics.push(Diagnostic::new(Code::MissingFile, name.span, message).hint(hint));
                None
            }
        }
    }
}
