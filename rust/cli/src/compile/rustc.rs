// SPDX-License-Identifier: Apache-2.0
//! What rustc says about generated code, said about the LF program instead: the same words, at the line where the
//! user wrote what they are about.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::Path;

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use serde::Deserialize;

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
}

impl Span {
    fn resolve(&mut self, folder: &Path) {
        // A name that is absolute already replaces the folder; one that is no UTF-8 text has not come out of JSON.
        if let Some(name) = folder.join(&self.file_name).to_str() {
            name.clone_into(&mut self.file_name);
        }
        if let Some(expansion) = &mut self.expansion {
            expansion.span.resolve(folder);
        }
    }
}

/// Where the macro is used whose text a span lies in.
#[derive(Clone, Debug, Deserialize)]
struct Expansion {
    span: Span,
}

/// A place in an LF file; line and column count from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// The file, as it was named to the compiler.
    pub(crate) path: String,
    /// The line.
    pub(crate) line: usize,
    /// The column, in characters.
    pub(crate) column: usize,
    /// Whether the LF file has there what rustc looked at, and not only the declaration that it was generated for.
    pub(crate) verbatim: bool,
}

/// What has to be known about the program to speak about it.
pub(crate) trait Origin {
    /// The place in the LF program behind a place in a generated file, which is named as rustc names it.
    fn place(&self, generated: &str, line: usize, column: usize) -> Option<Place>;
    /// The text of an LF file.
    fn text(&self, path: &str) -> Option<&str>;
}

/// A span that stems from the LF program, as bytes of its file.
struct Mapped {
    place: Place,
    bytes: std::ops::Range<usize>,
    is_primary: bool,
    label: Option<String>,
}

impl Diagnostic {
    /// Makes the names of files absolute that are relative to the folder in which rustc was run.
    pub(crate) fn resolve(&mut self, folder: &Path) {
        self.spans.iter_mut().for_each(|span| span.resolve(folder));
        self.children.iter_mut().for_each(|child| child.resolve(folder));
    }

    /// Whether the program does not compile because of it.
    pub(crate) fn is_error(&self) -> bool {
        self.level.starts_with("error")
    }

    /// Whether it only counts other diagnostics.
    fn is_summary(&self) -> bool {
        self.spans.is_empty()
            && (self.message.starts_with("aborting due to")
                || self.message.ends_with("warning emitted")
                || self.message.ends_with("warnings emitted")
                || self.level == "failure-note")
    }

    /// Whether the user can do something about it: a warning about scaffolding is not the program's.
    fn concerns_user(&self, origin: &dyn Origin) -> bool {
        let in_program = |span: &Span| map(span, origin).is_some_and(|mapped| mapped.place.verbatim);
        !self.is_summary() && (self.is_error() || self.spans.iter().any(|span| span.is_primary && in_program(span)))
    }

    /// Whether it is an error at something that the user wrote.
    fn is_at_text(&self, origin: &dyn Origin) -> bool {
        let is_there = |span: &Span| map(span, origin).is_some_and(|mapped| mapped.place.verbatim);
        self.is_error() && self.spans.iter().any(|span| span.is_primary && is_there(span))
    }

    /// The diagnostic about the LF program; about the generated code when nothing of the program stands behind it.
    fn render(&self, origin: &dyn Origin, coloured: bool) -> String {
        let spans: Vec<Mapped> = self.spans.iter().filter_map(|span| map(span, origin)).collect();
        let primary = spans.iter().find(|span| span.is_primary).or(spans.first());
        let rendered = self.rendered.as_deref().unwrap_or(&self.message);
        let Some(primary) = primary else { return rendered.to_owned() };
        let mut text = self.headline(&primary.place, coloured);
        if let Some(excerpt) = self.excerpt(&spans, &primary.place.path, origin, coloured) {
            text.push_str(&excerpt);
            text.push('\n');
        }
        if primary.place.verbatim {
            for child in self.children.iter().filter(|child| child.says_something()) {
                child.render_as_note(&mut text);
            }
        } else {
            // The declaration alone does not show what rustc means; its own excerpt does.
            text.push_str("in the code that is generated for this:\n");
            text.push_str(rendered);
        }
        text
    }

    /// Whether a note is about more than a file in a folder of cargo, whose name differs from federate to federate.
    fn says_something(&self) -> bool {
        let about_files = ["the full name for the type has been written to", "consider using `--verbose`"];
        !about_files.iter().any(|start| self.message.starts_with(start))
    }

    fn headline(&self, place: &Place, coloured: bool) -> String {
        let level = if self.is_error() { "error" } else { "warning" };
        let code = self.code.as_ref().map(|code| format!("[{}]", code.code)).unwrap_or_default();
        let Place { path, line, column, .. } = place;
        let message = &self.message;
        if coloured {
            let colour = if self.is_error() { 31 } else { 33 };
            format!("{path}:{line}:{column}: \x1b[1;{colour}m{level}{code}\x1b[0m: \x1b[1m{message}\x1b[0m\n")
        } else {
            format!("{path}:{line}:{column}: {level}{code}: {message}\n")
        }
    }

    /// The lines of one LF file that the spans are about.
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

    /// Notes and suggestions, in rustc's words.
    fn render_as_note(&self, text: &mut String) {
        let replacements: Vec<&str> =
            self.spans.iter().filter_map(|span| span.suggested_replacement.as_deref()).map(str::trim).collect();
        let mut lines = self.message.lines();
        // Writing to a String cannot fail.
        let _ = write!(text, "  {}: {}", self.level, lines.next().unwrap_or_default());
        if !replacements.is_empty() && replacements.iter().all(|replacement| !replacement.is_empty()) {
            let _ = write!(text, ": `{}`", replacements.join("`, `"));
        }
        text.push('\n');
        for line in lines {
            let _ = writeln!(text, "    {line}");
        }
    }
}

/// All diagnostics as text, each once: a reactor that several federates contain is compiled several times. Where there
/// are errors in what the user wrote, those in what was generated from it only follow from them.
pub(crate) fn render_all(diagnostics: &[Diagnostic], origin: &dyn Origin, coloured: bool) -> String {
    let mut seen = HashSet::new();
    let mut text = String::new();
    let told = diagnostics.iter().any(|diagnostic| diagnostic.is_at_text(origin));
    let follows = |one: &Diagnostic| told && one.is_error() && !one.is_at_text(origin);
    for diagnostic in diagnostics.iter().filter(|one| one.concerns_user(origin) && !follows(one)) {
        let rendered = diagnostic.render(origin, coloured);
        if seen.insert(rendered.clone()) {
            text.push_str(&rendered);
            text.push('\n');
        }
    }
    text
}

/// The span in the LF program; a span in a macro of another crate is taken to where the macro is used.
fn map(span: &Span, origin: &dyn Origin) -> Option<Mapped> {
    let Some(place) = origin.place(&span.file_name, span.line_start, span.column_start) else {
        let outer = &span.expansion.as_ref()?.span;
        let mapped = map(outer, origin)?;
        return Some(Mapped { is_primary: span.is_primary, label: span.label.clone(), ..mapped });
    };
    let source = origin.text(&place.path)?;
    let start = byte_of(source, place.line, place.column);
    let end = origin
        .place(&span.file_name, span.line_end, span.column_end)
        .filter(|end| place.verbatim && end.path == place.path)
        .map_or(start, |end| byte_of(source, end.line, end.column));
    // An excerpt shows one line; the rest of a longer span is implied.
    let line_end = source[start..].find('\n').map_or(source.len(), |length| start + length);
    let bytes = start..end.clamp(start, line_end);
    Some(Mapped { place, bytes, is_primary: span.is_primary, label: span.label.clone() })
}

/// The byte at which a place begins; the end of the line or of the text when it lies behind that.
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
