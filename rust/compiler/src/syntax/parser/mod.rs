// SPDX-License-Identifier: Apache-2.0
//! Recursive descent over tokens, with recovery at the next declaration.

mod attribute;
mod connection;
mod expression;
mod file;
mod host;
mod member;
mod reaction;
mod reactor;
mod target;
mod types;

use std::collections::HashSet;

use super::ast::{CodeBlock, Name};
use super::token::{Token, TokenKind};
use super::words::{CODE_STARTS, FILE_STARTS, MEMBER_STARTS, is_reserved};
use crate::characters::{instead, shown};
use crate::diagnostics::{Code, Diagnostic, FileId, Span, did_you_mean};
use crate::lexical::CodeKind;

pub(crate) use file::parse;

/// The maximum nesting of expressions, types and property values.
const DEPTH_MAX: usize = 64;

/// The error of a declaration that cannot be parsed, after its diagnostic; the caller recovers.
struct Failed;

type Parsed<T> = Result<T, Failed>;

struct Parser<'t> {
    file: FileId,
    text: &'t str,
    tokens: Vec<Token>,
    comments: Vec<std::ops::Range<usize>>,
    /// The beginnings of code blocks without an end.
    open: HashSet<usize>,
    position: usize,
    depth: usize,
    diagnostics: Vec<Diagnostic>,
    /// The position of the current mode in the reactor.
    mode: Option<usize>,
    /// All closed code blocks.
    codes: Vec<(CodeBlock, CodeKind)>,
    /// The places at which declarations and their attributes begin.
    beginnings: Vec<usize>,
}

impl<'t> Parser<'t> {
    /// Returns the token `ahead` places after the current one.
    fn peek(&self, ahead: usize) -> Token {
        let last = self.tokens.len() - 1;
        self.tokens[(self.position + ahead).min(last)]
    }

    fn kind(&self) -> TokenKind {
        self.peek(0).kind
    }

    fn text_of(&self, token: Token) -> &'t str {
        &self.text[token.start..token.end]
    }

    fn span_of(&self, token: Token) -> Span {
        Span::new(self.file, token.start, token.end)
    }

    fn here(&self) -> Span {
        self.span_of(self.peek(0))
    }

    /// Returns the place of the previous token.
    fn before(&self) -> Span {
        self.span_of(self.tokens[self.position.saturating_sub(1).min(self.tokens.len() - 1)])
    }

    fn advance(&mut self) -> Token {
        let token = self.peek(0);
        if token.kind != TokenKind::End {
            self.position += 1;
        }
        token
    }

    fn at(&self, kind: TokenKind) -> bool {
        self.kind() == kind
    }

    fn at_end(&self) -> bool {
        self.at(TokenKind::End)
    }

    /// Returns whether the current token is this word.
    fn at_word(&self, word: &str) -> bool {
        self.word_ahead(0) == Some(word)
    }

    fn word_ahead(&self, ahead: usize) -> Option<&'t str> {
        let token = self.peek(ahead);
        (token.kind == TokenKind::Word).then(|| self.text_of(token))
    }

    fn eat(&mut self, kind: TokenKind) -> bool {
        let found = self.at(kind);
        if found {
            self.advance();
        }
        found
    }

    fn eat_word(&mut self, word: &str) -> Option<Span> {
        self.at_word(word).then(|| {
            let token = self.advance();
            self.span_of(token)
        })
    }

    fn expect(&mut self, kind: TokenKind, what: &str) -> Parsed<Span> {
        if self.at(kind) {
            let token = self.advance();
            return Ok(self.span_of(token));
        }
        self.unexpected(what)
    }

    /// Reports an unexpected token.
    fn unexpected<T>(&mut self, expected: &str) -> Parsed<T> {
        self.unexpected_but(expected, None)
    }

    /// Reports an unexpected token, with advice.
    fn unexpected_but<T>(&mut self, expected: &str, hint: Option<String>) -> Parsed<T> {
        let token = self.peek(0);
        let strange = self.text_of(token).chars().next().filter(|_| token.kind == TokenKind::Other);
        let found = match token.kind {
            TokenKind::End => "the end of the file".to_owned(),
            TokenKind::Code => "a code block".to_owned(),
            TokenKind::Text => "a string".to_owned(),
            TokenKind::Other => strange.map(shown).unwrap_or_default(),
            _ => format!("`{}`", self.text_of(token)),
        };
        let message = format!("expected {expected}, found {found}");
        // A token that is missing at the start of a line belongs at the end of the previous line.
        let span = if token.first_of_line && self.position > 0 && hint.is_none() {
            let end = self.before().end;
            Span::new(self.file, end, end)
        } else {
            self.span_of(token)
        };
        let label = format!("expected {expected}");
        let diagnostic = Diagnostic::new(Code::Syntax, span, message).label(label);
        self.report(diagnostic.hint_maybe(hint.or(strange.and_then(instead))));
        Err(Failed)
    }

    fn report(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// Parses a name; reports a keyword, and takes it as the name.
    fn name(&mut self, what: &str) -> Parsed<Name> {
        let name = self.declared_name(what)?;
        if is_reserved(&name.text) {
            let text = &name.text;
            let message = format!("`{text}` is a word of the language and cannot be {what}");
            let hint = format!("choose another name, for example `{text}_`");
            self.report(Diagnostic::new(Code::ReservedWord, name.span, message).hint(hint));
        }
        Ok(name)
    }

    /// Parses the name of an element that is declared elsewhere; reports a keyword.
    fn declared_name(&mut self, what: &str) -> Parsed<Name> {
        if !self.at(TokenKind::Word) {
            return self.unexpected(what);
        }
        let token = self.advance();
        Ok(Name { text: self.text_of(token).to_owned(), span: self.span_of(token) })
    }

    /// Parses statements.
    fn code(&mut self) -> Parsed<CodeBlock> {
        self.code_of(CodeKind::Statements)
    }

    fn code_of(&mut self, kind: CodeKind) -> Parsed<CodeBlock> {
        if self.at(TokenKind::OpenBrace) {
            return Ok(self.code_in_braces());
        }
        let span = self.expect(TokenKind::Code, "a code block `{= … =}`")?;
        let text = &self.text[span.start..span.end];
        let start = span.start + 2;
        let end = if text.len() >= 4 && text.ends_with("=}") { span.end - 2 } else { span.end };
        let code = CodeBlock { text: self.text[start..end].to_owned(), span: Span::new(self.file, start, end) };
        if !self.open.contains(&span.start) {
            self.codes.push((code.clone(), kind));
        }
        Ok(code)
    }

    /// Reports code in braces without `=`, and takes all of it, since it contains no declarations.
    fn code_in_braces(&mut self) -> CodeBlock {
        let open = self.here();
        self.skip_brackets();
        let message = "code of the target language stands in `{= … =}`";
        let hint = "write `{=` for this `{`, and `=}` for the `}` that closes it";
        self.report(Diagnostic::new(Code::Syntax, open, message).label("expected `{=`").hint(hint));
        CodeBlock { text: String::new(), span: open }
    }

    /// Takes a bracket and all tokens up to the one that closes it.
    fn skip_brackets(&mut self) {
        let mut depth = 0_usize;
        while !self.at_end() {
            match self.advance().kind {
                TokenKind::OpenBrace | TokenKind::OpenBracket | TokenKind::OpenParenthesis => depth += 1,
                TokenKind::CloseBrace | TokenKind::CloseBracket | TokenKind::CloseParenthesis => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                return;
            }
        }
    }

    /// Returns the word that the user probably meant.
    fn meant(&self, words: &[&'static str]) -> Option<String> {
        did_you_mean(self.word_ahead(0)?, words.iter().copied())
    }

    /// Returns whether an item of the target language begins here, which LF does not know.
    fn at_code(&self) -> bool {
        let behind = self.peek(1);
        self.word_ahead(0).is_some_and(|word| CODE_STARTS.contains(&word))
            && behind.kind == TokenKind::Word
            && !behind.first_of_line
    }

    /// Returns where an item of the target language belongs, if one begins here.
    fn place_of_code(&self) -> Option<String> {
        self.at_code().then(|| "code of the target language stands in `preamble {= … =}`".to_owned())
    }

    /// Parses a string, and returns its text without the quotes.
    fn string(&mut self, what: &str) -> Parsed<Name> {
        let span = self.expect(TokenKind::Text, what)?;
        let text = self.text[span.start..span.end].trim_matches('"').to_owned();
        Ok(Name { text, span })
    }

    /// Parses items between commas up to `close`, which is consumed; a comma before `close` is allowed.
    fn list<T>(
        &mut self,
        close: TokenKind,
        close_text: &str,
        mut item: impl FnMut(&mut Self) -> Parsed<T>,
    ) -> Parsed<Vec<T>> {
        let mut items = Vec::new();
        while !self.at(close) {
            items.push(item(self)?);
            if self.at_separator(close) {
                let message = "`,` stands between the items of a list, and here is `;`";
                self.report(Diagnostic::new(Code::Syntax, self.here(), message).hint("write `,`"));
                self.advance();
            } else if !self.eat(TokenKind::Comma) {
                break;
            }
        }
        self.expect(close, &format!("`,` or `{close_text}`"))?;
        Ok(items)
    }

    /// Returns whether a `;` here stands between items of a list, and does not end the element behind the list.
    fn at_separator(&self, close: TokenKind) -> bool {
        let follows = close == TokenKind::CloseBrace || !self.peek(1).first_of_line;
        self.at(TokenKind::Semicolon) && follows && self.peek(1).kind != TokenKind::End
    }

    /// Runs `inner` one level deeper; too many levels are an error, so that the stack is bounded.
    fn nested<T>(&mut self, inner: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        if self.depth >= DEPTH_MAX {
            let message = format!("this is nested more than {DEPTH_MAX} levels deep");
            let hint = "write the value or the type as a code block `{= … =}`";
            let span = self.here();
            self.report(Diagnostic::new(Code::NestingTooDeep, span, message).hint(hint));
            return Err(Failed);
        }
        self.depth += 1;
        let result = inner(self);
        self.depth -= 1;
        result
    }

    /// Returns whether a declaration of a file begins here, and not an instance or a connection whose name is such a
    /// keyword.
    fn at_file_start(&self) -> bool {
        self.word_ahead(0).is_some_and(|word| FILE_STARTS.contains(&word)) && !self.at_instance_name()
    }

    /// Returns whether the next tokens make the word here the name of an instance, even if it is a keyword.
    fn at_instance_name(&self) -> bool {
        self.at_instance() || self.at_connected_name()
    }

    /// Returns whether the declaration of an instance begins here.
    fn at_instance(&self) -> bool {
        self.peek(1).kind == TokenKind::Equals && self.word_ahead(2) == Some("new")
    }

    /// Returns whether the next tokens make the word here part of a connection.
    fn at_connected_name(&self) -> bool {
        use TokenKind::{Arrow, Comma, Dot, PhysicalArrow};
        self.word_ahead(0).is_some() && matches!(self.peek(1).kind, Arrow | Comma | Dot | PhysicalArrow)
    }

    /// Returns whether a declaration of a reactor begins here, judged by one token.
    fn at_member_start(&self) -> bool {
        if self.at(TokenKind::At) {
            return true;
        }
        let Some(word) = self.word_ahead(0) else { return false };
        MEMBER_STARTS.contains(&word) || self.at_instance()
    }
}
