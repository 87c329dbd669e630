// SPDX-License-Identifier: Apache-2.0
//! Converts rustc's diagnostics about generated code to diagnostics about the LF program: the same words, at the line
//! of the user's text.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::ops::Range;
use std::path::Path;

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use serde::Deserialize;

use super::hints::RustcError;
use super::scopes::Scope;

/// A diagnostic of rustc, as in its JSON output.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Diagnostic {
    message: String,
    level: String,
    code: Option<Code>,
    spans: Vec<Span>,
    #[serde(default)]
    children: Vec<Diagnostic>,
    /// The whole as rustc would print it.
    rendered: Option<String>,
}

#[derive(Clone, Debug, Deserialize)]
struct Code {
    code: String,
}

/// A range in a file; lines and columns count from 1, columns in characters.
#[derive(Clone, Debug, Deserialize)]
struct Span {
    file_name: String,
    line_start: usize,
    line_end: usize,
    column_start: usize,
    column_end: usize,
    is_primary: bool,
    label: Option<String>,
    suggested_replacement: Option<String>,
    expansion: Option<Box<Expansion>>,
    #[serde(default)]
    text: Vec<SpanLine>,
}

/// A line of a file that a span is in, and the columns that it covers, which count from 1.
#[derive(Clone, Debug, Deserialize)]
struct SpanLine {
    text: String,
    highlight_start: usize,
    highlight_end: usize,
}

impl Span {
    /// Returns the covered text, if that is in one line and a name or a type.
    fn word(&self) -> Option<String> {
        let [line] = &self.text[..] else { return None };
        let length = line.highlight_end.checked_sub(line.highlight_start)?;
        let word: String = line.text.chars().skip(line.highlight_start.checked_sub(1)?).take(length).collect();
        word.starts_with(|first: char| first.is_alphabetic() || first == '_').then_some(word)
    }

    fn resolve(&mut self, folder: &Path) {
        // An absolute name replaces the folder; the names in JSON are UTF-8.
        if let Some(name) = folder.join(&self.file_name).to_str() {
            name.clone_into(&mut self.file_name);
        }
        if let Some(expansion) = &mut self.expansion {
            expansion.span.resolve(folder);
        }
    }
}

/// The place that uses the macro whose text a span lies in.
#[derive(Clone, Debug, Deserialize)]
struct Expansion {
    span: Span,
}

/// A place in an LF file; line and column count from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LfPlace {
    /// The file, by the name that the compiler was given.
    pub(crate) path: String,
    /// The line.
    pub(crate) line: usize,
    /// The column, in characters.
    pub(crate) column: usize,
    /// Whether the LF file contains the text that rustc examined, and not only the declaration that it was generated
    /// for.
    pub(crate) verbatim: bool,
}

/// The parts of the program that diagnostics refer to.
pub(crate) trait Origin {
    /// Returns the place in the LF program for a place in a generated file, which has rustc's name.
    fn place(&self, generated: &str, line: usize, column: usize) -> Option<LfPlace>;
    /// Returns the text of an LF file.
    fn text(&self, path: &str) -> Option<&str>;
    /// Returns the bodies of reactions.
    fn scopes(&self) -> &[Scope];
}

/// A span that has its origin in the LF program, as bytes of its file.
struct Mapped {
    place: LfPlace,
    bytes: Range<usize>,
    is_primary: bool,
    label: Option<String>,
}

impl Diagnostic {
    /// Returns another compiler's diagnostic about a position in a file.
    pub(crate) fn at(level: &str, message: &str, (file, line, column): (&str, usize, usize)) -> Self {
        let span = Span {
            file_name: file.to_owned(),
            line_start: line,
            line_end: line,
            column_start: column,
            column_end: column,
            is_primary: true,
            label: None,
            suggested_replacement: None,
            expansion: None,
            text: Vec::new(),
        };
        let rendered = Some(format!("{file}:{line}:{column}: {level}: {message}\n"));
        let (message, level) = (message.to_owned(), level.to_owned());
        Self { message, level, code: None, spans: vec![span], children: Vec::new(), rendered }
    }

    /// Returns another program's diagnostic about something whose place it does not know.
    pub(crate) fn without_place(level: &str, message: &str) -> Self {
        let rendered = Some(format!("{level}: {message}\n"));
        let (message, level) = (message.to_owned(), level.to_owned());
        Self { message, level, code: None, spans: Vec::new(), children: Vec::new(), rendered }
    }

    /// Adds a note that explains it.
    pub(crate) fn add_note(&mut self, note: Self) {
        self.children.push(note);
    }

    /// Makes the names of files absolute that are relative to the folder in which rustc was run.
    pub(crate) fn resolve(&mut self, folder: &Path) {
        self.spans.iter_mut().for_each(|span| span.resolve(folder));
        self.children.iter_mut().for_each(|child| child.resolve(folder));
    }

    /// Returns the complete text in its compiler's words.
    pub(crate) fn rendered(&self) -> &str {
        self.rendered.as_deref().unwrap_or_default()
    }

    /// Returns whether the program does not compile because of it.
    pub(crate) fn is_error(&self) -> bool {
        self.level.starts_with("error")
    }

    /// Returns whether it names a place.
    pub(crate) fn has_place(&self) -> bool {
        !self.spans.is_empty()
    }

    /// Returns whether it reports that the target lacks this part of the standard library.
    pub(crate) fn misses(&self, name: &str) -> bool {
        let is_code = self.code.as_ref().is_some_and(|code| code.code == "E0463");
        is_code && self.message.contains(&format!("`{name}`"))
    }

    /// Returns whether it only counts other diagnostics.
    fn is_summary(&self) -> bool {
        !self.has_place()
            && (self.message.starts_with("aborting due to")
                || self.message.ends_with("warning emitted")
                || self.message.ends_with("warnings emitted")
                || self.level == "failure-note")
    }

    /// Returns whether the user can act on it: a warning about scaffolding is not the program's.
    fn concerns_user(&self, origin: &dyn Origin) -> bool {
        let in_program = |span: &Span| map(span, origin).is_some_and(|mapped| mapped.place.verbatim);
        !self.is_summary() && (self.is_error() || self.spans.iter().any(|span| span.is_primary && in_program(span)))
    }

    /// Returns whether it is an error at the user's text.
    fn is_at_text(&self, origin: &dyn Origin) -> bool {
        let is_there = |span: &Span| map(span, origin).is_some_and(|mapped| mapped.place.verbatim);
        self.is_error() && self.spans.iter().any(|span| span.is_primary && is_there(span))
    }

    /// Renders the diagnostic about the LF program; about the generated code if that has no origin in the program.
    fn render(&self, origin: &dyn Origin, coloured: bool) -> Rendered {
        let spans: Vec<Mapped> = self.spans.iter().filter_map(|span| map(span, origin)).collect();
        let primary = spans.iter().find(|span| span.is_primary).or(spans.first());
        let rendered = self.rendered.as_deref().unwrap_or(&self.message);
        let Some(primary) = primary else {
            let (is_error, cause, text) = (self.is_error(), rendered.to_owned(), rendered.to_owned());
            return Rendered { place: None, is_error, cause, text };
        };
        let mut text = self.headline(&primary.place, coloured);
        if let Some(excerpt) = self.excerpt(&spans, &primary.place.path, origin, coloured) {
            text.push_str(&excerpt);
            text.push('\n');
        }
        if !primary.place.verbatim {
            // The declaration alone does not show the meaning; rustc's own excerpt does.
            text.push_str("in the code that is generated for this:\n");
            text.push_str(rendered);
        } else if let Some(hint) = self.hint(primary, origin) {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "  hint: {hint}");
        } else {
            for child in self.children.iter().filter(|child| child.says_something(origin)) {
                child.render_as_note(origin, &mut text);
                if child.message.starts_with("consider importing") {
                    text.push_str("  hint: write that into a preamble of the file, or the whole path here\n");
                }
            }
        }
        let (place, is_error) = (Some(primary.place.clone()), self.is_error());
        Rendered { place, is_error, cause: self.message.clone(), text }
    }

    /// Returns the setting of Kconfig without which an image lacks the missing function.
    fn left_out_without(&self) -> Option<&str> {
        let lines = self.children.iter().flat_map(|child| &child.spans).flat_map(|span| &span.text);
        lines.filter(|line| line.text.contains("cfg(")).find_map(|line| {
            let name = &line.text[line.text.find("CONFIG_")?..];
            name.split(|one: char| !one.is_ascii_alphanumeric() && one != '_').next()
        })
    }

    /// Returns advice, if the program shows more than the generated code.
    fn hint(&self, primary: &Mapped, origin: &dyn Origin) -> Option<String> {
        let LfPlace { path, line, .. } = &primary.place;
        let text = origin.text(path)?;
        let start = text[..primary.bytes.start].rfind('\n').map_or(0, |at| at + 1);
        let end = text[start..].find('\n').map_or(text.len(), |length| start + length);
        let said = RustcError {
            code: self.code.as_ref().map_or("", |code| &code.code),
            message: &self.message,
            label: primary.label.as_deref().unwrap_or_default(),
            line: &text[start..end],
            range: primary.bytes.start - start..primary.bytes.end - start,
            left_out_without: self.left_out_without(),
            scope: origin.scopes().iter().find(|scope| scope.has(path, *line)),
        };
        said.hint()
    }

    /// Returns whether a note is meaningful without the code that it is about: it is not if it consists of the name of
    /// a file in a folder of cargo, or "here" is in the runtime.
    fn says_something(&self, origin: &dyn Origin) -> bool {
        let about_files = ["the full name for the type has been written to", "consider using `--verbose`"];
        let is_known = self.spans.iter().any(|span| map(span, origin).is_some_and(|mapped| mapped.place.verbatim));
        // Imports are always suggested, because they go into a preamble.
        let news: Vec<&str> = self.spans.iter().filter_map(|span| span.suggested_replacement.as_deref()).collect();
        let changes_others = !is_known && !news.is_empty() && !news.iter().any(|new| new.starts_with("use "));
        let is_elsewhere = !is_known && self.message.ends_with(" defined here");
        !about_files.iter().any(|start| self.message.starts_with(start)) && !is_elsewhere && !changes_others
    }

    fn headline(&self, place: &LfPlace, coloured: bool) -> String {
        let level = if self.is_error() { "error" } else { "warning" };
        let code = self.code.as_ref().map(|code| format!("[{}]", code.code)).unwrap_or_default();
        let LfPlace { path, line, column, .. } = place;
        let message = &self.message;
        if coloured {
            let colour = if self.is_error() { 31 } else { 33 };
            format!("{path}:{line}:{column}: \x1b[1;{colour}m{level}{code}\x1b[0m: \x1b[1m{message}\x1b[0m\n")
        } else {
            format!("{path}:{line}:{column}: {level}{code}: {message}\n")
        }
    }

    /// Renders the lines of one LF file that the spans are about.
    fn excerpt(&self, spans: &[Mapped], path: &str, origin: &dyn Origin, coloured: bool) -> Option<String> {
        let source = origin.text(path)?;
        let annotations = spans.iter().filter(|span| span.place.path == path).map(|span| {
            let kind = if span.is_primary { AnnotationKind::Primary } else { AnnotationKind::Context };
            kind.span(span.bytes.clone()).label(span.label.as_deref())
        });
        let level = if self.is_error() { Level::ERROR } else { Level::WARNING };
        let group = Group::with_level(level).element(Snippet::source(source).annotations(annotations));
        let renderer = if coloured { Renderer::styled() } else { Renderer::plain() };
        Some(renderer.decor_style(DecorStyle::Ascii).render(&[group]))
    }

    /// Renders notes and suggestions, in rustc's words.
    fn render_as_note(&self, origin: &dyn Origin, text: &mut String) {
        let mut lines = self.message.lines();
        // Writing to a String cannot fail.
        let _ = write!(text, "  {}: {}", self.level, lines.next().unwrap_or_default());
        let replacements = self.replacements(origin);
        if !replacements.is_empty() && replacements.iter().all(|replacement| !replacement.is_empty()) {
            let _ = write!(text, ": `{}`", replacements.join("`, `"));
        }
        text.push('\n');
        for line in lines {
            let _ = writeln!(text, "    {line}");
        }
    }

    /// Returns the replacements of a suggestion. For one that adds or removes something, returns the complete lines,
    /// because a part of an expression is not clear by itself.
    fn replacements(&self, origin: &dyn Origin) -> Vec<String> {
        let all: Vec<(&Span, &str)> =
            self.spans.iter().filter_map(|span| Some((span, span.suggested_replacement.as_deref()?))).collect();
        let is_part = |(span, new): &(&Span, &str)| {
            new.trim().is_empty() || (span.line_start, span.column_start) == (span.line_end, span.column_end)
        };
        let lines = if all.iter().any(is_part) { changed_lines(&all, origin) } else { None };
        lines.unwrap_or_else(|| all.iter().map(|(_, new)| new.trim().to_owned()).collect())
    }
}

/// Returns the lines of the program that a suggestion changes, in their new form; `None` if it also changes other code.
fn changed_lines(changes: &[(&Span, &str)], origin: &dyn Origin) -> Option<Vec<String>> {
    let mut changes = changes
        .iter()
        .map(|(span, new)| Some((map(span, origin).filter(|mapped| mapped.place.verbatim)?, *new)))
        .collect::<Option<Vec<_>>>()?;
    // The changes are applied from the end on, so that the text before each stays in its place.
    changes.sort_by_key(|(mapped, _)| std::cmp::Reverse(mapped.bytes.start));
    let mut lines: Vec<(usize, String)> = Vec::new();
    for (Mapped { place, bytes, .. }, new) in changes {
        let source = origin.text(&place.path)?;
        let start = source[..bytes.start].rfind('\n').map_or(0, |at| at + 1);
        if lines.last().is_none_or(|(last, _)| *last != start) {
            lines.push((start, source[start..].lines().next().unwrap_or_default().to_owned()));
        }
        let (_, line) = lines.last_mut()?;
        line.replace_range(bytes.start - start..bytes.end - start, new);
    }
    Some(lines.into_iter().rev().map(|(_, line)| line.trim().to_owned()).collect())
}

impl std::fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.rendered.as_deref().unwrap_or(&self.message).trim_end())
    }
}

/// A diagnostic about the program.
struct Rendered {
    /// The place; `None` if it is not about the program's text.
    place: Option<LfPlace>,
    is_error: bool,
    /// The common part of diagnostics of one mistake.
    cause: String,
    text: String,
}

impl Rendered {
    fn is_shown_in_the_program(&self) -> bool {
        self.place.as_ref().is_some_and(|place| place.verbatim)
    }
}

/// Diagnostics as text, and their number.
#[derive(Debug, Default)]
pub(crate) struct Shown {
    pub(crate) text: String,
    pub(crate) errors: usize,
    pub(crate) warnings: usize,
}

/// Renders all diagnostics in the order of the program. Those of one cause at one place appear once: a reactor that
/// several federates contain is compiled several times, and the code for one declaration contains a type several times.
/// If the user's code has errors, those in generated code only follow from them; warnings in it are shown only if the
/// program does not show the same.
pub(crate) fn render_all(diagnostics: &[Diagnostic], origin: &dyn Origin, coloured: bool) -> Shown {
    let told = diagnostics.iter().any(|diagnostic| diagnostic.is_at_text(origin));
    let follows = |one: &Diagnostic| told && one.is_error() && !one.is_at_text(origin);
    let concerning = diagnostics.iter().filter(|one| one.concerns_user(origin) && !follows(one));
    let mut all: Vec<Rendered> = concerning.map(|diagnostic| diagnostic.render(origin, coloured)).collect();
    all.sort_by_key(|one| match &one.place {
        Some(place) => (false, !place.verbatim, place.path.clone(), place.line, place.column),
        None => (true, true, String::new(), 0, 0),
    });
    let shown: HashSet<String> =
        all.iter().filter(|one| one.is_shown_in_the_program()).map(|one| one.cause.clone()).collect();
    let mut seen = HashSet::new();
    // A declaration has several places in generated code, and a body its own.
    let place = |place: &LfPlace| (place.path.clone(), place.line, place.verbatim.then_some(place.column));
    let mut shown_all = Shown::default();
    for one in &all {
        let is_told = !one.is_shown_in_the_program() && shown.contains(&one.cause);
        if !is_told && seen.insert((one.cause.as_str(), one.place.as_ref().map(place))) {
            shown_all.text.push_str(&one.text);
            shown_all.text.push('\n');
            *(if one.is_error { &mut shown_all.errors } else { &mut shown_all.warnings }) += 1;
        }
    }
    shown_all
}

/// Returns the span in the LF program; for a span in a macro of another crate, that of the macro's use.
fn map(span: &Span, origin: &dyn Origin) -> Option<Mapped> {
    let Some(place) = origin.place(&span.file_name, span.line_start, span.column_start) else {
        let outer = &span.expansion.as_ref()?.span;
        let mapped = map(outer, origin)?;
        return Some(Mapped { is_primary: span.is_primary, label: span.label.clone(), ..mapped });
    };
    let source = origin.text(&place.path)?;
    let start = byte_of(source, place.line, place.column);
    // An excerpt shows one line; the rest of a longer span is implied.
    let line_end = source[start..].find('\n').map_or(source.len(), |length| start + length);
    if !place.verbatim
        && let Some(word) = span.word()
        && let Some(offset) = find_word(&source[start..line_end], &word)
    {
        // Types and names are generated from the text of the declaration.
        let bytes = start + offset..start + offset + word.len();
        let column = place.column + source[start..bytes.start].chars().count();
        let place = LfPlace { column, verbatim: true, ..place };
        return Some(Mapped { place, bytes, is_primary: span.is_primary, label: span.label.clone() });
    }
    let end = origin
        .place(&span.file_name, span.line_end, span.column_end)
        .filter(|end| place.verbatim && end.path == place.path)
        .map_or(start, |end| byte_of(source, end.line, end.column));
    let bytes = start..end.clamp(start, line_end);
    Some(Mapped { place, bytes, is_primary: span.is_primary, label: span.label.clone() })
}

/// Returns the position of a word that stands by itself in a text.
fn find_word(text: &str, word: &str) -> Option<usize> {
    let is_part = |character: Option<char>| character.is_some_and(|one| one.is_alphanumeric() || one == '_');
    let alone =
        |at: usize| !is_part(text[..at].chars().next_back()) && !is_part(text[at + word.len()..].chars().next());
    text.match_indices(word).map(|(at, _)| at).find(|at| alone(*at))
}

/// Returns the byte at which a place begins; the end of the line or of the text if it lies behind that.
fn byte_of(source: &str, line: usize, column: usize) -> usize {
    let mut start = 0;
    for text in source.split_inclusive('\n').take(line.saturating_sub(1)) {
        start += text.len();
    }
    let text = source[start..].split('\n').next().unwrap_or_default();
    start + text.char_indices().nth(column.saturating_sub(1)).map_or(text.len(), |(offset, _)| offset)
}

#[cfg(test)]
mod tests;
