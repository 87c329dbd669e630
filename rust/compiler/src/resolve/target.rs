// SPDX-License-Identifier: Apache-2.0
//! The target declaration: the language, and each property honoured or refused by name.

use lf_model::units::UNITS;

use super::load::Program;
use super::properties::{REFUSED, honoured, language_of};
use super::sources::SourceProvider;
use crate::diagnostics::{Code, Diagnostic, Diagnostics, FileId, SourceTexts, Span, did_you_mean};
use crate::lexical::{Language, is_cpp};
use crate::plan;
use crate::syntax::ast::{Literal, Name, Property, PropertyKind, PropertyValue, TargetSyntax, TimeValue};
use crate::syntax::{TimeError, nanoseconds};

/// Checks the target of the main file and gives the properties that have an effect.
///
/// Properties of imported files have no effect, as in LF: they belong to the programs in those files. What is about
/// bodies of another language than that of the main file has.
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
                reader.unique(&target.properties);
                for property in &target.properties {
                    reader.property(property);
                }
                if language == Language::Rust {
                    reader.features(&target.properties);
                }
                reader.idle_options(&target.properties);
                reader.workers(&target.properties);
            }
        },
    }
    for target in imported.iter().filter_map(|unit| unit.ast.target.as_ref()) {
        match Language::named(&target.name.text) {
            Some(language) => reader.imported(target, language),
            None => reader.wrong_target(target),
        }
    }
    reader.find_sources();
    let TargetReader { target, found, .. } = reader;
    diagnostics.extend(found);
    target
}

/// The most threads that a program can have.
const WORKERS_MAX: u64 = 1024;

/// What can be in `clock-sync-options`.
const CLOCK_SYNC_OPTIONS: [&str; 6] =
    ["trials", "period", "attenuation", "local-federates-on", "test-offset", "collect-stats"];

/// Reads the target declaration of the main file.
pub(super) struct TargetReader<'p> {
    pub(super) target: plan::Target,
    pub(super) found: Vec<Diagnostic>,
    pub(super) sources: &'p dyn SourceProvider,
    pub(super) texts: &'p SourceTexts,
}

impl TargetReader<'_> {
    fn wrong_target(&mut self, target: &TargetSyntax) {
        let language = self.target.language;
        let message = format!("the target is `{}`, and only {} is compiled here", target.name.text, languages());
        let meant = did_you_mean(&target.name.text, Language::names());
        let hint = meant.unwrap_or_else(|| format!("write `target {language}`, and the reaction bodies in {language}"));
        self.found.push(Diagnostic::new(Code::WrongTarget, target.name.span, message).hint(hint));
    }

    pub(super) fn unique(&mut self, properties: &[Property]) {
        for (index, property) in properties.iter().enumerate() {
            let first = properties[..index].iter().find(|first| first.key.text == property.key.text);
            if let Some(first) = first {
                let message = format!("`{}` is given twice", property.key.text);
                let diagnostic = Diagnostic::new(Code::DuplicateProperty, property.key.span, message);
                self.found.push(diagnostic.also(first.key.span, "the first one").hint("remove one of them"));
            }
        }
    }

    fn property(&mut self, property: &Property) {
        let Property { key, value } = property;
        let other = language_of(&key.text, self.target.language);
        match key.text.as_str() {
            name if other.is_some() => self.of_other_language(name, key, other.unwrap_or_default()),
            "coordination" => {
                if self.word(key, value, &["centralized", "decentralized"]) == Some("decentralized") {
                    self.target.coordination = plan::Coordination::Decentralized;
                }
            }
            "clock-sync" => match self.word(key, value, &["off", "init", "on"]) {
                Some("off") => self.target.clock_sync = plan::ClockSync::Off,
                Some("init") => self.target.clock_sync = plan::ClockSync::Init,
                Some("on") => self.target.clock_sync = plan::ClockSync::On,
                _ => {}
            },
            "clock-sync-options" => self.clock_sync_options(key, value),
            "coordination-options" => self.coordination_options(key, value),
            "DNET" => self.target.dnet = self.boolean(key, value).unwrap_or(true),
            "platform" => self.platform(key, value),
            "cargo-dependencies" => self.dependencies(key, value),
            // Dependencies may come behind them.
            "cargo-features" => {}
            "rust-include" => self.modules(key, value),
            "build-type" => self.build_type(key, value),
            "edition" => self.edition(key, value),
            "c-sources" | "c-headers" | "c-include-directories" => self.beside(key, value),
            "files" => self.files(key, value),
            "cmake-include" => self.cmake_include(key, value),
            "compile-definitions" => self.definitions(key, value),
            "compiler" => self.target.c.compiler = self.text(key, value, "the name of a compiler in quotes"),
            "compiler-flags" => self.flags(key, value),
            "no-source-mapping" => self.target.c.no_lines = self.boolean(key, value).unwrap_or_default(),
            "scheduler" => self.scheduler(key, value),
            "tracing" => self.idle(key, "`lfz run --trace FOLDER` records what happens"),
            // Nobody looks for what other compilers write beside the program; `workers` asks for the first two.
            "threading" | "single-threaded" | "single-file-project" | "export-dependency-graph" => {
                self.boolean(key, value);
            }
            "workers" => {
                // As many as the runtime likes, which is what 0 stands for, are one.
                if let Some(workers) = self.number(key, value, WORKERS_MAX) {
                    self.target.workers = u16::try_from(workers.max(1)).unwrap_or(u16::MAX);
                }
            }
            "timeout" => self.target.timeout_ns = self.time(key, value),
            "fast" => self.target.fast = self.boolean(key, value).unwrap_or_default(),
            "keepalive" => {
                let given = self.boolean(key, value);
                self.target.keepalive = given.unwrap_or_default();
                if self.target.language.facts().unknown_threads {
                    self.target.c.keepalive = given;
                }
            }
            "logging" => self.logging(key, value),
            "no-compile" => self.must_be_false(key, value, "remove it; `lfz check` and `lfz plan` compile nothing"),
            "auth" => self.target.authentication = self.boolean(key, value).unwrap_or_default(),
            "joint-rti" => self.target.joint_rti = self.boolean(key, value).unwrap_or_default(),
            "joint-rti-options" => self.joint_rti_options(key, value),
            name => self.other(name, key),
        }
    }

    /// A property of programs in another language.
    fn of_other_language(&mut self, name: &str, key: &Name, language: Language) {
        if REFUSED.iter().any(|(refused, _)| *refused == name) {
            return self.other(name, key);
        }
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

    fn other(&mut self, name: &str, key: &Name) {
        if let Some((_, hint)) = REFUSED.iter().find(|(refused, _)| *refused == name) {
            let message = format!("the target property `{name}` is not supported yet");
            self.found.push(Diagnostic::new(Code::UnsupportedProperty, key.span, message).hint(*hint));
            return;
        }
        self.unknown(key, honoured(self.target.language).chain(REFUSED.iter().map(|(name, _)| *name)));
    }

    pub(super) fn unknown<'a>(&mut self, key: &Name, known: impl Iterator<Item = &'a str> + Clone) {
        let message = format!("there is no property `{}` here", key.text);
        let hint = did_you_mean(&key.text, known.clone()).unwrap_or_else(|| {
            let count = honoured(self.target.language).count();
            let names: Vec<_> = known.take(count).map(|name| format!("`{name}`")).collect();
            format!("properties are {}", names.join(", "))
        });
        self.found.push(Diagnostic::new(Code::UnknownProperty, key.span, message).hint(hint));
    }

    fn logging(&mut self, key: &Name, value: &PropertyValue) {
        use plan::Logging::{Debug, Error, Info, Log, Warn};
        let levels =
            [("error", Error), ("warn", Warn), ("warning", Warn), ("info", Info), ("log", Log), ("debug", Debug)];
        let text = text_of(value).map(|text| text.to_lowercase());
        match levels.iter().find(|(name, _)| text.as_deref() == Some(*name)) {
            Some((_, level)) => self.target.logging = *level,
            None => self.bad(key, value, "one of error, warn, info, log and debug"),
        }
    }

    fn platform(&mut self, key: &Name, value: &PropertyValue) {
        let PropertyKind::Map(properties) = &value.kind else {
            self.platform_name(key, value);
            return;
        };
        self.unique(properties);
        for Property { key, value } in properties {
            match key.text.as_str() {
                "name" => self.platform_name(key, value),
                "board" => match text_of(value) {
                    Some(text) => self.target.board = Some(text),
                    None => self.bad(key, value, "the name of a board"),
                },
                "user-threads" => {
                    if let Some(threads) = self.number(key, value, 64) {
                        self.target.user_threads = u16::try_from(threads).unwrap_or(u16::MAX);
                    }
                }
                "port" | "baud-rate" | "flash" => {
                    self.refuse_value(key, value, "remove it, and pass options for flashing to west");
                }
                _ => self.unknown(key, ["name", "board", "user-threads"].into_iter()),
            }
        }
    }

    fn platform_name(&mut self, key: &Name, value: &PropertyValue) {
        const SUPPORTED: [&str; 3] = ["Zephyr", "Native", "Linux"];
        const OTHERS: [&str; 10] =
            ["Arduino", "nRF52", "RP2040", "Pico", "FlexPRET", "Patmos", "FreeRTOS", "Mac", "Windows", "Auto"];
        let Some(text) = text_of(value) else { return self.bad(key, value, "the name of a platform") };
        let same = |name: &&&str| name.eq_ignore_ascii_case(&text);
        if let Some(name) = SUPPORTED.iter().find(same) {
            self.target.platform = Some((*name).to_owned());
        } else if OTHERS.iter().any(|name| same(&name)) {
            self.refuse_value(key, value, "use `Zephyr`, `Linux` or `Native`");
        } else {
            let message = format!("there is no platform `{text}`");
            // Names of boards have digits, hyphens and slashes, of which platforms have none.
            let is_board = text.contains(|one: char| !one.is_ascii_alphabetic());
            let hint = match did_you_mean(&text, SUPPORTED) {
                Some(hint) => hint,
                None if is_board => format!("a board is named so: `platform: {{ name: Zephyr, board: \"{text}\" }}`"),
                None => "platforms are `Zephyr`, `Linux` and `Native`; a board is named so: \
                         `platform: { name: Zephyr, board: \"qemu_cortex_m3\" }`"
                    .to_owned(),
            };
            self.found.push(Diagnostic::new(Code::BadPropertyValue, value.span, message).hint(hint));
        }
    }

    fn clock_sync_options(&mut self, key: &Name, value: &PropertyValue) {
        let PropertyKind::Map(properties) = &value.kind else {
            return self.bad(key, value, "a list of options in braces");
        };
        self.unique(properties);
        for Property { key, value } in properties {
            match key.text.as_str() {
                "trials" => {
                    self.target.clock_sync_trials = self.count(key, value).unwrap_or(self.target.clock_sync_trials);
                }
                "attenuation" => {
                    let attenuation = self.count(key, value);
                    self.target.clock_sync_attenuation = attenuation.unwrap_or(self.target.clock_sync_attenuation);
                }
                "period" => self.clock_sync_period(key, value),
                "local-federates-on" => self.target.clock_sync_local = self.boolean(key, value).unwrap_or_default(),
                "test-offset" => {
                    if matches!(value.kind, PropertyKind::Time(TimeValue::Forever)) {
                        self.bad(key, value, "a time by which the clocks are wrong");
                    } else {
                        self.target.clock_sync_test_offset_ns = self.time(key, value).unwrap_or(0);
                    }
                }
                "collect-stats" => {
                    if self.boolean(key, value) == Some(false) {
                        self.idle(key, "what is collected costs next to nothing, and is told at the end in any case");
                    }
                }
                _ => self.unknown(key, CLOCK_SYNC_OPTIONS.into_iter()),
            }
        }
    }

    /// A number from 1 on, where there is one.
    fn count(&mut self, key: &Name, value: &PropertyValue) -> Option<u16> {
        let count = self.number(key, value, u64::from(u16::MAX)).and_then(|count| u16::try_from(count).ok());
        if count == Some(0) {
            self.bad(key, value, "a number from 1 to 65535");
        }
        count.filter(|count| *count > 0)
    }

    fn clock_sync_period(&mut self, key: &Name, value: &PropertyValue) {
        const LEAST_NS: i64 = 1_000_000;
        const MOST_NS: i64 = 3_600_000_000_000;
        let forever = matches!(value.kind, PropertyKind::Time(TimeValue::Forever));
        match self.time(key, value) {
            Some(ns) if (LEAST_NS..=MOST_NS).contains(&ns) => self.target.clock_sync_period_ns = ns,
            None if !forever => {}
            _ => self.bad(key, value, "a time from 1 ms to 1 h"),
        }
    }

    fn coordination_options(&mut self, key: &Name, value: &PropertyValue) {
        let PropertyKind::Map(properties) = &value.kind else {
            return self.bad(key, value, "a list of options in braces");
        };
        self.unique(properties);
        for Property { key, value } in properties {
            if key.text == "log-waits" {
                match self.time(key, value) {
                    Some(ns) if ns > 0 => self.target.log_waits_ns = Some(ns),
                    Some(_) => self.bad(key, value, "a time longer than 0"),
                    None => {}
                }
            } else if key.text != "advance-message-interval" {
                self.unknown(key, ["advance-message-interval", "log-waits"].into_iter());
            } else if matches!(value.kind, PropertyKind::Time(TimeValue::Forever)) {
                self.bad(key, value, "a time after which progress is told again");
            } else {
                match self.time(key, value) {
                    Some(0) => self.bad(key, value, "a time longer than 0"),
                    Some(ns) => self.target.advance_interval_ns = ns,
                    None => {}
                }
            }
        }
    }

    fn joint_rti_options(&mut self, key: &Name, value: &PropertyValue) {
        /// In bytes; the wire has no room for a longer one.
        const FEDERATION_ID_MAX: usize = 255;
        let PropertyKind::Map(properties) = &value.kind else {
            return self.bad(key, value, "a list of options in braces");
        };
        self.unique(properties);
        for Property { key, value } in properties {
            match key.text.as_str() {
                "port" => self.target.rti_port = self.count(key, value),
                "federation-id" => match text_of(value) {
                    Some(id) if (1..=FEDERATION_ID_MAX).contains(&id.len()) => self.target.federation_id = Some(id),
                    _ => self.bad(key, value, "a text of up to 255 bytes"),
                },
                _ => self.unknown(key, ["federation-id", "port"].into_iter()),
            }
        }
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

    /// Whether the workers that were asked for can be had.
    fn workers(&mut self, properties: &[Property]) {
        let given = |name: &str| properties.iter().find(|property| property.key.text == name);
        let says = |name: &str, what: bool| {
            given(name)
                .is_some_and(|it| matches!(it.value.kind, PropertyKind::Literal(Literal::Bool(value)) if value == what))
        };
        let Some(workers) = given("workers").filter(|_| self.target.workers > 1) else { return };
        if !self.target.language.facts().workers {
            self.target.workers = 1;
            let reason = format!("one thread runs all reactions of programs in {}", self.target.language);
            return self.idle(&workers.key, &reason);
        }
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

    pub(super) fn idle(&mut self, key: &Name, reason: &str) {
        let message = format!("`{}` has no effect: {reason}", key.text);
        self.found.push(Diagnostic::new(Code::IdleProperty, key.span, message).hint("remove it"));
    }

    fn refuse_value(&mut self, key: &Name, value: &PropertyValue, hint: &str) {
        let written = text_of(value).map_or_else(String::new, |text| format!(": {text}"));
        let message = format!("`{}{written}` is not supported yet", key.text);
        self.found.push(Diagnostic::new(Code::UnsupportedProperty, key.span.to(value.span), message).hint(hint));
    }

    fn must_be_false(&mut self, key: &Name, value: &PropertyValue, hint: &str) {
        if self.boolean(key, value) == Some(true) {
            self.refuse_value(key, value, hint);
        }
    }

    pub(super) fn bad(&mut self, key: &Name, value: &PropertyValue, expected: &str) {
        let message = format!("`{}` takes {expected}", key.text);
        self.found.push(Diagnostic::new(Code::BadPropertyValue, value.span, message));
    }

    pub(super) fn word(&mut self, key: &Name, value: &PropertyValue, words: &[&'static str]) -> Option<&'static str> {
        let text = text_of(value);
        let found = words.iter().find(|word| text.as_deref() == Some(**word)).copied();
        if found.is_none() {
            let quoted: Vec<_> = words.iter().map(|word| format!("`{word}`")).collect();
            self.bad(key, value, &format!("one of {}", quoted.join(", ")));
        }
        found
    }

    pub(super) fn boolean(&mut self, key: &Name, value: &PropertyValue) -> Option<bool> {
        let boolean = match &value.kind {
            PropertyKind::Literal(Literal::Bool(value)) => Some(*value),
            _ => None,
        };
        if boolean.is_none() {
            self.bad(key, value, "`true` or `false`");
        }
        boolean
    }

    fn number(&mut self, key: &Name, value: &PropertyValue, max: u64) -> Option<u64> {
        let number = match &value.kind {
            PropertyKind::Literal(Literal::Int(digits)) => digits.parse().ok().filter(|number| *number <= max),
            _ => None,
        };
        if number.is_none() {
            let limit = if max == u64::MAX { String::new() } else { format!(" up to {max}") };
            self.bad(key, value, &format!("a whole number{limit}"));
        }
        number
    }

    /// Nanoseconds; nothing for `forever`.
    fn time(&mut self, key: &Name, value: &PropertyValue) -> Option<i64> {
        let (code, message, span, hint) = match &value.kind {
            PropertyKind::Time(TimeValue::Forever) => return None,
            PropertyKind::Time(TimeValue::Interval { negative, digits, unit }) => {
                match nanoseconds(digits, &unit.text) {
                    Ok(ns) if !negative || ns == 0 => return Some(ns),
                    Ok(_) => (Code::NegativeTime, "is negative", value.span, "write a time from 0 on".to_owned()),
                    // What the parser takes for a time has digits.
                    Err(TimeError::TooLarge(..) | TimeError::NotANumber(_)) => {
                        let hint = "write `forever` for a time that never comes".to_owned();
                        (Code::NumberTooLarge, "is longer than 292 years", value.span, hint)
                    }
                    Err(TimeError::UnknownUnit(_)) => {
                        let units = UNITS.iter().flat_map(|(names, _)| names.iter().copied());
                        let hint = did_you_mean(&unit.text, units)
                            .unwrap_or_else(|| "units of time are ns, us, ms, s, min, h, d and wk".to_owned());
                        (Code::BadUnit, "has a unit of time that does not exist", unit.span, hint)
                    }
                }
            }
            PropertyKind::Literal(Literal::Int(digits)) => {
                if digits.bytes().all(|byte| byte == b'0') {
                    return Some(0);
                }
                (Code::MissingUnit, "needs a unit of time", value.span, format!("write `{digits} ms`"))
            }
            _ => (Code::NotATime, "is not a time", value.span, "write a number with a unit, like `10 s`".to_owned()),
        };
        let message = format!("`{}` {message}", key.text);
        self.found.push(Diagnostic::new(code, span, message).hint(hint));
        None
    }
}

/// A word, a path or a string, without quotes.
pub(super) fn text_of(value: &PropertyValue) -> Option<String> {
    match &value.kind {
        PropertyKind::Literal(Literal::Text(text)) => Some(text.trim_matches('"').to_owned()),
        PropertyKind::Path(text) | PropertyKind::Literal(Literal::Int(text)) => Some(text.clone()),
        PropertyKind::Literal(Literal::Bool(value)) => Some(value.to_string()),
        _ => None,
    }
}

/// Returns the names of all languages, for people.
fn languages() -> String {
    let names: Vec<String> = Language::names().map(|name| format!("`{name}`")).collect();
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => names.concat(),
    }
}
