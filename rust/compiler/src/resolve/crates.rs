// SPDX-License-Identifier: Apache-2.0
//! The target properties for cargo: crates and modules of bodies, and the profile.

use super::paths::beside;
use super::reader::{TargetReader, text_of};
use crate::diagnostics::{Code, Diagnostic, Span};
use crate::plan::{BuildType, Dependency, FileIndex, Location, Module};
use crate::syntax::ast::{Literal, Name, Property, PropertyKind, PropertyValue};

/// The keys of a dependency.
const KEYS: [&str; 10] =
    ["version", "path", "features", "git", "branch", "tag", "rev", "default-features", "optional", "package"];

/// The runtime of LF's own compiler, of which some programs select features.
const RUNTIME_OF_LFC: &str = "reactor_rt";

/// Names of crates and of modules that generated crates use themselves.
const TAKEN: [&str; 8] = ["lf", "c", "federate", "rti", "main", "lib", "core", "std"];

/// The editions, except for the first, whose paths are different.
const EDITIONS: [&str; 3] = ["2018", "2021", "2024"];

impl TargetReader<'_> {
    pub(super) fn dependencies(&mut self, key: &Name, value: &PropertyValue) {
        let PropertyKind::Map(crates) = &value.kind else {
            return self.bad(key, value, "crates in braces: `{ libm: \"0.2\" }`");
        };
        self.unique(crates);
        for Property { key, value } in crates {
            if key.text == RUNTIME_OF_LFC {
                self.idle(key, "it is the runtime of another compiler");
            } else if TAKEN.contains(&key.text.as_str()) {
                let message = format!("`{}` is a name that generated crates have for themselves", key.text);
                let hint = "choose another one, and write `package: \"…\"` beside the version";
                self.found.push(Diagnostic::new(Code::BadPropertyValue, key.span, message).hint(hint));
            } else if let Some(dependency) = self.dependency(key, value) {
                self.target.cargo.dependencies.push(dependency);
            }
        }
    }

    fn dependency(&mut self, key: &Name, value: &PropertyValue) -> Option<Dependency> {
        let mut found = Dependency {
            name: key.text.clone(),
            package: None,
            version: None,
            path: None,
            git: None,
            branch: None,
            tag: None,
            rev: None,
            features: Vec::new(),
            default_features: true,
            optional: false,
            at: self.at(key.span),
        };
        let PropertyKind::Map(properties) = &value.kind else {
            found.version = self.text(key, value, "a version or a list in braces");
            return found.version.is_some().then_some(found);
        };
        self.unique(properties);
        for Property { key, value } in properties {
            match key.text.as_str() {
                "version" => found.version = self.text(key, value, "a version in quotes"),
                "package" => found.package = self.text(key, value, "the name of a package in quotes"),
                "git" => found.git = self.text(key, value, "the URL of a repository in quotes"),
                "branch" => found.branch = self.text(key, value, "the name of a branch in quotes"),
                "tag" => found.tag = self.text(key, value, "a tag in quotes"),
                "rev" => found.rev = self.text(key, value, "a commit in quotes"),
                "path" => found.path = self.crate_folder(key, value),
                "features" => found.features = self.items(key, value).into_iter().map(|(text, _)| text).collect(),
                "default-features" => found.default_features = self.boolean(key, value).unwrap_or(true),
                "optional" => found.optional = self.boolean(key, value).unwrap_or_default(),
                _ => self.unknown(key, KEYS.into_iter(), &[]),
            }
        }
        let is_found = found.version.is_some() || found.path.is_some() || found.git.is_some();
        if !is_found && !properties.iter().any(|one| ["version", "path", "git"].contains(&one.key.text.as_str())) {
            let message = format!("nothing says where the crate `{}` comes from", key.text);
            let hint = "write `version`, `path` or `git`";
            self.found.push(Diagnostic::new(Code::BadPropertyValue, value.span, message).hint(hint));
        }
        is_found.then_some(found)
    }

    /// Returns the folder of a crate, which has to exist.
    fn crate_folder(&mut self, key: &Name, value: &PropertyValue) -> Option<String> {
        let written = self.text(key, value, "a folder in quotes")?;
        let folder = beside(self.sources, self.path_of(key.span), &written);
        let manifest = beside(self.sources, "", &format!("{folder}/Cargo.toml"));
        match self.sources.read(&manifest) {
            Ok(_) => Some(folder),
            Err(reason) => {
                self.missing(value.span, &manifest, &reason);
                None
            }
        }
    }

    /// Reads `cargo-features`, after the dependencies. All programs have the feature for the command line anyway.
    pub(super) fn features(&mut self, key: &Name, value: &PropertyValue) {
        for (feature, span) in self.items(key, value).into_iter().filter(|(feature, _)| feature != "cli") {
            let (name, is_of_it) = feature.split_once('/').map_or((feature.as_str(), false), |(name, _)| (name, true));
            let name = name.strip_suffix('?').unwrap_or(name);
            let mut dependencies = self.target.cargo.dependencies.iter();
            if dependencies.any(|one| one.name == name && (one.optional || is_of_it)) {
                self.target.cargo.features.push(feature);
            } else {
                let message = format!("generated crates have no feature `{feature}`");
                let hint = "features are the names of optional `cargo-dependencies`, and `name/feature` of any of them";
                self.found.push(Diagnostic::new(Code::BadPropertyValue, span, message).hint(hint));
            }
        }
    }

    pub(super) fn modules(&mut self, key: &Name, value: &PropertyValue) {
        for (written, span) in self.items(key, value) {
            let path = beside(self.sources, self.path_of(span), &written);
            let name = path.rsplit('/').next().unwrap_or(&path);
            let (name, file) = match name.strip_suffix(".rs") {
                Some(stem) => (stem.to_owned(), path.clone()),
                None => (name.to_owned(), beside(self.sources, "", &format!("{path}/mod.rs"))),
            };
            let is_name = name.chars().all(|one| one.is_ascii_alphanumeric() || one == '_');
            if !is_name || name.starts_with(|first: char| first.is_ascii_digit()) || name.is_empty() {
                let message = format!("`{name}` cannot be the name of a module");
                let hint = "name a file of Rust, like `\"filters.rs\"`, or a folder that has a file `mod.rs`";
                self.found.push(Diagnostic::new(Code::BadPropertyValue, span, message).hint(hint));
            } else if TAKEN.contains(&name.as_str()) {
                let message = format!("`{name}` is a name that generated crates have for themselves");
                self.found.push(Diagnostic::new(Code::BadPropertyValue, span, message).hint("rename the file"));
            } else if self.target.cargo.modules.iter().any(|module| module.name == name) {
                let message = format!("there are two modules with the name `{name}`");
                self.found.push(Diagnostic::new(Code::DuplicateName, span, message).hint("rename one of the files"));
            } else if let Err(reason) = self.sources.read(&file) {
                self.missing(span, &file, &reason);
            } else {
                let at = self.at(span);
                self.target.cargo.modules.push(Module { name, path: file, at });
            }
        }
    }

    pub(super) fn build_type(&mut self, key: &Name, value: &PropertyValue) {
        let text = text_of(value).unwrap_or_default();
        if let Some(known) = BuildType::ALL.into_iter().find(|one| one.name().eq_ignore_ascii_case(&text)) {
            self.target.cargo.build_type = known;
        } else {
            let names = BuildType::ALL.map(|one| format!("`{}`", one.name())).join(", ");
            self.bad(key, value, &format!("one of {names}"));
        }
    }

    pub(super) fn edition(&mut self, key: &Name, value: &PropertyValue) {
        self.target.cargo.edition = self.word(key, value, &EDITIONS).map(str::to_owned);
    }

    pub(super) fn missing(&mut self, span: Span, path: &str, reason: &str) {
        let message = format!("cannot read `{path}`: {reason}");
        let hint = "the path is relative to the folder of this file";
        self.found.push(Diagnostic::new(Code::MissingFile, span, message).hint(hint));
    }

    /// Returns a text that is not empty.
    pub(super) fn text(&mut self, key: &Name, value: &PropertyValue, expected: &str) -> Option<String> {
        let text = match &value.kind {
            PropertyKind::Literal(Literal::Text(_) | Literal::Int(_)) | PropertyKind::Path(_) => text_of(value),
            PropertyKind::Literal(Literal::Float(text)) => Some(text.clone()),
            _ => None,
        };
        let text = text.filter(|text| !text.is_empty());
        if text.is_none() {
            self.bad(key, value, expected);
        }
        text
    }

    /// Returns one text as a list, or a list of them.
    pub(super) fn items(&mut self, key: &Name, value: &PropertyValue) -> Vec<(String, Span)> {
        let one = std::slice::from_ref(value);
        let items = if let PropertyKind::List(items) = &value.kind { items } else { one };
        let text = |item| Some((self.text(key, item, "texts: `[\"one\", \"another\"]`")?, item.span));
        items.iter().filter_map(text).collect()
    }

    /// Returns a place in a file, which has the position in the plan that its text has.
    pub(super) fn at(&self, span: Span) -> Location {
        let position = self.texts.get(span.file).map(|file| file.position(span.start));
        let (line, column) = position.map_or((1, 1), |position| (position.line, position.column));
        Location { file: FileIndex(span.file.index()), line, column }
    }
}
