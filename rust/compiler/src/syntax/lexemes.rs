// SPDX-License-Identifier: Apache-2.0
//! The smallest parts of a text, for editors: they are known where the text is no program yet.

use super::token::{TokenKind, tokens};
use super::words::is_reserved;
use crate::diagnostics::FileId;
use crate::lexical::Language;

/// The kind of a lexeme.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LexemeKind {
    /// A word that LF reserves.
    Keyword,
    /// Any other word.
    Word,
    /// A number.
    Number,
    /// A string or a character in quotes.
    Text,
    /// A code block with its marks, up to the end of the text if it has no end.
    Code,
    /// A comment with its marks.
    Comment,
    /// `{`, `(` or `[`.
    Open,
    /// `}`, `)` or `]`.
    Close,
    /// Any other character or arrow.
    Symbol,
}

/// A part of a text; places are bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lexeme {
    /// The kind.
    pub kind: LexemeKind,
    /// The first byte.
    pub start: usize,
    /// The byte after the last one.
    pub end: usize,
}

/// Returns the lexemes of any text, in its order, without blanks.
pub fn lexemes(text: &str) -> Vec<Lexeme> {
    let tokens = tokens(FileId::default(), text, Language::default());
    let mut all: Vec<Lexeme> = tokens
        .list
        .iter()
        .filter(|token| token.kind != TokenKind::End)
        .map(|token| Lexeme {
            kind: kind(token.kind, &text[token.start..token.end]),
            start: token.start,
            end: token.end,
        })
        .collect();
    let comment =
        |range: &core::ops::Range<usize>| Lexeme { kind: LexemeKind::Comment, start: range.start, end: range.end };
    all.extend(tokens.comments.iter().map(comment));
    all.sort_by_key(|lexeme| lexeme.start);
    all
}

fn kind(kind: TokenKind, text: &str) -> LexemeKind {
    match kind {
        TokenKind::Word if is_reserved(text) => LexemeKind::Keyword,
        TokenKind::Word => LexemeKind::Word,
        TokenKind::Int | TokenKind::Float => LexemeKind::Number,
        TokenKind::Text | TokenKind::Character | TokenKind::Lifetime => LexemeKind::Text,
        TokenKind::Code => LexemeKind::Code,
        TokenKind::Comment => LexemeKind::Comment,
        TokenKind::OpenBrace | TokenKind::OpenParenthesis | TokenKind::OpenBracket => LexemeKind::Open,
        TokenKind::CloseBrace | TokenKind::CloseParenthesis | TokenKind::CloseBracket => LexemeKind::Close,
        _ => LexemeKind::Symbol,
    }
}

#[cfg(test)]
mod tests {
    use super::{LexemeKind, lexemes};

    #[test]
    fn a_text_that_is_no_program_has_lexemes() {
        let text = "main reactor { // one\n x = 10 ms ; {= y";
        let all: Vec<_> = lexemes(text).iter().map(|one| (one.kind, &text[one.start..one.end])).collect();
        assert_eq!(all[3], (LexemeKind::Comment, "// one"));
        assert_eq!(all[6], (LexemeKind::Number, "10"));
        assert_eq!(all.last(), Some(&(LexemeKind::Code, "{= y")));
    }
}
