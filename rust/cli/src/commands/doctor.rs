// SPDX-License-Identifier: Apache-2.0
//! `lfz doctor`

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

use lf_compiler::plan::Plan;
use lf_compiler::syntax::ast::{ReactorKind, SourceUnit};
use lf_compiler::{Code, Diagnostic, Diagnostics, Severity};
use walkdir::{DirEntry, WalkDir};

use crate::args::DoctorArgs;
use crate::compile::{compile, read_text};
use crate::failure::Failure;
use crate::terminal;

/// Folders that builds fill, in which no program of the user is.
const BUILT: [&str; 7] = ["build", "target", "src-gen", "fed-gen", "bin", "include", "node_modules"];

/// The number of places that are listed for one reason.
const PLACES: usize = 3;

/// The names of this compiler's targets, in lower case.
const TARGETS: [&str; 4] = ["c", "ccpp", "uc", "rust"];

/// Programs that builds use, each with its argument for the version and its use.
const TOOLS: [(&str, &str, &str); 6] = [
    ("cargo", "--version", "every program"),
    ("cc", "--version", "bodies in C"),
    ("c++", "--version", "bodies in C++"),
    ("cmake", "--version", "`cmake-include`, and images"),
    ("west", "--version", "images"),
    ("gdb", "--version", "`lfz debug`"),
];

/// Prints which programs in a folder work, which of their parts have no effect, and what has to be changed.
pub(super) fn doctor(arguments: &DoctorArgs) -> Result<ExitCode, Failure> {
    let mut seen = Seen::default();
    for folder in &arguments.folders {
        if !folder.exists() {
            return Err(Failure::message(format!("{} does not exist", folder.display())));
        }
        let walk = WalkDir::new(folder).follow_links(true).sort_by_file_name().into_iter();
        for entry in walk.filter_entry(|entry| entry.depth() == 0 || is_source(entry)) {
            match entry {
                Ok(entry) if entry.file_type().is_file() && is_lf(entry.path()) => seen.look_at(entry.path())?,
                Ok(_) => {}
                Err(error) => seen.unreadable.push(error.to_string()),
            }
        }
    }
    let is_well = seen.refused.is_empty() && seen.unreadable.is_empty();
    terminal::print(seen.report(&arguments.folders.iter().map(|it| it.display().to_string()).collect::<Vec<_>>()))?;
    Ok(if is_well { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn is_source(entry: &DirEntry) -> bool {
    let name = entry.file_name().to_string_lossy();
    let is_built = entry.file_type().is_dir() && BUILT.contains(&&*name);
    !is_built && !name.starts_with('.')
}

fn is_lf(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "lf" || extension == "ulf")
}

/// The programs of a folder, sorted.
#[derive(Default)]
struct Seen {
    /// The number of those that work, and of those among them with warnings.
    working: usize,
    warned: usize,
    /// Those that do not.
    refused: Vec<String>,
    /// The number of files without a main reactor.
    parts: usize,
    /// Programs in other languages, by the target.
    others: BTreeMap<String, usize>,
    /// The reasons for errors and warnings, each with its places.
    errors: Reasons,
    warnings: Reasons,
    /// Programs with files for CMake.
    with_cmake: Vec<String>,
    unreadable: Vec<String>,
}

/// Places by message and hint.
type Reasons = BTreeMap<(String, Option<String>), Vec<String>>;

impl Seen {
    fn look_at(&mut self, path: &Path) -> Result<(), Failure> {
        let name = path.strip_prefix(".").unwrap_or(path).display().to_string();
        let text = match read_text(path) {
            Ok(text) => text,
            Err(reason) => {
                self.unreadable.push(format!("{name}: {reason}"));
                return Ok(());
            }
        };
        let unit = lf_compiler::parse(&name, &text).unit;
        if !unit.reactors.iter().any(|reactor| reactor.kind != ReactorKind::Plain) {
            self.parts += 1;
            return Ok(());
        }
        if let Some(target) = foreign_target(&unit) {
            *self.others.entry(target).or_default() += 1;
            return Ok(());
        }
        let compilation = compile(Path::new(&name))?;
        self.sort_in(&compilation.diagnostics);
        match compilation.plan {
            Some(plan) => self.works(name, &plan, compilation.diagnostics.counts().1),
            None => self.refused.push(name),
        }
        Ok(())
    }

    fn works(&mut self, name: String, plan: &Plan, warnings: usize) {
        self.working += 1;
        self.warned += usize::from(warnings > 0);
        if !plan.target.c.cmake.is_empty() {
            self.with_cmake.push(name);
        }
    }

    fn sort_in(&mut self, diagnostics: &Diagnostics) {
        for Diagnostic { code, span, message, hint, .. } in diagnostics.iter() {
            let place = diagnostics.sources().get(span.file).map_or_else(String::new, |file| {
                let start = file.position(span.start);
                format!("{}:{}:{}", file.path(), start.line, start.column)
            });
            let reasons = match code.severity() {
                Severity::Error => &mut self.errors,
                Severity::Warning => &mut self.warnings,
            };
            // Messages of some kinds name something else each time.
            let key = match code {
                Code::MissingFile => ("files that are not there".to_owned(), hint.clone()),
                Code::NoEffect | Code::IdleProperty | Code::OlderForm => (message.clone(), hint.clone()),
                _ if code.severity() == Severity::Warning => (without_names(message), hint.clone()),
                _ => (message.clone(), hint.clone()),
            };
            let text = if *code == Code::MissingFile { format!("{place}: {message}") } else { place };
            let places = reasons.entry(key).or_default();
            if !places.contains(&text) {
                places.push(text);
            }
        }
    }

    fn report(&self, folders: &[String]) -> String {
        let all = self.working + self.refused.len();
        let mut text = format!("Programs of Lingua Franca in {}: {all}\n\n", folders.join(", "));
        let mut row = |count: usize, what: &str| {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{count:6}  {what}");
        };
        row(self.working - self.warned, "work");
        row(self.warned, "work, and have parts without an effect here");
        row(self.refused.len(), "need a change");
        for (target, count) in &self.others {
            row(*count, &format!("of target {target}, which another compiler compiles"));
        }
        row(self.parts, "further files, with reactors for these programs");
        text += &section("What to change", &self.errors);
        text += &listed("Programs that need a change", &self.refused);
        text += &section("What has no effect", &self.warnings);
        text += &listed("What only a build can tell: these programs have files for CMake", &self.with_cmake);
        text += &listed("What cannot be read", &self.unreadable);
        text += "\nThis computer\n";
        for (tool, argument, purpose) in TOOLS {
            let _ = writeln!(text, "  {tool:6} {:24} {purpose}", version(tool, argument));
        }
        text.trim_end().to_owned()
    }
}

/// Returns a message without what it quotes.
fn without_names(message: &str) -> String {
    let parts = message.split('`').enumerate().map(|(at, part)| if at % 2 == 0 { part } else { "`…`" });
    parts.collect()
}

/// Returns the target of a program that this compiler does not compile.
fn foreign_target(unit: &SourceUnit) -> Option<String> {
    let target = &unit.target.as_ref()?.name.text;
    (!TARGETS.contains(&target.to_lowercase().as_str())).then(|| target.clone())
}

/// Returns the reasons, the most frequent one first.
fn section(title: &str, reasons: &Reasons) -> String {
    let mut reasons: Vec<_> = reasons.iter().collect();
    if reasons.is_empty() {
        return String::new();
    }
    reasons.sort_by_key(|(_, places)| std::cmp::Reverse(places.len()));
    let mut text = format!("\n{title}\n");
    for ((message, hint), places) in reasons {
        let _ = writeln!(text, "  {} ×  {message}", places.len());
        if let Some(hint) = hint {
            let _ = writeln!(text, "       {hint}");
        }
        for place in places.iter().take(PLACES) {
            let _ = writeln!(text, "       {place}");
        }
        if places.len() > PLACES {
            let _ = writeln!(text, "       and {} more", places.len() - PLACES);
        }
    }
    text
}

fn listed(title: &str, names: &[String]) -> String {
    if names.is_empty() {
        return String::new();
    }
    format!("\n{title}\n  {}\n", names.join("\n  "))
}

/// Returns what a program says about its version, in one line.
fn version(tool: &str, argument: &str) -> String {
    let output = Command::new(tool).arg(argument).stdin(Stdio::null()).stderr(Stdio::null()).output();
    let Ok(output) = output else { return "is missing".to_owned() };
    let text = String::from_utf8_lossy(&output.stdout);
    let words = text.lines().next().unwrap_or_default().split_whitespace();
    let mut numbers = words.filter(|word| word.starts_with(|c: char| c.is_ascii_digit() || c == 'v'));
    let number = numbers.next_back();
    number.unwrap_or("is there").trim_start_matches('v').to_owned()
}
