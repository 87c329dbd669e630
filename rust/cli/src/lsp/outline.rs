// SPDX-License-Identifier: Apache-2.0
//! The shape of a file: its reactors, what can be folded, and how it is formatted.

use lf_compiler::diagnostics::Span;
use lf_compiler::syntax::{Lexeme, LexemeKind, lexemes};
use lf_compiler::{NameKind, format};
use lsp_types::{
    DocumentFormattingParams, DocumentSymbol, DocumentSymbolParams, FoldingRange, FoldingRangeKind, FoldingRangeParams,
    SymbolKind, TextEdit,
};

use super::asked::{Asked, described};
use super::buffers::Buffers;
use super::positions::{position, range};

/// Returns the reactors of a file, with what each declares.
pub(super) fn symbols(buffers: &Buffers, asked: &DocumentSymbolParams) -> Option<Vec<DocumentSymbol>> {
    let asked = Asked::whole(buffers, &asked.text_document)?;
    let source = asked.source()?;
    let blocks = blocks(asked.text);
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
    let reactors = asked.unit().reactors.iter().map(|reactor| {
        let name = reactor.name.as_ref().map_or("main", |name| name.text.as_str());
        let mut symbol = symbol(name, None, SymbolKind::CLASS, reactor.span());
        let body = blocks.iter().find(|block| block.start >= reactor.keyword.start);
        symbol.range = range(source, reactor.keyword);
        symbol.range.end = position(source, body.map_or(reactor.keyword.end, |body| body.end));
        symbol
    });
    let mut reactors: Vec<DocumentSymbol> = reactors.collect();
    for declaration in asked.declared() {
        let Some(reactor) = asked.reactor_at(declaration.span.start) else { continue };
        let name = asked.name(declaration);
        let member = symbol(name, Some(described(declaration, name)), symbol_kind(declaration.kind), declaration.span);
        reactors[reactor].children.get_or_insert_default().push(member);
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

/// Returns the outermost blocks in braces; one without an end ends with the text.
fn blocks(text: &str) -> Vec<Span> {
    let mut blocks = Vec::new();
    for (open, close, depth) in pairs(text) {
        if depth == 0 && text[open..].starts_with('{') {
            blocks.push(Span { start: open, end: close, ..Span::default() });
        }
    }
    blocks.sort();
    blocks
}

/// Returns the brackets with the bytes behind their counterparts, and the number of brackets around them.
fn pairs(text: &str) -> Vec<(usize, usize, usize)> {
    let (mut open, mut pairs): (Vec<usize>, Vec<_>) = (Vec::new(), Vec::new());
    for Lexeme { kind, start, end } in lexemes(text) {
        match kind {
            LexemeKind::Open => open.push(start),
            LexemeKind::Close => {
                if let Some(begin) = open.pop() {
                    pairs.push((begin, end, open.len()));
                }
            }
            _ => {}
        }
    }
    while let Some(begin) = open.pop() {
        pairs.push((begin, text.len(), open.len()));
    }
    pairs
}

/// Returns what can be folded: blocks, code and comments of several lines, and imports.
pub(super) fn folding(buffers: &Buffers, asked: &FoldingRangeParams) -> Option<Vec<FoldingRange>> {
    let asked = Asked::whole(buffers, &asked.text_document)?;
    let source = asked.source()?;
    let line = |byte: usize| position(source, byte).line;
    let fold = |start: usize, end: usize, kind: Option<FoldingRangeKind>| {
        let (start_line, end_line) = (line(start), line(end));
        let kind_of = FoldingRange { start_line, end_line, kind, ..FoldingRange::default() };
        (end_line > start_line).then_some(kind_of)
    };
    // The line with the closing bracket stays.
    let before = |end: usize| asked.text[..end].rfind('\n').unwrap_or(end);
    let mut all: Vec<FoldingRange> =
        pairs(asked.text).into_iter().filter_map(|(open, close, _)| fold(open, before(close), None)).collect();
    let pieces = lexemes(asked.text);
    all.extend(
        pieces
            .iter()
            .filter(|one| one.kind == LexemeKind::Code)
            .filter_map(|one| fold(one.start, before(one.end), None)),
    );
    let comments: Vec<&Lexeme> = pieces.iter().filter(|one| one.kind == LexemeKind::Comment).collect();
    // Comments in successive lines are one.
    for run in comments.chunk_by(|one, next| asked.text[one.end..next.start].trim().is_empty()) {
        let (first, last) = (run[0], run[run.len() - 1]);
        all.extend(fold(first.start, last.end, Some(FoldingRangeKind::Comment)));
    }
    if let [first, .., last] = &asked.unit().imports[..] {
        all.extend(fold(first.span.start, last.span.end, Some(FoldingRangeKind::Imports)));
    }
    all.sort_by_key(|one| (one.start_line, one.end_line));
    Some(all)
}

/// Formats a file; one with errors of syntax stays as it is, as the diagnostics say.
pub(super) fn formatting(buffers: &Buffers, asked: &DocumentFormattingParams) -> Option<Vec<TextEdit>> {
    let asked = Asked::whole(buffers, &asked.text_document)?;
    let formatted = format(asked.path, asked.text).ok().filter(|formatted| formatted != asked.text)?;
    let source = asked.source()?;
    let whole = lsp_types::Range::new(position(source, 0), position(source, asked.text.len()));
    Some(vec![TextEdit::new(whole, formatted)])
}
