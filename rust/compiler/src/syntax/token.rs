// SPDX-License-Identifier: Apache-2.0
//! Splits text into tokens. Comments are kept separately; code blocks are one token each.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use logos::{FilterResult, Lexer, Logos};

use crate::characters::{is_directing, shown};
use crate::diagnostics::{Code, Diagnostic, FileId, Span};
use crate::lexical::{BlockEnd, Language};

/// The kind of a token.
#[derive(Logos, Clone, Copy, Debug, PartialEq, Eq)]
#[logos(extras = Reading)]
#[logos(skip r"[ \t\r\n\f]+")]
pub(crate) enum TokenKind {
    /// A name or a keyword.
    #[regex("[A-Za-z_][A-Za-z0-9_]*", word)]
    Word,
    #[regex("[0-9]+")]
    Int,
    #[regex(r"[0-9]*\.[0-9]+([eE][+-]?[0-9]+)?")]
    #[regex(r"[0-9]+[eE][+-]?[0-9]+")]
    Float,
    /// `{= … =}`
    #[token("{=", code)]
    Code,
    /// `"…"` or `"""…"""`
    #[token("\"\"\"", long_string)]
    #[token("\"", string)]
    Text,
    /// `'a` of Rust, which is no part of LF.
    #[regex("'[A-Za-z_][A-Za-z0-9_]*")]
    Lifetime,
    /// `'x'`
    #[regex(r"'(\\.|[^\\'\t\r\n])'")]
    Character,
    /// `//`, `#`, `/* */` or `''' '''`; the parser does not see it.
    #[regex(r"(//|#)[^\n\r]*", allow_greedy = true)]
    #[token("/*", |lexer| comment(lexer, "*/"))]
    #[token("'''", |lexer| comment(lexer, "'''"))]
    Comment,
    #[token("->")]
    Arrow,
    #[token("~>")]
    PhysicalArrow,
    #[token("::")]
    DoubleColon,
    #[token("{")]
    OpenBrace,
    #[token("}")]
    CloseBrace,
    #[token("(")]
    OpenParenthesis,
    #[token(")")]
    CloseParenthesis,
    #[token("[")]
    OpenBracket,
    #[token("]")]
    CloseBracket,
    #[token("<")]
    Less,
    #[token(">")]
    Greater,
    #[token(":")]
    Colon,
    #[token(";")]
    Semicolon,
    #[token(",")]
    Comma,
    #[token(".")]
    Dot,
    #[token("+")]
    Plus,
    #[token("-")]
    Minus,
    #[token("*")]
    Star,
    #[token("/")]
    Slash,
    #[token("\\")]
    Backslash,
    #[token("=")]
    Equals,
    #[token("%")]
    Percent,
    #[token("@")]
    At,
    /// Any other character.
    Other,
    /// The end of the text.
    End,
}

/// The state of the lexer.
pub(crate) struct Reading {
    /// Errors within tokens.
    problems: Vec<(Code, Range<usize>)>,
    /// The string or comment that hides the end of the code block at a place.
    hiding: HashMap<usize, Range<usize>>,
    /// The language of code blocks.
    language: Language,
    /// Whether the next word names it.
    names_language: bool,
}

/// A token with its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Token {
    pub(crate) kind: TokenKind,
    pub(crate) start: usize,
    pub(crate) end: usize,
    /// Whether it directly follows the previous token.
    pub(crate) adjacent: bool,
    /// Whether it is the first one of its line.
    pub(crate) first_of_line: bool,
}

/// The tokens of a text, with an [`TokenKind::End`] at the end, and the comments.
pub(crate) struct Tokens {
    pub(crate) list: Vec<Token>,
    pub(crate) comments: Vec<Range<usize>>,
    /// The beginnings of code blocks without an end.
    pub(crate) open: HashSet<usize>,
    pub(crate) diagnostics: Vec<Diagnostic>,
}

/// Splits a text into tokens; the code blocks before a target declaration are of this language.
pub(crate) fn tokens(file: FileId, text: &str, language: Language) -> Tokens {
    let reading = Reading { problems: Vec::new(), hiding: HashMap::new(), language, names_language: false };
    let mut lexer = TokenKind::lexer_with_extras(text, reading);
    let mut tokens = Vec::new();
    let (mut comments, mut directing) = (Vec::new(), Vec::new());
    let mut last_end = 0;
    while let Some(kind) = lexer.next() {
        let Range { start, end } = lexer.span();
        let kind = kind.unwrap_or(TokenKind::Other);
        if matches!(kind, TokenKind::Comment | TokenKind::Text | TokenKind::Code) {
            directing.extend(self::directing(file, text, start..end));
        }
        if kind == TokenKind::Comment {
            comments.push(start..end);
            continue;
        }
        // Meaningless text of any length is one token.
        if let (TokenKind::Other, Some(Token { kind: TokenKind::Other, end: last, .. })) = (kind, tokens.last_mut())
            && *last == start
        {
            *last = end;
            last_end = end;
            continue;
        }
        let first_of_line = tokens.is_empty() || text[last_end..start].contains('\n');
        tokens.push(Token { kind, start, end, adjacent: last_end == start, first_of_line });
        last_end = end;
    }
    let end = text.len();
    tokens.push(Token { kind: TokenKind::End, start: end, end, adjacent: false, first_of_line: true });
    let Reading { problems, hiding, .. } = &lexer.extras;
    let describe = |(code, range): &(Code, Range<usize>)| describe(file, *code, range, hiding.get(&range.start));
    let mut diagnostics: Vec<_> = problems.iter().map(describe).collect();
    diagnostics.extend(directing);
    let open = problems.iter().filter(|(code, _)| *code == Code::UnterminatedCode).map(|(_, range)| range.start);
    Tokens { list: tokens, comments, open: open.collect(), diagnostics }
}

/// Returns the characters that make a comment, a string or code look different from its order.
fn directing(file: FileId, text: &str, range: Range<usize>) -> impl Iterator<Item = Diagnostic> {
    let begin = range.start;
    let found = text[range].char_indices().filter(|(_, c)| is_directing(*c));
    found.map(move |(at, c)| {
        let message = format!("{} shows what follows in another order than it is read", shown(c));
        let span = Span::new(file, begin + at, begin + at + c.len_utf8());
        Diagnostic::new(Code::Syntax, span, message).hint("remove it; in strings of a program, write it as an escape")
    })
}

/// Handles a word: the one behind `target` sets the language of all later code blocks.
fn word(lexer: &mut Lexer<'_, TokenKind>) {
    let text = lexer.slice();
    if lexer.extras.names_language
        && let Some(language) = Language::named(text)
    {
        lexer.extras.language = language;
    }
    lexer.extras.names_language = text == "target";
}

fn code(lexer: &mut Lexer<'_, TokenKind>) {
    let rest = lexer.remainder();
    match lexer.extras.language.block_end(rest) {
        BlockEnd::Found(length) => lexer.bump(length),
        BlockEnd::Hidden { end, by } => {
            lexer.extras.problems.push((Code::UnterminatedCode, lexer.span()));
            let start = lexer.span().end + by;
            let line = rest[by..end].lines().next().map_or(0, str::len);
            lexer.extras.hiding.insert(lexer.span().start, start..start + line);
            lexer.bump(end);
        }
        BlockEnd::Missing => {
            lexer.extras.problems.push((Code::UnterminatedCode, lexer.span()));
            lexer.bump(rest.len());
        }
    }
}

fn long_string(lexer: &mut Lexer<'_, TokenKind>) {
    let rest = lexer.remainder();
    if let Some(length) = rest.find("\"\"\"") {
        lexer.bump(length + 3);
    } else {
        lexer.extras.problems.push((Code::UnterminatedString, lexer.span()));
        lexer.bump(rest.len());
    }
}

/// Reads a plain string, which ends on its line, so that a missing quote does not swallow the rest of the file.
fn string(lexer: &mut Lexer<'_, TokenKind>) {
    let rest = lexer.remainder();
    let mut escaped = false;
    for (index, character) in rest.char_indices() {
        match character {
            '\n' | '\r' => {
                lexer.extras.problems.push((Code::UnterminatedString, lexer.span()));
                lexer.bump(index);
                return;
            }
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => {
                lexer.bump(index + 1);
                return;
            }
            _ => {}
        }
    }
    lexer.extras.problems.push((Code::UnterminatedString, lexer.span()));
    lexer.bump(rest.len());
}

fn comment(lexer: &mut Lexer<'_, TokenKind>, close: &str) -> FilterResult<(), ()> {
    let rest = lexer.remainder();
    if let Some(length) = rest.find(close) {
        lexer.bump(length + close.len());
    } else {
        lexer.extras.problems.push((Code::UnterminatedComment, lexer.span()));
        lexer.bump(rest.len());
    }
    FilterResult::Emit(())
}

fn describe(file: FileId, code: Code, range: &Range<usize>, hiding: Option<&Range<usize>>) -> Diagnostic {
    let (message, hint) = match code {
        Code::UnterminatedCode => (
            "this code block has no end",
            "close it with `=}`; within a string or a comment of the code, `=}` does not count",
        ),
        Code::UnterminatedComment => ("this comment has no end", "close it with the same marks as it was opened"),
        _ => ("this string has no end", "close it with `\"`; `\"\"\"` opens a string of several lines"),
    };
    let span = Span::new(file, range.start, range.end);
    let diagnostic = Diagnostic::new(code, span, message).label("opened here").hint(hint);
    match hiding {
        Some(range) => diagnostic.also(Span::new(file, range.start, range.end), "the `=}` is within this"),
        None => diagnostic,
    }
}
