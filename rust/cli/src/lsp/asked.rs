// SPDX-License-Identifier: Apache-2.0
//! A place in an open file that the editor asks about.

use lf_compiler::diagnostics::{FileId, SourceText, Span};
use lf_compiler::syntax::ast::SourceUnit;
use lf_compiler::{Declaration, NameKind, ResolvedNames, names};
use lsp_types::{Location, Position, TextDocumentIdentifier, TextDocumentPositionParams, Uri};

use super::buffers::Buffers;
use super::positions::{byte, range};

/// A place in an open file.
pub(super) struct Asked<'b> {
    pub(super) path: &'b str,
    pub(super) text: &'b str,
    pub(super) byte: usize,
    pub(super) names: ResolvedNames,
    pub(super) file: FileId,
}

impl<'b> Asked<'b> {
    pub(super) fn new(buffers: &'b Buffers, at: &TextDocumentPositionParams) -> Option<Self> {
        let (path, text) = buffers.get(&at.text_document.uri)?;
        let names = names(path, buffers);
        let file = names.sources().iter().find(|(_, source)| source.path() == path).map(|(file, _)| file)?;
        names.tree(file)?;
        Some(Self { path, text, byte: byte(text, at.position), names, file })
    }

    /// Returns the beginning of an open file.
    pub(super) fn whole(buffers: &'b Buffers, document: &TextDocumentIdentifier) -> Option<Self> {
        Self::new(buffers, &TextDocumentPositionParams::new(document.clone(), Position::default()))
    }

    /// Returns the tree of the file.
    pub(super) fn unit(&self) -> &SourceUnit {
        self.names.tree(self.file).expect("`new` has found it")
    }

    /// Returns the text with its places.
    pub(super) fn source(&self) -> Option<&SourceText> {
        self.names.sources().get(self.file)
    }

    /// Returns the name at the place, and its declaration.
    pub(super) fn declaration(&self) -> Option<(Span, &Declaration)> {
        self.names.at(self.file, self.byte)
    }

    /// Returns the name of a declaration.
    pub(super) fn name(&self, declaration: &Declaration) -> &str {
        self.names.sources().slice(declaration.span)
    }

    /// Returns what the reactors of this file declare, in the order of the text.
    pub(super) fn declared(&self) -> impl Iterator<Item = &Declaration> {
        let own = |(span, declaration): &(Span, &Declaration)| declaration.span == *span && span.file == self.file;
        let declared = self.names.iter().filter(own).map(|(_, declaration)| declaration);
        declared.filter(|declaration| declaration.kind != NameKind::Reactor)
    }

    /// Returns the number of the reactor at a byte of this file.
    pub(super) fn reactor_at(&self, byte: usize) -> Option<usize> {
        self.unit().reactors.partition_point(|reactor| reactor.keyword.start <= byte).checked_sub(1)
    }

    /// Returns what the reactor at the place has: what it declares, and what it inherits.
    pub(super) fn members(&self) -> impl Iterator<Item = &Declaration> {
        let reactor = self.reactor_at(self.byte);
        let own = self.declared().filter(move |one| reactor.is_some() && self.reactor_at(one.span.start) == reactor);
        let bases = reactor.into_iter().flat_map(|reactor| &self.unit().reactors[reactor].extends);
        let classes = bases.filter_map(|base| self.names.at(self.file, base.span.start));
        own.chain(classes.flat_map(|(_, class)| self.members_of(class.span)))
    }

    /// Returns the reactor that a file calls so.
    pub(super) fn class(&self, name: &str) -> Option<Span> {
        let is_it = |(span, one): &(Span, &Declaration)| {
            one.kind == NameKind::Reactor && self.names.sources().slice(*span) == name
        };
        self.names.iter().find(is_it).map(|(_, one)| one.span)
    }

    /// Returns what a class declares itself.
    pub(super) fn members_of(&self, class: Span) -> impl Iterator<Item = &Declaration> {
        let all = self.names.iter().filter(|(span, one)| one.span == *span).map(|(_, one)| one);
        let own = all.skip_while(move |one| one.span != class).skip(1);
        own.take_while(move |one| one.span.file == class.file && one.kind != NameKind::Reactor)
    }
}

/// Returns a declaration in a line, as LF has it.
pub(super) fn described(declaration: &Declaration, name: &str) -> String {
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

/// Returns a place in the editor's terms.
pub(super) fn location(buffers: &Buffers, names: &ResolvedNames, span: Span) -> Option<Location> {
    let source = names.sources().get(span.file)?;
    let uri: Uri = buffers.uri(source.path())?.parse().ok()?;
    Some(Location::new(uri, range(source, span)))
}
