// SPDX-License-Identifier: Apache-2.0
//! The compiler's knowledge in the terms of the protocol.

use std::collections::BTreeMap;

use lf_compiler::diagnostics::{FileId, SourceTexts, Span};
use lf_compiler::{Code, Declaration, NameKind, ResolvedNames, Severity, compile, format, names, parse};
use lsp_types::{
    CompletionItem, CompletionItemKind, CompletionParams, Diagnostic, DiagnosticRelatedInformation, DiagnosticSeverity,
    DocumentFormattingParams, DocumentSymbol, DocumentSymbolParams, GotoDefinitionParams, Hover, HoverContents,
    HoverParams, Location, MarkupContent, MarkupKind, NumberOrString, ReferenceParams, SymbolKind,
    TextDocumentPositionParams, TextEdit, Uri,
};

use super::buffers::Buffers;
use super::positions::{byte, position, range};

/// The words that begin declarations in a reactor.
const MEMBERS: &[&str] = &[
    "input",
    "output",
    "state",
    "timer",
    "logical action",
    "physical action",
    "reaction",
    "mode",
    "initial mode",
    "watchdog",
    "preamble",
    "method",
    "reset state",
    "mutable input",
];
/// The words that begin declarations in a file.
const TOP: &[&str] = &["target", "import", "preamble", "reactor", "main reactor", "federated reactor"];

/// Returns the diagnostics of all open files and what they import, by the editor's names of the files.
pub(super) fn diagnostics(buffers: &Buffers) -> BTreeMap<String, Vec<Diagnostic>> {
    let mut all: BTreeMap<String, Vec<Diagnostic>> = BTreeMap::new();
    for path in buffers.paths() {
        all.extend(buffers.uri(path).map(|uri| (uri, Vec::new())));
        let found = compile(path, buffers).diagnostics;
        let is_library = is_library(buffers, path);
        for diagnostic in found.iter().filter(|diagnostic| !(is_library && diagnostic.code == Code::NoMain)) {
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
    use lf_compiler::SourceProvider as _;
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

/// A place in an open file.
struct Asked<'b> {
    text: &'b str,
    byte: usize,
    names: ResolvedNames,
    file: FileId,
    /// The reactors of the file, in the order of the text: the keyword, and the name or what stands for it.
    reactors: Vec<(Span, String)>,
}

impl<'b> Asked<'b> {
    fn new(buffers: &'b Buffers, at: &TextDocumentPositionParams) -> Option<Self> {
        let (path, text) = buffers.get(&at.text_document.uri)?;
        let names = names(path, buffers);
        let file = names.sources().iter().find(|(_, source)| source.path() == path).map(|(file, _)| file)?;
        let reactors = parse(path, text).unit.reactors.into_iter().map(|reactor| {
            let name = reactor.name.map_or_else(|| "main".to_owned(), |name| name.text);
            (reactor.keyword, name)
        });
        Some(Self { text, byte: byte(text, at.position), names, file, reactors: reactors.collect() })
    }

    fn declaration(&self) -> Option<(Span, &Declaration)> {
        self.names.at(self.file, self.byte)
    }

    /// Returns what the reactors of this file declare, in the order of the text.
    fn declared(&self) -> impl Iterator<Item = &Declaration> {
        let own = |(span, declaration): &(Span, &Declaration)| declaration.span == *span && span.file == self.file;
        let declared = self.names.iter().filter(own).map(|(_, declaration)| declaration);
        declared.filter(|declaration| declaration.kind != NameKind::Reactor)
    }

    /// Returns the number of the reactor at a byte of this file.
    fn reactor_at(&self, byte: usize) -> Option<usize> {
        self.reactors.partition_point(|(keyword, _)| keyword.start <= byte).checked_sub(1)
    }

    /// Returns what the reactor at the place declares.
    fn members(&self) -> impl Iterator<Item = &Declaration> {
        let reactor = self.reactor_at(self.byte);
        self.declared().filter(move |one| reactor.is_some() && self.reactor_at(one.span.start) == reactor)
    }

    /// Returns the inputs and outputs of a class, as far as it declares them itself.
    fn ports_of(&self, class: Span) -> impl Iterator<Item = &Declaration> {
        let all = self.names.iter().filter(|(span, one)| one.span == *span).map(|(_, one)| one);
        let own = all.skip_while(move |one| one.span != class).skip(1);
        let own = own.take_while(move |one| one.span.file == class.file && one.kind != NameKind::Reactor);
        own.filter(|one| matches!(one.kind, NameKind::Input | NameKind::Output))
    }
}

/// Describes the name at a place.
pub(super) fn hover(buffers: &Buffers, asked: &HoverParams) -> Option<Hover> {
    let asked = Asked::new(buffers, &asked.text_document_position_params)?;
    let (span, declaration) = asked.declaration()?;
    let name = asked.names.sources().slice(declaration.span);
    let docs = declaration.docs.as_ref().map(|docs| format!("\n\n{docs}")).unwrap_or_default();
    let value = format!("```lf\n{}\n```{docs}", described(declaration, name));
    let contents = HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value });
    let range = asked.names.sources().get(span.file).map(|source| range(source, span));
    Some(Hover { contents, range })
}

/// Returns a declaration in a line, as LF has it.
fn described(declaration: &Declaration, name: &str) -> String {
    let ty = declaration.ty.as_deref();
    match declaration.kind {
        NameKind::Instance => format!("{name} = new {}()", ty.unwrap_or_default()),
        kind => format!("{} {name}{}", word(kind), ty.map(|ty| format!(": {ty}")).unwrap_or_default()),
    }
}

fn word(kind: NameKind) -> &'static str {
    match kind {
        NameKind::Reactor => "reactor",
        NameKind::TypeParameter => "type",
        NameKind::Parameter => "parameter",
        NameKind::State => "state",
        NameKind::Input => "input",
        NameKind::Output => "output",
        NameKind::Timer => "timer",
        NameKind::LogicalAction => "logical action",
        NameKind::PhysicalAction => "physical action",
        NameKind::Watchdog => "watchdog",
        NameKind::Instance => "instance",
        NameKind::Mode => "mode",
        NameKind::Method => "method",
        NameKind::Reaction => "reaction",
    }
}

fn location(buffers: &Buffers, names: &ResolvedNames, span: Span) -> Option<Location> {
    let source = names.sources().get(span.file)?;
    let uri: Uri = buffers.uri(source.path())?.parse().ok()?;
    Some(Location::new(uri, range(source, span)))
}

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
    for path in buffers.paths() {
        let names = names(path, buffers);
        let places = names.iter().filter_map(|(span, declaration)| {
            let is_it = location(buffers, &names, declaration.span).as_ref() == Some(&declared);
            is_it.then(|| location(buffers, &names, span)).flatten()
        });
        for place in places.filter(|place| is_wanted || *place != declared) {
            if !all.contains(&place) {
                all.push(place);
            }
        }
    }
    Some(all)
}

/// Returns the reactors of a file, with what each declares.
pub(super) fn symbols(buffers: &Buffers, asked: &DocumentSymbolParams) -> Option<Vec<DocumentSymbol>> {
    let at = TextDocumentPositionParams::new(asked.text_document.clone(), lsp_types::Position::default());
    let asked = Asked::new(buffers, &at)?;
    let source = asked.names.sources().get(asked.file)?;
    #[allow(deprecated, reason = "the protocol's own type has a field of an earlier version")]
    let symbol = |name: &str, detail: Option<String>, kind, span| DocumentSymbol {
        name: name.to_owned(),
        detail,
        kind,
        tags: None,
        deprecated: None,
        range: range(source, span),
        selection_range: range(source, span),
        children: None,
    };
    let mut reactors: Vec<DocumentSymbol> =
        asked.reactors.iter().map(|(keyword, name)| symbol(name, None, SymbolKind::CLASS, *keyword)).collect();
    for declaration in asked.declared() {
        let Some(reactor) = asked.reactor_at(declaration.span.start) else { continue };
        let name = asked.names.sources().slice(declaration.span);
        let member = symbol(name, Some(described(declaration, name)), symbol_kind(declaration.kind), declaration.span);
        let reactor = &mut reactors[reactor];
        reactor.range.end = member.range.end;
        reactor.children.get_or_insert_default().push(member);
    }
    Some(reactors)
}

fn symbol_kind(kind: NameKind) -> SymbolKind {
    match kind {
        NameKind::Reactor => SymbolKind::CLASS,
        NameKind::TypeParameter => SymbolKind::TYPE_PARAMETER,
        NameKind::Parameter => SymbolKind::CONSTANT,
        NameKind::State => SymbolKind::FIELD,
        NameKind::Input | NameKind::Output => SymbolKind::INTERFACE,
        NameKind::Timer | NameKind::LogicalAction | NameKind::PhysicalAction | NameKind::Watchdog => SymbolKind::EVENT,
        NameKind::Instance => SymbolKind::OBJECT,
        NameKind::Mode => SymbolKind::NAMESPACE,
        NameKind::Method | NameKind::Reaction => SymbolKind::METHOD,
    }
}

/// Formats a file; one with errors of syntax stays as it is, as the diagnostics say.
pub(super) fn formatting(buffers: &Buffers, asked: &DocumentFormattingParams) -> Option<Vec<TextEdit>> {
    let (path, text) = buffers.get(&asked.text_document.uri)?;
    let formatted = format(path, text).ok().filter(|formatted| formatted != text)?;
    let whole = lsp_types::Range::new(position(text, 0), position(text, text.len()));
    Some(vec![TextEdit::new(whole, formatted)])
}

/// Returns what may stand at a place: behind `instance.` its ports; elsewhere the names in the reactor, reactors, and
/// the words that begin a declaration.
pub(super) fn completion(buffers: &Buffers, asked: &CompletionParams) -> Option<Vec<CompletionItem>> {
    let asked = Asked::new(buffers, &asked.text_document_position)?;
    let slice = |declaration: &Declaration| asked.names.sources().slice(declaration.span);
    let before = asked.text[..asked.byte].trim_end_matches(|c: char| c.is_alphanumeric() || c == '_');
    let item = |declaration: &Declaration| CompletionItem {
        label: slice(declaration).to_owned(),
        kind: Some(completion_kind(declaration.kind)),
        detail: Some(described(declaration, slice(declaration))),
        documentation: declaration.docs.clone().map(lsp_types::Documentation::String),
        ..CompletionItem::default()
    };
    if let Some(before) = before.strip_suffix('.') {
        let name = before.rsplit(|c: char| !c.is_alphanumeric() && c != '_').next()?;
        let is_it = |one: &&Declaration| one.kind == NameKind::Instance && slice(one) == name;
        let class = asked.members().find(is_it)?.ty.clone()?;
        let class = class.split('<').next().unwrap_or_default().trim();
        let is_class = |(span, one): &(Span, &Declaration)| {
            one.kind == NameKind::Reactor && asked.names.sources().slice(*span) == class
        };
        let class = asked.names.iter().find(is_class).map(|(_, one)| one.span)?;
        return Some(asked.ports_of(class).map(item).collect());
    }
    let keyword = |word: &&str| CompletionItem {
        label: (*word).to_owned(),
        kind: Some(CompletionItemKind::KEYWORD),
        ..CompletionItem::default()
    };
    let reactors = asked.names.iter().filter(|(span, one)| one.span == *span && one.kind == NameKind::Reactor);
    let mut all: Vec<CompletionItem> = reactors.map(|(_, one)| item(one)).collect();
    all.extend(asked.members().map(item));
    all.extend(MEMBERS.iter().chain(TOP).map(keyword));
    Some(all)
}

fn completion_kind(kind: NameKind) -> CompletionItemKind {
    match kind {
        NameKind::Reactor => CompletionItemKind::CLASS,
        NameKind::TypeParameter => CompletionItemKind::TYPE_PARAMETER,
        NameKind::Parameter => CompletionItemKind::CONSTANT,
        NameKind::State => CompletionItemKind::FIELD,
        NameKind::Input | NameKind::Output => CompletionItemKind::INTERFACE,
        NameKind::Timer | NameKind::LogicalAction | NameKind::PhysicalAction | NameKind::Watchdog => {
            CompletionItemKind::EVENT
        }
        NameKind::Instance => CompletionItemKind::VARIABLE,
        NameKind::Mode => CompletionItemKind::MODULE,
        NameKind::Method | NameKind::Reaction => CompletionItemKind::METHOD,
    }
}
