// SPDX-License-Identifier: Apache-2.0
//! The target properties for the C compiler: files of the program, and arguments.

use std::ffi::OsStr;
use std::path::Path;

use super::linking;
use super::paths::beside;
use super::reader::{TargetReader, text_of};
use crate::diagnostics::{Code, Diagnostic, Span};
use crate::plan::{CompilerFlag, Definition, IncludedFile, in_library, library_file};
use crate::syntax::ast::{Literal, Name, Property, PropertyKind, PropertyValue};

/// The schedulers of LF.
const SCHEDULERS: [&str; 5] = ["NP", "GEDF_NP", "GEDF_NP_CI", "ADAPTIVE", "STATIC"];

impl TargetReader<'_> {
    pub(super) fn c_sources(&mut self, key: &Name, value: &PropertyValue) {
        let wrong = "files of C end with `.c`, and headers are named in `c-headers`; what else there is to compile, a \
                     file for CMake can say (`cmake-include`)";
        let files = self.existing(key, value, Some(("c", wrong)));
        self.target.c.sources.extend(files);
    }

    pub(super) fn c_headers(&mut self, key: &Name, value: &PropertyValue) {
        let wrong = "headers end with `.h`, and files that are compiled are named in `c-sources`";
        let files = self.existing(key, value, Some(("h", wrong)));
        self.target.c.headers.extend(files);
    }

    pub(super) fn protobufs(&mut self, key: &Name, value: &PropertyValue) {
        let wrong = "files with messages of Protocol Buffers end with `.proto`";
        let files = self.existing(key, value, Some(("proto", wrong)));
        self.target.c.protobufs.extend(files);
    }

    pub(super) fn c_folders(&mut self, key: &Name, value: &PropertyValue) {
        let folders = self.existing(key, value, None);
        self.target.c.folders.extend(folders);
    }

    /// Returns the files, or folders, that a property names: those that exist and whose names have one of these
    /// extensions, of which there is a hint.
    fn existing(&mut self, key: &Name, value: &PropertyValue, extension: Option<(&str, &str)>) -> Vec<IncludedFile> {
        let mut found: Vec<IncludedFile> = Vec::new();
        for (written, span) in self.items(key, value) {
            let path = beside(self.sources, self.path_of(span), &written);
            let end = Path::new(&path).extension().and_then(OsStr::to_str);
            if let Some((_, hint)) = extension.filter(|(expected, _)| end != Some(*expected)) {
                let message = format!("`{}` does not take `{written}`", key.text);
                self.found.push(Diagnostic::new(Code::BadPropertyValue, span, message).hint(hint));
            } else if !self.sources.exists(&path) {
                self.missing(span, &path, "it does not exist");
            } else {
                let at = self.at(span);
                found.push(IncludedFile { path, at });
            }
        }
        found
    }

    pub(super) fn files(&mut self, key: &Name, value: &PropertyValue) {
        for (written, span) in self.items(key, value) {
            let path = beside(self.sources, self.path_of(span), &written);
            if library_file(&written).is_some() {
                let at = self.at(span);
                self.target.c.files.push(IncludedFile { path: written, at });
            } else if in_library(&written).is_some() {
                let message = format!("`{written}` is a file of another compiler, which is not here");
                let hint = "remove it; what includes it is not found";
                self.found.push(Diagnostic::new(Code::IdleProperty, span, message).hint(hint));
            } else if self.sources.exists(&path) {
                let at = self.at(span);
                self.target.c.files.push(IncludedFile { path, at });
            } else {
                self.missing(span, &path, "it does not exist");
            }
        }
    }

    pub(super) fn cmake_include(&mut self, key: &Name, value: &PropertyValue) {
        for (written, span) in self.items(key, value) {
            let path = beside(self.sources, self.path_of(span), &written);
            if library_file(&written).is_some() {
                let at = self.at(span);
                self.target.c.cmake.push(IncludedFile { path: written, at });
                continue;
            }
            if in_library(&written).is_some() {
                let message = format!("`{written}` is a file of another compiler, which is not here");
                let hint = "copy it into the folder of this file, and name it from there";
                self.found.push(Diagnostic::new(Code::UnsupportedProperty, span, message).hint(hint));
                continue;
            }
            if self.sources.exists(&path) {
                let at = self.at(span);
                self.target.c.cmake.push(IncludedFile { path, at });
            } else {
                self.missing(span, &path, "it does not exist");
            }
        }
    }

    pub(super) fn definitions(&mut self, key: &Name, value: &PropertyValue) {
        let PropertyKind::Map(definitions) = &value.kind else {
            return self.bad(key, value, "macros in braces: `{ LIMIT: 3 }`");
        };
        self.unique(definitions);
        for Property { key, value } in definitions {
            let text = match &value.kind {
                PropertyKind::Literal(Literal::Float(text)) => Some(text.clone()),
                _ => text_of(value),
            };
            match text {
                Some(value) if is_identifier(&key.text) => {
                    let (name, at) = (key.text.clone(), self.at(key.span));
                    let first = self.target.c.definitions.iter().any(|it| it.name == name && it.at.file == at.file);
                    if !first {
                        self.target.c.definitions.push(Definition { name, value, at });
                    }
                }
                Some(_) => {
                    let message = format!("`{}` cannot be the name of a macro", key.text);
                    self.found.push(Diagnostic::new(Code::BadPropertyValue, key.span, message));
                }
                None => self.bad(key, value, "what the macro stands for, as a text or a number"),
            }
        }
    }

    pub(super) fn flags(&mut self, key: &Name, value: &PropertyValue) {
        for (text, span) in self.items(key, value) {
            // One text can contain several words, as on a command line.
            for word in text.split_whitespace() {
                if let Some(hint) = linking::refusal(word) {
                    let message = format!("`{word}` cannot be one of the `{}`", key.text);
                    self.found.push(Diagnostic::new(Code::BadPropertyValue, span, message).hint(hint));
                } else {
                    let at = self.at(span);
                    self.target.c.flags.push(CompilerFlag { text: word.to_owned(), at });
                }
            }
        }
    }

    pub(super) fn scheduler(&mut self, key: &Name, value: &PropertyValue) {
        if let PropertyKind::Map(options) = &value.kind {
            let text = |name: &str| options.iter().find(|option| option.key.text == name).map(|option| &option.value);
            match text("type") {
                Some(value) => self.scheduler(key, value),
                None => self.bad(key, value, "the `type` of a scheduler"),
            }
            return;
        }
        let text = text_of(value).unwrap_or_default();
        if !SCHEDULERS.iter().any(|known| known.eq_ignore_ascii_case(&text)) {
            self.bad(key, value, &format!("one of `{}`", SCHEDULERS.join("`, `")));
        }
    }

    /// Returns the path of the file that contains a place.
    pub(super) fn path_of(&self, span: Span) -> &str {
        self.texts.get(span.file).map_or("", |file| file.path())
    }
}

fn is_identifier(name: &str) -> bool {
    !name.starts_with(|first: char| first.is_ascii_digit())
        && name.chars().all(|one| one.is_ascii_alphanumeric() || one == '_')
}
