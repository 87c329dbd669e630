// SPDX-License-Identifier: Apache-2.0
//! Answers of tools at the places of the program, and together with our own.

use lsp_types::{
    CompletionItem, CompletionList, CompletionResponse, CompletionTextEdit, Diagnostic, GotoDefinitionResponse, Hover,
    HoverContents, InsertTextFormat, Location, MarkupContent, MarkupKind, Range, Uri,
};
use serde_json::Value;
use url::Url;

use super::project::CodeProject;
use crate::lsp::buffers::Buffers;

/// A kind of question that tools answer, too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::lsp) enum BodyQuestion {
    Hover,
    Definition,
    Completion,
    Signature,
}

/// Where an answer belongs.
pub(super) struct Translation<'p> {
    pub(super) project: &'p CodeProject,
    pub(super) buffers: &'p Buffers,
    /// The generated file that was asked about.
    pub(super) file: &'p str,
    /// Whether the place was exactly the one in the program.
    pub(super) is_exact: bool,
}

impl Translation<'_> {
    /// Returns an answer with the places of the program; `None` if nothing of it is there.
    pub(super) fn answer(&self, kind: BodyQuestion, answer: Value) -> Option<Value> {
        match kind {
            BodyQuestion::Signature => (!answer.is_null()).then_some(answer),
            BodyQuestion::Hover => {
                let hover: Hover = serde_json::from_value(answer).ok()?;
                let range = hover.range.and_then(|range| Some(self.project.to_lf(self.file, range)?.1));
                serde_json::to_value(Hover { range, ..hover }).ok()
            }
            BodyQuestion::Definition => {
                let all = match serde_json::from_value(answer).ok()? {
                    GotoDefinitionResponse::Scalar(one) => vec![one],
                    GotoDefinitionResponse::Array(all) => all,
                    GotoDefinitionResponse::Link(_) => Vec::new(),
                };
                let all: Vec<Location> = all.into_iter().filter_map(|one| self.location(one)).collect();
                if all.is_empty() { None } else { serde_json::to_value(all).ok() }
            }
            BodyQuestion::Completion => {
                let list = match serde_json::from_value(answer).ok()? {
                    CompletionResponse::Array(items) => CompletionList { is_incomplete: false, items },
                    CompletionResponse::List(list) => list,
                };
                serde_json::to_value(self.list(list)).ok()
            }
        }
    }

    /// Returns a place of the program, or one of a library.
    fn location(&self, Location { uri, range }: Location) -> Option<Location> {
        let path = Url::parse(uri.as_str()).ok()?.to_file_path().ok()?;
        let Some(inside) = self.project.inside(&path) else { return Some(Location { uri, range }) };
        let (path, range) = self.project.origin(&inside, range)?;
        let uri: Uri = self.buffers.uri(path)?.parse().ok()?;
        Some(Location { uri, range })
    }

    fn list(&self, list: CompletionList) -> CompletionList {
        // Most items replace the same word.
        let mut known: Option<(Range, Option<Range>)> = None;
        let mut to_lf = |range: Range| match known {
            Some((same, there)) if same == range => there,
            _ => {
                let there = self.project.to_lf(self.file, range).filter(|_| self.is_exact).map(|(_, range)| range);
                known = Some((range, there));
                there
            }
        };
        let items = list.items.into_iter().filter_map(|item| {
            // What stands elsewhere cannot be edited.
            if item.additional_text_edits.as_ref().is_some_and(|edits| !edits.is_empty())
                || item.insert_text_format == Some(InsertTextFormat::SNIPPET)
            {
                return None;
            }
            let (insert_text, text_edit) = match item.text_edit {
                None => (item.insert_text, None),
                Some(CompletionTextEdit::Edit(mut edit)) => match to_lf(edit.range) {
                    Some(range) => {
                        edit.range = range;
                        (None, Some(CompletionTextEdit::Edit(edit)))
                    }
                    None => (Some(edit.new_text), None),
                },
                Some(CompletionTextEdit::InsertAndReplace(mut edit)) => match (to_lf(edit.insert), to_lf(edit.replace))
                {
                    (Some(insert), Some(replace)) => {
                        (edit.insert, edit.replace) = (insert, replace);
                        (None, Some(CompletionTextEdit::InsertAndReplace(edit)))
                    }
                    _ => (Some(edit.new_text), None),
                },
            };
            let (additional_text_edits, command, data) = (None, None, None);
            Some(CompletionItem { insert_text, text_edit, additional_text_edits, command, data, ..item })
        });
        CompletionList { is_incomplete: list.is_incomplete, items: items.collect() }
    }
}

/// Returns diagnostics at the places of the program, each with its LF file; those of scaffolding are not the program's.
pub(super) fn diagnostics(project: &CodeProject, file: &str, all: Vec<Diagnostic>) -> Vec<(String, Diagnostic)> {
    let at_lf = |diagnostic: Diagnostic| {
        let (path, range) = project.to_lf(file, diagnostic.range)?;
        let (code_description, related_information, data) = (None, None, None);
        Some((path.to_owned(), Diagnostic { range, code_description, related_information, data, ..diagnostic }))
    };
    all.into_iter().filter_map(at_lf).collect()
}

/// Returns our own answer together with a tool's.
pub(super) fn together(kind: BodyQuestion, own: Value, other: Value) -> Value {
    let both = match kind {
        BodyQuestion::Hover => hovers(&own, &other),
        BodyQuestion::Completion => completions(&own, &other),
        BodyQuestion::Definition | BodyQuestion::Signature => None,
    };
    both.unwrap_or(if own.is_null() { other } else { own })
}

fn hovers(own: &Value, other: &Value) -> Option<Value> {
    let (own, other): (Hover, Hover) = (read(own)?, read(other)?);
    let (HoverContents::Markup(own_text), HoverContents::Markup(text)) = (own.contents, other.contents) else {
        return None;
    };
    let value = format!("{}\n\n---\n\n{}", own_text.value, text.value);
    let contents = HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value });
    serde_json::to_value(Hover { contents, range: own.range }).ok()
}

/// Ours come first: they say what a name is in LF. An item of the same name is left out.
fn completions(own: &Value, other: &Value) -> Option<Value> {
    fn name(label: &str) -> &str {
        label.split(['(', '!', ' ']).find(|word| !word.is_empty()).unwrap_or(label)
    }
    let own: Vec<CompletionItem> = read(own)?;
    let CompletionList { is_incomplete, items } = read(other)?;
    let is_new = |item: &CompletionItem| !own.iter().any(|one| name(&one.label) == name(&item.label));
    let others: Vec<CompletionItem> = items.into_iter().filter(is_new).collect();
    let first = |item: CompletionItem| CompletionItem { sort_text: Some(format!("0{}", item.label)), ..item };
    let items = own.iter().cloned().map(first).chain(others).collect();
    serde_json::to_value(CompletionList { is_incomplete, items }).ok()
}

fn read<T: serde::de::DeserializeOwned>(value: &Value) -> Option<T> {
    serde_json::from_value(value.clone()).ok()
}
