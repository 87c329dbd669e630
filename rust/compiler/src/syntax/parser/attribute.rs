// SPDX-License-Identifier: Apache-2.0
//! Elements of both files and reactors: preambles and attributes.

use super::super::ast::{Attribute, AttributeParameter, Name, Preamble};
use super::super::token::TokenKind;
use super::{Parsed, Parser};
use crate::diagnostics::Span;
use crate::lexical::CodeKind;

impl Parser<'_> {
    pub(super) fn preamble(&mut self) -> Parsed<Preamble> {
        if matches!(self.word_ahead(0), Some("private" | "public")) {
            self.advance();
        }
        if self.eat_word("preamble").is_none() {
            return self.unexpected("`preamble`");
        }
        let code = self.code_of(CodeKind::Items)?;
        Ok(Preamble { code })
    }

    pub(super) fn attributes(&mut self) -> Parsed<Vec<Attribute>> {
        let mut attributes = Vec::new();
        while self.at(TokenKind::At) {
            attributes.push(self.attribute()?);
            self.beginnings.push(self.peek(0).start);
        }
        Ok(attributes)
    }

    fn attribute(&mut self) -> Parsed<Attribute> {
        let start: Span = self.here();
        self.advance();
        let token = self.peek(0);
        if token.kind != TokenKind::Word {
            return self.unexpected("the name of an attribute");
        }
        self.advance();
        let name = Name { text: self.text_of(token).to_owned(), span: self.span_of(token) };
        let parameters = if self.eat(TokenKind::OpenParenthesis) {
            self.list(TokenKind::CloseParenthesis, ")", Self::attribute_parameter)?
        } else {
            Vec::new()
        };
        Ok(Attribute { name, parameters, span: start.to(self.before()) })
    }

    fn attribute_parameter(&mut self) -> Parsed<AttributeParameter> {
        let named = self.at(TokenKind::Word) && self.peek(1).kind == TokenKind::Equals;
        let name = if named {
            let name = self.name("the name of a parameter")?;
            self.advance();
            Some(name)
        } else {
            None
        };
        let value = self.expression()?;
        Ok(AttributeParameter { name, value: Some(value) })
    }
}
