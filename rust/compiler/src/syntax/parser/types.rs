// SPDX-License-Identifier: Apache-2.0
//! Types.

use super::super::ast::{Name, Type, TypeKind, Width, WidthTerm};
use super::super::token::Kind;
use super::super::words::is_reserved;
use super::{Parsed, Parser};
use crate::languages::CodeKind;

impl Parser<'_> {
    /// `: T`, if it is here.
    pub(super) fn type_annotation(&mut self) -> Parsed<Option<Type>> {
        if self.eat(Kind::Colon) {
            return Ok(Some(self.ty()?));
        }
        let other =
            matches!(self.peek(1).kind, Kind::Equals | Kind::Dot | Kind::Comma | Kind::Arrow | Kind::PhysicalArrow);
        let forgotten = self.word_ahead(0).is_some_and(|word| !is_reserved(word)) && !self.peek(0).first_of_line;
        if forgotten && !other { self.unexpected("`:` before the type") } else { Ok(None) }
    }

    pub(super) fn ty(&mut self) -> Parsed<Type> {
        self.nested(Self::type_here)
    }

    fn type_here(&mut self) -> Parsed<Type> {
        let start = self.here();
        let kind = match self.word_ahead(0) {
            _ if self.at(Kind::Code) => TypeKind::Code(self.code_of(CodeKind::Type)?.text),
            Some("time") => {
                self.advance();
                TypeKind::Time
            }
            Some(_) => self.path_type()?,
            None => return self.unexpected("a type"),
        };
        Ok(Type { kind, span: start.to(self.before()) })
    }

    fn path_type(&mut self) -> Parsed<TypeKind> {
        let mut segments = vec![self.name("a type")?.text];
        while self.eat(Kind::Dot) || self.eat(Kind::DoubleColon) {
            segments.push(self.name("a type")?.text);
        }
        let arguments = if self.eat(Kind::Less) { self.list(Kind::Greater, ">", Self::ty)? } else { Vec::new() };
        let c_suffix = self.c_suffix()?;
        Ok(TypeKind::Path { segments, arguments, c_suffix })
    }

    /// `*` and `[n]`, which other targets have behind a type.
    fn c_suffix(&mut self) -> Parsed<Option<Name>> {
        let start = self.here();
        let mut found = false;
        while self.eat(Kind::Star) {
            found = true;
        }
        if self.eat(Kind::OpenBracket) {
            found = true;
            self.eat(Kind::Int);
            self.expect(Kind::CloseBracket, "`]`")?;
        }
        let span = start.to(self.before());
        let text = || self.slice(span).split_whitespace().collect();
        Ok(found.then(|| Name { text: text(), span }))
    }

    /// `[ … ]` before the name of a port or of an instance's class; terms joined by `+`.
    pub(super) fn width(&mut self) -> Parsed<Option<Width>> {
        if !self.at(Kind::OpenBracket) {
            return Ok(None);
        }
        let start = self.here();
        self.advance();
        let mut terms = Vec::new();
        while !self.at(Kind::CloseBracket) {
            terms.push(self.width_term()?);
            if !self.eat(Kind::Plus) {
                break;
            }
        }
        self.expect(Kind::CloseBracket, "`+` or `]`")?;
        Ok(Some(Width { terms, span: start.to(self.before()) }))
    }

    fn width_term(&mut self) -> Parsed<WidthTerm> {
        if self.at_word("widthof") && self.peek(1).kind == Kind::OpenParenthesis {
            self.advance();
            self.advance();
            let port = self.reference("a port")?;
            self.expect(Kind::CloseParenthesis, "`)`")?;
            return Ok(WidthTerm::WidthOf(port));
        }
        match self.kind() {
            Kind::Int | Kind::Word | Kind::Code => Ok(WidthTerm::Value(self.expression()?)),
            _ => self.unexpected("a width"),
        }
    }
}
