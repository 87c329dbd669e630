// SPDX-License-Identifier: Apache-2.0
//! The compiler's diagnostics, and their advice as quick fixes.

use std::collections::{BTreeMap, HashMap};

use lf_compiler::diagnostics::{SourceTexts, Span};
use lf_compiler::{Code, Severity, SourceProvider as _, compile, parse};
use lsp_types::{
    CodeAction, CodeActionKind, CodeActionParams, Diagnostic, DiagnosticRelatedInformation, DiagnosticSeverity,
    Location, NumberOrString, Range, TextEdit, WorkspaceEdit,
};

use super::buffers::Buffers;
use super::positions::range;

/// Returns the diagnostics of all open files and what they import, by the editor's names of the files.
pub(super) fn diagnostics(buffers: &Buffers) -> BTreeMap<String, Vec<Diagnostic>> {
    let mut all: BTreeMap<String, Vec<Diagnostic>> = BTreeMap::new();
    for path in buffers.paths() {
        all.extend(buffers.uri(path).map(|uri| (uri, Vec::new())));
        let found = compile(path, buffers).diagnostics;
        for diagnostic in found.iter() {
            if diagnostic.code == Code::NoMain && is_library(buffers, path) {
                continue;
            }
            let Some((uri, diagnostic)) = told(buffers, found.sources(), diagnostic) else { continue };
            let of_file = all.entry(uri).or_default();
            // Several open programs may import one file.
            if !of_file.contains(&diagnostic) {
                of_file.push(diagnostic);
            }
        }
    }
    all
}

/// Returns whether a file has reactors for others, and no main one.
fn is_library(buffers: &Buffers, path: &str) -> bool {
    let Ok(text) = buffers.read(path) else { return false };
    !parse(path, &text).unit.reactors.is_empty()
}

fn told(
    buffers: &Buffers,
    sources: &SourceTexts,
    diagnostic: &lf_compiler::Diagnostic,
) -> Option<(String, Diagnostic)> {
    let place = |span: Span| {
        let source = sources.get(span.file)?;
        Some((buffers.uri(source.path())?, range(source, span)))
    };
    let (uri, range) = place(diagnostic.span)?;
    let related = diagnostic.secondary.iter().filter_map(|other| {
        let (uri, range) = place(other.span)?;
        let location = Location::new(uri.parse().ok()?, range);
        Some(DiagnosticRelatedInformation { location, message: other.text.clone() })
    });
    let related: Vec<_> = related.collect();
    let severity = match diagnostic.severity() {
        Severity::Error => DiagnosticSeverity::ERROR,
        Severity::Warning => DiagnosticSeverity::WARNING,
    };
    let hint = diagnostic.hint.as_ref().map(|hint| format!("\n{hint}")).unwrap_or_default();
    let told = Diagnostic {
        range,
        severity: Some(severity),
        code: Some(NumberOrString::String(diagnostic.code.text().to_owned())),
        source: Some("lfz".to_owned()),
        message: format!("{}{hint}", diagnostic.message),
        related_information: (!related.is_empty()).then_some(related),
        ..Diagnostic::default()
    };
    Some((uri, told))
}

/// Returns the advice of the diagnostics in a range that is a change of the text.
pub(super) fn fixes(buffers: &Buffers, asked: &CodeActionParams) -> Option<Vec<CodeAction>> {
    let (path, _) = buffers.get(&asked.text_document.uri)?;
    let wanted = buffers.uri(path)?;
    let found = compile(path, buffers).diagnostics;
    let all = found.iter().filter_map(|diagnostic| {
        let (title, text) = fix(found.sources(), diagnostic)?;
        let (uri, told) = told(buffers, found.sources(), diagnostic)?;
        if uri != wanted || !touches(told.range, asked.range) {
            return None;
        }
        let edit = TextEdit::new(told.range, text);
        #[allow(clippy::mutable_key_type, reason = "the protocol's own type has this key")]
        let changes = HashMap::from([(asked.text_document.uri.clone(), vec![edit])]);
        Some(CodeAction {
            title,
            kind: Some(CodeActionKind::QUICKFIX),
            diagnostics: Some(vec![told]),
            edit: Some(WorkspaceEdit { changes: Some(changes), ..WorkspaceEdit::default() }),
            is_preferred: Some(true),
            ..CodeAction::default()
        })
    });
    Some(all.collect())
}

/// Returns the title of a fix, and the text in the place of the diagnostic.
fn fix(sources: &SourceTexts, diagnostic: &lf_compiler::Diagnostic) -> Option<(String, String)> {
    let there = sources.slice(diagnostic.span);
    if let Some(text) = diagnostic.replacement() {
        let is_word = there.chars().all(|c| c.is_alphanumeric() || "_-.".contains(c));
        return (!there.is_empty() && is_word).then(|| (format!("Write `{text}`"), text.to_owned()));
    }
    let is_superfluous = diagnostic.code == Code::NoEffect && there.starts_with('@') && !there.contains('\n');
    is_superfluous.then(|| (format!("Remove `{there}`"), String::new()))
}

fn touches(one: Range, other: Range) -> bool {
    one.start <= other.end && other.start <= one.end
}
