// SPDX-License-Identifier: Apache-2.0
//! Checks the target declaration: the language, and each property, which is supported or refused by name.

use super::load::Program;
use super::of_main;
use super::properties::{IDLE, Imported, PROPERTIES, PropertyScope, REFUSED, RENAMED, TargetProperty, honoured, named};
use super::reader::TargetReader;
use super::sources::SourceProvider;
use crate::diagnostics::{Code, Diagnostic, Diagnostics, FileId, Span, did_you_mean};
use crate::lexical::{Language, is_cpp, is_micro};
use crate::plan;
use crate::syntax::ast::{Literal, Name, Property, PropertyKind, TargetSyntax};

/// Checks the target of the main file and returns the properties that have an effect.
///
/// As in LF, properties of imported files have no effect: they belong to the programs in those files. The exception are
/// those for bodies of another language than that of the main file.
pub(crate) fn check(program: &Program, sources: &dyn SourceProvider, diagnostics: &mut Diagnostics) -> plan::Target {
    let target = plan::Target::default();
    let mut reader = TargetReader { target, found: Vec::new(), sources, texts: diagnostics.sources() };
    let (main, imported) = program.units.split_first().map_or((None, &[][..]), |(main, rest)| (Some(main), rest));
    match main.and_then(|unit| unit.ast.target.as_ref()) {
        None => {
            let span = Span::new(FileId::default(), 0, 0);
            let diagnostic = Diagnostic::new(Code::WrongTarget, span, "this file does not say its target");
            reader.found.push(diagnostic.hint(format!("write `target {}` in the first line", Language::default())));
        }
        Some(target) => match Language::named(&target.name.text) {
            None => reader.wrong_target(target),
            Some(language) => {
                reader.target.language = language;
                reader.target.c.is_cpp = is_cpp(&target.name.text);
                reader.target.c.is_micro = is_micro(&target.name.text);
                if reader.target.c.is_micro {
                    // No RTI grants tags there.
                    reader.target.coordination = plan::Coordination::Decentralized;
                }
                let mut properties = reader.in_todays_words(&target.properties);
                properties.extend(main.into_iter().flat_map(|unit| of_main::properties(&unit.ast.reactors)));
                reader.unique(&properties);
                for property in &properties {
                    reader.property(property);
                }
                for is_late in [false, true] {
                    reader.read(language, &properties, |known| known.is_late == is_late);
                }
                reader.idle_options(&properties);
                reader.open_clocks(&properties);
                reader.workers(&properties);
            }
        },
    }
    for target in imported.iter().filter_map(|unit| unit.ast.target.as_ref()) {
        match Language::named(&target.name.text) {
            Some(language) => reader.imported(target, language),
            None => reader.wrong_target(target),
        }
    }
    let TargetReader { target, found, .. } = reader;
    diagnostics.extend(found);
    target
}

impl TargetReader<'_> {
    fn wrong_target(&mut self, target: &TargetSyntax) {
        let language = self.target.language;
        let message = format!("the target is `{}`, and only {} is compiled here", target.name.text, languages());
        let meant = did_you_mean(&target.name.text, Language::names());
        let hint = meant.unwrap_or_else(|| format!("write `target {language}`, and the reaction bodies in {language}"));
        self.found.push(Diagnostic::new(Code::WrongTarget, target.name.span, message).hint(hint));
    }

    /// Returns properties by the names that they have today, written as in the tables: LF ignores case.
    fn in_todays_words(&mut self, properties: &[Property]) -> Vec<Property> {
        let known = PROPERTIES.iter().map(|property| property.name);
        let known = known.chain(IDLE.iter().chain(REFUSED).map(|(name, _)| *name)).chain(RENAMED.map(|(name, _)| name));
        let mut all = properties.to_vec();
        for property in &mut all {
            let key = &mut property.key;
            if let Some(name) = known.clone().find(|name| name.eq_ignore_ascii_case(&key.text)) {
                name.clone_into(&mut key.text);
            }
            if let Some((old, name)) = RENAMED.iter().find(|(old, _)| *old == key.text) {
                let message = format!("`{old}` is called `{name}` now");
                let diagnostic = Diagnostic::new(Code::OlderForm, key.span, message);
                self.found.push(diagnostic.hint(format!("write `{name}`")));
                (*name).clone_into(&mut key.text);
            }
        }
        all
    }

    /// Reads those properties of a language for which `is_read` is true.
    fn read(&mut self, language: Language, properties: &[Property], is_read: impl Fn(&TargetProperty) -> bool) {
        for Property { key, value } in properties {
            if let Some(known) = named(&key.text, language).filter(|known| is_read(known)) {
                (known.read)(self, key, value);
            }
        }
    }

    /// Reads the settings of an imported file that apply to every program that imports it.
    fn imported(&mut self, target: &TargetSyntax, language: Language) {
        let is_other = self.target.language != language;
        let properties = self.in_todays_words(&target.properties);
        self.target.c.is_cpp |= is_other && is_cpp(&target.name.text);
        for is_late in [false, true] {
            self.read(language, &properties, |known| {
                let counts = match known.imported {
                    Imported::Never => false,
                    Imported::OfOtherLanguage => is_other,
                    Imported::Always => true,
                };
                counts && known.is_late == is_late
            });
        }
    }

    /// Reports a property that programs in this language do not have.
    fn property(&mut self, Property { key, .. }: &Property) {
        let (name, language) = (key.text.as_str(), self.target.language);
        if named(name, language).is_some() {
            return;
        }
        if let Some((_, reason)) = IDLE.iter().find(|(idle, _)| *idle == name) {
            self.idle(key, reason);
            return;
        }
        if let Some((_, hint)) = REFUSED.iter().find(|(refused, _)| *refused == name) {
            let message = format!("the target property `{name}` is not supported yet");
            self.found.push(Diagnostic::new(Code::UnsupportedProperty, key.span, message).hint(*hint));
            return;
        }
        match PROPERTIES.iter().find(|known| known.name == name).map(|known| known.scope) {
            Some(PropertyScope::Bodies(other)) => self.of_other_language(name, key, other),
            _ => self.unknown_to_all(key, language),
        }
    }

    /// Reports a property that nobody knows: an error if it may be a misspelled one, or else a warning, because other
    /// compilers may know it.
    fn unknown_to_all(&mut self, key: &Name, language: Language) {
        let known = honoured(language).map(|known| known.name);
        let listed = REFUSED.iter().chain(IDLE).map(|(name, _)| *name);
        if did_you_mean(&key.text, known.clone().chain(listed)).is_some() {
            return self.unknown(key, known, REFUSED);
        }
        let message = format!("there is no property `{}` here, so it has no effect", key.text);
        let names: Vec<_> = known.map(|name| format!("`{name}`")).collect();
        let hint = format!("properties are {}", names.join(", "));
        self.found.push(Diagnostic::new(Code::IdleProperty, key.span, message).hint(hint));
    }

    /// Reports a property of programs in another language.
    fn of_other_language(&mut self, name: &str, key: &Name, language: Language) {
        let message =
            format!("`{name}` is for bodies in {language}, and those of this program are {}", self.target.language);
        let hint = match name {
            "files" => "name files of C in `c-sources`, and headers in `c-headers`",
            "c-sources" | "c-headers" | "c-include-directories" => {
                "name headers in `files`, and what is compiled in a file for CMake (`cmake-include`)"
            }
            _ => "remove it",
        };
        self.found.push(Diagnostic::new(Code::UnsupportedProperty, key.span, message).hint(hint));
    }

    fn idle_options(&mut self, properties: &[Property]) {
        let options = properties.iter().find(|property| property.key.text == "clock-sync-options");
        let Some(options) = options else { return };
        match self.target.clock_sync {
            plan::ClockSync::Off => self.idle(&options.key, "with `clock-sync: off` nothing uses it"),
            plan::ClockSync::Init => {
                let PropertyKind::Map(properties) = &options.value.kind else { return };
                let only_on = |key: &str| matches!(key, "attenuation" | "period");
                for property in properties.iter().filter(|property| only_on(&property.key.text)) {
                    self.idle(&property.key, "only `clock-sync: on` uses it");
                }
            }
            plan::ClockSync::On => {}
        }
    }

    /// Reports datagrams that TLS does not encrypt.
    fn open_clocks(&mut self, properties: &[Property]) {
        if !self.target.security.is_tls() || self.target.clock_sync != plan::ClockSync::On {
            return;
        }
        let property = properties.iter().find(|property| property.key.text == "clock-sync");
        let Some(Property { key, value }) = property else { return };
        let message =
            "`comm-type: TLS` does not encrypt the datagrams of `clock-sync: on`, by which others can steer clocks";
        let hint = "write `clock-sync: init`, which needs none, or `security: noise` instead of TLS";
        self.found.push(Diagnostic::new(Code::OpenClocks, key.span.to(value.span), message).hint(hint));
    }

    /// Reports a number of workers that is not possible.
    fn workers(&mut self, properties: &[Property]) {
        let given = |name: &str| properties.iter().find(|property| property.key.text == name);
        let says = |name: &str, what: bool| {
            given(name)
                .is_some_and(|it| matches!(it.value.kind, PropertyKind::Literal(Literal::Bool(value)) if value == what))
        };
        let Some(workers) = given("workers").filter(|_| self.target.workers > 1) else { return };
        if self.target.cargo.edition.as_deref() == Some("2018") {
            let message = "`workers` needs closures of edition 2021, which capture fields by themselves";
            let diagnostic = Diagnostic::new(Code::UnsupportedProperty, workers.key.span, message);
            self.found.push(diagnostic.hint("write `edition: \"2021\"` or a later one, or remove `workers`"));
        } else if says("single-threaded", true) || says("threading", false) {
            self.target.workers = 1;
            self.idle(&workers.key, "the program is to have one thread");
        } else if self.target.platform.as_deref() == Some("Zephyr") {
            self.idle(&workers.key, "on boards the event loop runs all reactions");
        }
    }
}

/// Returns the names of all languages, for messages.
fn languages() -> String {
    let names: Vec<String> = Language::names().map(|name| format!("`{name}`")).collect();
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => names.concat(),
    }
}
