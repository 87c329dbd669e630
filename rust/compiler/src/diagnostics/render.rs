// SPDX-License-Identifier: Apache-2.0
//! Diagnostics as text for people: `FILE.lf:LINE:COLUMN: error[CODE]: sentence`, the lines meant, and a hint.

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

use super::{Diagnostic, Severity, SourceMap, Span};

/// Whether to use colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Style {
    /// Plain text, for files and pipes.
    #[default]
    Plain,
    /// With terminal colours.
    Coloured,
}

/// One diagnostic, ending in a new line.
pub(super) fn render(diagnostic: &Diagnostic, sources: &SourceMap, style: Style) -> String {
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

fn place(span: Span, sources: &SourceMap) -> String {
    sources.get(span.file).map_or_else(String::new, |file| {
        let position = file.position(span.start);
        format!("{}:{}:{}", file.path(), position.line, position.column)
    })
}

/// The lines of the program that the diagnostic is about, with what is underlined in them.
fn excerpt(diagnostic: &Diagnostic, sources: &SourceMap, style: Style) -> Option<String> {
    let file = sources.get(diagnostic.span.file)?;
    if file.text().trim().is_empty() {
        return None;
    }
    let main = Snippet::source(file.text()).annotation(
        AnnotationKind::Primary
            .span(underlined(diagnostic.span, file.text()))
            .label((!diagnostic.label.is_empty()).then_some(diagnostic.label.as_str())),
    );
    let (here, elsewhere): (Vec<_>, Vec<_>) =
        diagnostic.secondary.iter().partition(|label| label.span.file == diagnostic.span.file);
    let main = main.annotations(
        here.into_iter()
            .map(|label| AnnotationKind::Context.span(underlined(label.span, file.text())).label(label.text.as_str())),
    );
    let level = match diagnostic.severity() {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let mut group = Group::with_level(level).element(main);
    for label in elsewhere {
        let Some(other) = sources.get(label.span.file) else { continue };
        let snippet = Snippet::source(other.text())
            .path(other.path())
            .annotation(AnnotationKind::Context.span(underlined(label.span, other.text())).label(label.text.as_str()));
        group = group.element(snippet);
    }
    let renderer = match style {
        Style::Plain => Renderer::plain(),
        Style::Coloured => Renderer::styled(),
    };
    Some(renderer.decor_style(DecorStyle::Ascii).render(&[group]))
}

/// The span within the text, on character boundaries and within one line, so that a missing end of a block does not
/// print the whole file.
fn underlined(span: Span, text: &str) -> std::ops::Range<usize> {
    let floor = |at: usize| (0..=at.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
    let start = floor(span.start);
    let end = floor(span.end).max(start);
    let line_end = text[start..end].find(['\n', '\r']).map_or(end, |length| start + length);
    start..line_end
}
