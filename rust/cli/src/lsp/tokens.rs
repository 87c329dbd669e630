// SPDX-License-Identifier: Apache-2.0
//! The colours of a text: what its words and names are.

use lf_compiler::NameKind;
use lf_compiler::syntax::ast::{Property, PropertyKind};
use lf_compiler::syntax::{LexemeKind, lexemes};
use lsp_types::{SemanticToken, SemanticTokenType, SemanticTokens, SemanticTokensParams};

use super::asked::Asked;
use super::buffers::Buffers;
use super::positions::position;

/// The kinds of tokens; a token has the position of its kind.
pub(super) const KINDS: [SemanticTokenType; 15] = [
    SemanticTokenType::KEYWORD,
    SemanticTokenType::COMMENT,
    SemanticTokenType::STRING,
    SemanticTokenType::NUMBER,
    SemanticTokenType::DECORATOR,
    SemanticTokenType::CLASS,
    SemanticTokenType::TYPE_PARAMETER,
    SemanticTokenType::PARAMETER,
    SemanticTokenType::PROPERTY,
    SemanticTokenType::INTERFACE,
    SemanticTokenType::EVENT,
    SemanticTokenType::VARIABLE,
    SemanticTokenType::NAMESPACE,
    SemanticTokenType::METHOD,
    SemanticTokenType::ENUM_MEMBER,
];

/// Returns the words of a file with their kinds. Code is left to the colours of its own language, except for the names
/// of the reactor in it.
pub(super) fn tokens(buffers: &Buffers, asked: &SemanticTokensParams) -> Option<SemanticTokens> {
    let asked = Asked::whole(buffers, &asked.text_document)?;
    let source = asked.source()?;
    let mut found: Vec<(usize, usize, SemanticTokenType)> = Vec::new();
    let mut is_attribute = false;
    for lexeme in lexemes(asked.text) {
        let kind = match lexeme.kind {
            LexemeKind::Keyword => Some(SemanticTokenType::KEYWORD),
            LexemeKind::Comment => Some(SemanticTokenType::COMMENT),
            LexemeKind::Text => Some(SemanticTokenType::STRING),
            LexemeKind::Number => Some(SemanticTokenType::NUMBER),
            LexemeKind::Word if is_attribute => Some(SemanticTokenType::DECORATOR),
            _ => None,
        };
        is_attribute = asked.text[lexeme.start..lexeme.end] == *"@";
        found.extend(kind.map(|kind| (lexeme.start, lexeme.end, kind)));
    }
    let names = asked.names.iter().filter(|(span, _)| span.file == asked.file);
    found.extend(names.map(|(span, declaration)| (span.start, span.end, of_name(declaration.kind))));
    if let Some(target) = &asked.unit().target {
        keys(&target.properties, &mut found);
    }
    // A name goes before the keyword that it looks like.
    found.sort_by_key(|(start, ..)| *start);
    found.reverse();
    found.dedup_by_key(|(start, ..)| *start);
    found.reverse();
    Some(SemanticTokens { result_id: None, data: encoded(asked.text, source, &found) })
}

fn keys(properties: &[Property], found: &mut Vec<(usize, usize, SemanticTokenType)>) {
    for property in properties {
        found.push((property.key.span.start, property.key.span.end, SemanticTokenType::PROPERTY));
        match &property.value.kind {
            PropertyKind::Map(inner) => keys(inner, found),
            PropertyKind::Path(_) => {
                let span = property.value.span;
                found.push((span.start, span.end, SemanticTokenType::ENUM_MEMBER));
            }
            PropertyKind::List(_) | PropertyKind::Literal(_) | PropertyKind::Time(_) => {}
        }
    }
}

fn of_name(kind: NameKind) -> SemanticTokenType {
    match kind {
        NameKind::Reactor => SemanticTokenType::CLASS,
        NameKind::TypeParameter => SemanticTokenType::TYPE_PARAMETER,
        NameKind::Parameter => SemanticTokenType::PARAMETER,
        NameKind::State => SemanticTokenType::PROPERTY,
        NameKind::Input | NameKind::Output => SemanticTokenType::INTERFACE,
        NameKind::Timer | NameKind::LogicalAction | NameKind::PhysicalAction | NameKind::Watchdog => {
            SemanticTokenType::EVENT
        }
        NameKind::Instance => SemanticTokenType::VARIABLE,
        NameKind::Mode => SemanticTokenType::NAMESPACE,
        NameKind::Method | NameKind::Reaction => SemanticTokenType::METHOD,
    }
}

/// Returns tokens as the protocol counts them: each from the one before, and each on one line.
fn encoded(
    text: &str,
    source: &lf_compiler::diagnostics::SourceText,
    found: &[(usize, usize, SemanticTokenType)],
) -> Vec<SemanticToken> {
    let mut data = Vec::new();
    let (mut last_line, mut last_start) = (0, 0);
    for (start, end, kind) in found {
        let kind = KINDS.iter().position(|one| one == kind).and_then(|kind| u32::try_from(kind).ok());
        let mut at = *start;
        for line in text[*start..*end].split_inclusive('\n') {
            let place = position(source, at);
            let length = u32::try_from(line.trim_end().encode_utf16().count()).unwrap_or(u32::MAX);
            at += line.len();
            let is_new_line = place.line != last_line;
            let delta_start = if is_new_line { place.character } else { place.character - last_start };
            if let Some(token_type) = kind.filter(|_| length > 0) {
                data.push(SemanticToken {
                    delta_line: place.line - last_line,
                    delta_start,
                    length,
                    token_type,
                    token_modifiers_bitset: 0,
                });
                (last_line, last_start) = (place.line, place.character);
            }
        }
    }
    data
}
