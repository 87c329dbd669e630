// SPDX-License-Identifier: Apache-2.0
//! Where names are: their declarations, their uses, and other names for them.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use lf_compiler::diagnostics::Span;
use lf_compiler::{Diagnostics, NameKind, ResolvedNames, Severity, compile, names};
use lsp_types::{
    GotoDefinitionParams, Location, PrepareRenameResponse, ReferenceParams, RenameParams, TextDocumentPositionParams,
    TextEdit, Uri, WorkspaceEdit,
};

use super::asked::{Asked, location};
use super::buffers::Buffers;
use super::positions::range;

/// Returns the declaration of the name at a place.
pub(super) fn definition(buffers: &Buffers, asked: &GotoDefinitionParams) -> Option<Location> {
    let asked = Asked::new(buffers, &asked.text_document_position_params)?;
    let (_, declaration) = asked.declaration()?;
    location(buffers, &asked.names, declaration.span)
}

/// Returns the places of the name at a place, in this file, in those that it imports, and in the other open ones.
pub(super) fn references(buffers: &Buffers, asked: &ReferenceParams) -> Option<Vec<Location>> {
    let is_wanted = asked.context.include_declaration;
    let asked = Asked::new(buffers, &asked.text_document_position)?;
    let declared = location(buffers, &asked.names, asked.declaration()?.1.span)?;
    let mut all = Vec::new();
    for_each_place(buffers, &declared, |names, span| {
        let place = location(buffers, names, span);
        all.extend(place.filter(|place| (is_wanted || *place != declared) && !all.contains(place)));
    });
    Some(all)
}

/// Calls a function with each place that names what is declared somewhere. Several open programs may have one place.
fn for_each_place(buffers: &Buffers, declared: &Location, mut each: impl FnMut(&ResolvedNames, Span)) {
    for path in buffers.paths() {
        let names = names(path, buffers);
        let mut is_it = BTreeMap::new();
        for (span, declaration) in names.iter() {
            let declaration = declaration.span;
            let found = is_it
                .entry(declaration)
                .or_insert_with(|| location(buffers, &names, declaration).as_ref() == Some(declared));
            if *found {
                each(&names, span);
            }
        }
    }
}

/// Returns the name at a place, if it can be another one.
pub(super) fn prepare_rename(buffers: &Buffers, asked: &TextDocumentPositionParams) -> Option<PrepareRenameResponse> {
    let asked = Asked::new(buffers, asked)?;
    let (span, _) = asked.declaration()?;
    let placeholder = asked.names.sources().slice(span).to_owned();
    Some(PrepareRenameResponse::RangeWithPlaceholder { range: range(asked.source()?, span), placeholder })
}

/// Returns the changes that give the name at a place another one in all open files and in what they import.
///
/// # Errors
/// When the new name is taken, or the program would get an error that it has not.
pub(super) fn rename(buffers: &Buffers, wanted: &RenameParams) -> Result<Option<WorkspaceEdit>, String> {
    let Some(asked) = Asked::new(buffers, &wanted.text_document_position) else { return Ok(None) };
    let Some((span, declaration)) = asked.declaration() else { return Ok(None) };
    let (old, new) = (asked.names.sources().slice(span).to_owned(), wanted.new_name.trim());
    if old == new {
        return Ok(None);
    }
    let mut letters = new.chars();
    if !letters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        || !letters.all(|c| c.is_ascii_alphanumeric() || c == '_')
    {
        return Err(format!("`{new}` is no name: names consist of letters, digits and _"));
    }
    if declaration.kind == NameKind::TypeParameter {
        return Err("type parameters cannot be renamed here: code in types and bodies may name them".to_owned());
    }
    // A name for an imported reactor is one of its file alone.
    let is_alias = asked.name(declaration) != old;
    let Some(declared) = location(buffers, &asked.names, declaration.span) else { return Ok(None) };
    let mut edits: BTreeMap<String, BTreeSet<(usize, usize)>> = BTreeMap::new();
    let mut taken = None;
    for_each_place(buffers, &declared, |names, place| {
        let Some(source) = names.sources().get(place.file) else { return };
        if names.sources().slice(place) != old || (is_alias && source.path() != asked.path) {
            return;
        }
        edits.entry(source.path().to_owned()).or_default().insert((place.start, place.end));
        taken = taken.take().or_else(|| captures(names, place, new).then(|| source.position(place.start).line));
    });
    if let Some(line) = taken {
        return Err(format!("`{new}` stands already in the code with `{old}` in line {line}: choose another name"));
    }
    if let Some(error) = new_error(buffers, &changed(buffers, &edits, new)?) {
        return Err(format!("with this name the program is wrong: {error}"));
    }
    #[allow(clippy::mutable_key_type, reason = "the protocol's own type has this key")]
    let mut changes: HashMap<Uri, Vec<TextEdit>> = HashMap::new();
    for (path, places) in &edits {
        let uri = buffers.uri(path).and_then(|uri| uri.parse().ok());
        let known = asked.names.sources().iter().find(|(_, source)| source.path() == path);
        let other = known.is_none().then(|| names(path, buffers));
        let source = known.map(|(_, source)| source);
        let source = source.or_else(|| other.as_ref()?.sources().iter().next().map(|(_, source)| source));
        let (Some(uri), Some(source)) = (uri, source) else { continue };
        let edit = |(start, end): &(usize, usize)| {
            let place = Span { start: *start, end: *end, ..Span::default() };
            TextEdit::new(range(source, place), new.to_owned())
        };
        changes.insert(uri, places.iter().map(edit).collect());
    }
    Ok(Some(WorkspaceEdit { changes: Some(changes), ..WorkspaceEdit::default() }))
}

/// Returns whether a word stands in the code block around a place.
fn captures(names: &ResolvedNames, place: Span, word: &str) -> bool {
    let Some(source) = names.sources().get(place.file) else { return false };
    let text = source.text();
    let block = text[..place.start].rfind("{=").filter(|open| !text[*open..place.start].contains("=}"));
    let Some(open) = block else { return false };
    let code = &text[open..place.end + text[place.end..].find("=}").unwrap_or(0)];
    code.split(|c: char| !c.is_alphanumeric() && c != '_').any(|one| one == word)
}

/// Returns the texts of the open files and of others, as they would be.
fn changed(
    buffers: &Buffers,
    edits: &BTreeMap<String, BTreeSet<(usize, usize)>>,
    new: &str,
) -> Result<Buffers, String> {
    use lf_compiler::SourceProvider as _;
    let mut after = buffers.clone();
    for (path, places) in edits {
        let mut text = buffers.read(path)?;
        for (start, end) in places.iter().rev() {
            if text.get(*start..*end).is_none() {
                return Err(format!("{path} has changed: save it, and try again"));
            }
            text.replace_range(start..end, new);
        }
        after.replace(path, text);
    }
    Ok(after)
}

/// Returns the first error that the open programs do not have yet.
fn new_error(before: &Buffers, after: &Buffers) -> Option<String> {
    let errors = |found: &Diagnostics| -> Vec<String> {
        let errors = found.iter().filter(|one| one.severity() == Severity::Error);
        errors.map(|one| one.message.clone()).collect()
    };
    before.paths().find_map(|path| {
        let (old, new) = (errors(&compile(path, before).diagnostics), errors(&compile(path, after).diagnostics));
        if new.len() > old.len() { new.into_iter().find(|message| !old.contains(message)) } else { None }
    })
}
