// SPDX-License-Identifier: Apache-2.0
//! Connections, and references to ports and actions.

use super::super::ast::{Attribute, ConnectionSyntax, Expression, Name, Reference};
use super::super::token::TokenKind;
use super::super::words::{MEMBER_STARTS, is_reserved};
use super::{Parsed, Parser};
use crate::diagnostics::{Code, Diagnostic, Span};

impl Parser<'_> {
    /// Returns whether a connection begins here: a parenthesis, or a name that is no keyword.
    pub(super) fn at_connection(&self) -> bool {
        if self.at(TokenKind::OpenParenthesis) {
            return true;
        }
        let names = |word| word == "interleaved" || !is_reserved(word);
        self.at_connected_name() || self.word_ahead(0).is_some_and(names)
    }

    pub(super) fn connection(&mut self, attributes: Vec<Attribute>, start: usize) -> Parsed<ConnectionSyntax> {
        let (first, mut iterated) = (self.position, false);
        let left = if self.eat(TokenKind::OpenParenthesis) {
            let left = self.list(TokenKind::CloseParenthesis, ")", |parser| parser.reference("a port"))?;
            iterated = self.eat(TokenKind::Plus);
            left
        } else {
            self.references("a port")?
        };
        let early = self.early_delay()?;
        let behind = self.position;
        let physical = if self.at(TokenKind::PhysicalArrow) {
            let token = self.advance();
            Some(self.span_of(token))
        } else if self.eat(TokenKind::Arrow) {
            None
        } else {
            self.position = first;
            let hint = self.meant(MEMBER_STARTS);
            if hint.is_some() {
                return self.unexpected_but("a declaration, a connection or a reaction", hint);
            }
            self.position = behind;
            return self.unexpected("`->` and the ports to connect to");
        };
        let right = self.references("a port")?;
        let after = if self.eat_word("after").is_some() { Some(self.expression()?) } else { early };
        let serializer = match self.eat_word("serializer") {
            Some(word) => {
                let text = self.string("the name of a serializer in quotes")?;
                Some(Name { span: word.to(text.span), ..text })
            }
            None => None,
        };
        let span = Span::new(self.file, start, self.before().end);
        Ok(ConnectionSyntax { mode: self.mode, attributes, left, iterated, physical, right, after, serializer, span })
    }

    /// Parses a delay before the arrow, and reports it.
    fn early_delay(&mut self) -> Parsed<Option<Expression>> {
        let Some(word) = self.eat_word("after") else { return Ok(None) };
        let delay = self.expression()?;
        let message = "`after` comes behind the ports that are connected";
        let hint = format!("write `… -> … after {}`", self.slice(delay.span));
        self.report(Diagnostic::new(Code::Syntax, word.to(delay.span), message).hint(hint));
        Ok(Some(delay))
    }

    pub(super) fn references(&mut self, what: &str) -> Parsed<Vec<Reference>> {
        let mut references = vec![self.reference(what)?];
        while self.eat(TokenKind::Comma) {
            references.push(self.reference(what)?);
        }
        Ok(references)
    }

    /// Parses `variable`, `container.variable`, or one of them in `interleaved( … )`, perhaps with `as alias`.
    pub(super) fn reference(&mut self, what: &str) -> Parsed<Reference> {
        let start = self.here();
        let interleaved = self.at_word("interleaved") && self.peek(1).kind == TokenKind::OpenParenthesis;
        if interleaved {
            self.advance();
            self.advance();
        }
        let first = self.reference_name(what)?;
        let (container, name) =
            if self.eat(TokenKind::Dot) { (Some(first), self.name("the name of a port")?) } else { (None, first) };
        if interleaved {
            self.expect(TokenKind::CloseParenthesis, "`)`")?;
        }
        let alias = if self.eat_word("as").is_some() { Some(self.name("a name for the port")?) } else { None };
        Ok(Reference { container, name, interleaved, alias, transition: None, span: start.to(self.before()) })
    }

    fn reference_name(&mut self, what: &str) -> Parsed<super::Name> {
        // A keyword that begins a declaration is no name here: the text before it is incomplete.
        let declares = matches!(self.peek(1).kind, TokenKind::Word | TokenKind::Equals);
        if self.peek(0).first_of_line && self.at_member_start() && declares {
            return self.unexpected(what);
        }
        if self.peek(1).kind == TokenKind::Dot { self.declared_name(what) } else { self.name(what) }
    }
}
