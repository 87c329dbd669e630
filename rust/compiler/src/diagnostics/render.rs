// SPDX-License-Identifier: Apache-2.0
//! Renders diagnostics as text: `FILE.lf:LINE:COLUMN: error[CODE]: sentence`, the lines concerned, and a hint.

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{Annotation, AnnotationKind, Group, Level, Renderer, Snippet};

use super::{Diagnostic, Diagnostics, Label, Severity, SourceText, SourceTexts, Span};

/// Whether to use colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Style {
    /// Plain text, for files and pipes.
    #[default]
    Plain,
    /// With terminal colours.
    Coloured,
}

/// The maximum number of printed entries. A user does not read more at once, and most follow from the first ones.
const PRINTED_MAX: usize = 100;

/// The maximum number of bytes of a line that are shown before and behind the underlined code.
const LINE_MAX: usize = 500;

/// The maximum distance in bytes of two places that are shown as parts of one text.
const GAP_MAX: usize = 20_000;

impl Diagnostics {
    /// Returns the first entries as text, each with its place, the line of the program and its hint, and the number of
    /// further ones. If there is no room for all, errors take precedence over warnings; the printed entries are in the
    /// order of the text.
    pub fn render(&self, style: Style) -> String {
        let (errors, warnings) = self.counts();
        let shown_errors = errors.min(PRINTED_MAX);
        let mut room = [shown_errors, warnings.min(PRINTED_MAX - shown_errors)];
        let left_out = [errors - room[0], warnings - room[1]];
        let mut text = String::new();
        for entry in self.iter() {
            let room = &mut room[usize::from(entry.severity() == Severity::Warning)];
            if *room > 0 {
                *room -= 1;
                text.push_str(&render(entry, self.sources(), style));
                text.push('\n');
            }
        }
        let words = left_out.into_iter().zip(["error", "warning"]).filter(|(number, _)| *number > 0);
        let words = words.map(|(number, word)| format!("{number} more {word}{}", if number == 1 { "" } else { "s" }));
        let words: Vec<_> = words.collect();
        if !words.is_empty() {
            text = text + "and " + &words.join(" and ") + ", which may follow from these\n\n";
        }
        text
    }
}

/// Renders one diagnostic, ending in a new line.
fn render(diagnostic: &Diagnostic, sources: &SourceTexts, style: Style) -> String {
    let (word, colour) = match diagnostic.severity() {
        Severity::Error => ("error", "\x1b[1;31m"),
        Severity::Warning => ("warning", "\x1b[1;33m"),
    };
    let place = place(diagnostic.span, sources);
    let code = diagnostic.code.text();
    let message = &diagnostic.message;
    let mut text = match style {
        Style::Plain => format!("{place}: {word}[{code}]: {message}\n"),
        Style::Coloured => format!("{place}: {colour}{word}[{code}]\x1b[0m: \x1b[1m{message}\x1b[0m\n"),
    };
    if let Some(excerpt) = excerpt(diagnostic, sources, style) {
        text.push_str(&excerpt);
        text.push('\n');
    }
    if let Some(hint) = &diagnostic.hint {
        text.push_str("  hint: ");
        text.push_str(hint);
        text.push('\n');
    }
    text
}

fn place(span: Span, sources: &SourceTexts) -> String {
    sources.get(span.file).map_or_else(String::new, |file| {
        let position = file.position(span.start);
        format!("{}:{}:{}", file.path(), position.line, position.column)
    })
}

/// Renders the lines of the program that the diagnostic is about, with the underlined code in them.
fn excerpt(diagnostic: &Diagnostic, sources: &SourceTexts, style: Style) -> Option<String> {
    let file = sources.get(diagnostic.span.file)?;
    if file.is_blank() {
        return None;
    }
    let (here, elsewhere): (Vec<_>, Vec<_>) =
        diagnostic.secondary.iter().partition(|label| is_near(label.span, diagnostic.span));
    let main = Window::new(file, here.iter().map(|label| label.span).chain([diagnostic.span]));
    let primary = AnnotationKind::Primary
        .span(main.underlined(diagnostic.span))
        .label((!diagnostic.label.is_empty()).then_some(diagnostic.label.as_str()));
    let others = here.into_iter().map(|label| main.context(label));
    let snippet = Snippet::source(main.text).line_start(main.line).annotation(primary).annotations(others);
    let level = match diagnostic.severity() {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let mut group = Group::with_level(level).element(snippet);
    for label in elsewhere {
        let Some(other) = sources.get(label.span.file) else { continue };
        let window = Window::new(other, [label.span]);
        let snippet = Snippet::source(window.text).line_start(window.line).path(other.path());
        group = group.element(snippet.annotation(window.context(label)));
    }
    let renderer = match style {
        Style::Plain => Renderer::plain(),
        Style::Coloured => Renderer::styled(),
    };
    Some(renderer.decor_style(DecorStyle::Ascii).render(&[group]))
}

/// Returns whether two places are shown as parts of one text, without the code between them.
fn is_near(one: Span, other: Span) -> bool {
    one.file == other.file && one.start.abs_diff(other.start) <= GAP_MAX
}

/// The lines of a file that some spans touch; the renderer skips the rest of a long file, or of a long line.
struct Window<'s> {
    text: &'s str,
    /// The first byte of the window in the file.
    start: usize,
    /// The number of its first line.
    line: usize,
}

impl<'s> Window<'s> {
    fn new(file: &'s SourceText, spans: impl IntoIterator<Item = Span>) -> Self {
        let text = file.text();
        let (mut first, mut last) = (text.len(), 0);
        for span in spans {
            first = first.min(span.start);
            last = last.max(span.start);
        }
        let first = floor(text, first);
        let last = floor(text, last).max(first);
        let (earliest, latest) = (floor(text, first.saturating_sub(LINE_MAX)), floor(text, last + LINE_MAX));
        let start = text[earliest..first].rfind('\n').map_or(earliest, |at| earliest + at + 1);
        let end = text[last..latest].find('\n').map_or(latest, |length| last + length);
        Self { text: &text[start..end], start, line: file.position(start).line }
    }

    /// Returns a span within the window, on character boundaries and within one line, so that a missing end of a block
    /// does not print the whole file.
    fn underlined(&self, span: Span) -> std::ops::Range<usize> {
        let start = floor(self.text, span.start.saturating_sub(self.start));
        let end = floor(self.text, span.end.saturating_sub(self.start)).max(start);
        let line_end = self.text[start..end].find(['\n', '\r']).map_or(end, |length| start + length);
        start..line_end
    }

    fn context<'l>(&self, label: &'l Label) -> Annotation<'l> {
        AnnotationKind::Context.span(self.underlined(label.span)).label(label.text.as_str())
    }
}

/// Returns the last character boundary that is not after a byte.
fn floor(text: &str, at: usize) -> usize {
    (0..=at.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0)
}
