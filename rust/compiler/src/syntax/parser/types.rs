// SPDX-License-Identifier: Apache-2.0
//! Types.

use super::super::ast::{Name, TypeKind, TypeSyntax, Width, WidthTerm};
use super::super::token::TokenKind;
use super::super::words::is_reserved;
use super::{Parsed, Parser};
use crate::diagnostics::{Code, Diagnostic, Span};
use crate::lexical::CodeKind;

impl Parser<'_> {
    /// Parses `: T`, if it is here.
    pub(super) fn type_annotation(&mut self) -> Parsed<Option<TypeSyntax>> {
        if self.eat(TokenKind::Colon) {
            return Ok(Some(self.ty()?));
        }
        let other = matches!(
            self.peek(1).kind,
            TokenKind::Equals | TokenKind::Dot | TokenKind::Comma | TokenKind::Arrow | TokenKind::PhysicalArrow
        );
        let forgotten = self.word_ahead(0).is_some_and(|word| !is_reserved(word)) && !self.peek(0).first_of_line;
        if forgotten && !other { self.unexpected("`:` before the type") } else { Ok(None) }
    }

    pub(super) fn ty(&mut self) -> Parsed<TypeSyntax> {
        self.nested(Self::type_here)
    }

    fn type_here(&mut self) -> Parsed<TypeSyntax> {
        let start = self.here();
        let kind = match self.word_ahead(0) {
            _ if self.at(TokenKind::Code) => TypeKind::Code(self.code_of(CodeKind::Type)?.text),
            Some("time") => {
                self.advance();
                TypeKind::Time
            }
            Some(_) if !self.at_foreign_word() => self.path_type()?,
            _ => self.foreign_type(start)?,
        };
        Ok(TypeSyntax { kind, span: start.to(self.before()) })
    }

    /// Returns whether a word is here that begins a type of the target language, with more of it behind.
    fn at_foreign_word(&self) -> bool {
        let behind = self.peek(1);
        match self.word_ahead(0) {
            Some("fn") => behind.kind == TokenKind::OpenParenthesis,
            Some("dyn" | "impl") => self.word_ahead(1).is_some() && !behind.first_of_line,
            _ => false,
        }
    }

    /// Takes a type of the target language that is none of LF, and reports that it is code.
    fn foreign_type(&mut self, start: Span) -> Parsed<TypeKind> {
        let is_sign = matches!(self.kind(), TokenKind::OpenBracket | TokenKind::OpenParenthesis | TokenKind::Star)
            || self.text_of(self.peek(0)).starts_with('&');
        if !is_sign && !self.at_foreign_word() {
            return self.unexpected("a type");
        }
        self.skip_type()?;
        let written = self.slice(start.to(self.before())).to_owned();
        // What has no end runs on to the end of the file.
        let shown = written.lines().next().unwrap_or_default();
        let shown = if shown.len() < written.len() { format!("{shown} …") } else { shown.to_owned() };
        let (message, hint) = if written.chars().filter(|c| !c.is_whitespace()).eq("()".chars()) {
            ("what has no value has no type".to_owned(), "leave the type and its `:` out".to_owned())
        } else {
            (format!("`{shown}` is code of the target language"), format!("write `{{= {shown} =}}`"))
        };
        let span = start.to(self.before());
        self.report(Diagnostic::new(Code::Syntax, span, message).label("expected a type").hint(hint));
        Ok(TypeKind::Code(written))
    }

    /// Takes a type in the target language's notation.
    fn skip_type(&mut self) -> Parsed<()> {
        match self.kind() {
            TokenKind::OpenBracket | TokenKind::OpenParenthesis => self.skip_brackets(),
            TokenKind::Star => {
                self.advance();
                if self.eat_word("const").or_else(|| self.eat_word("mut")).is_none() {
                    return self.unexpected("`const` or `mut`");
                }
                self.nested(Self::skip_type)?;
            }
            TokenKind::Other if self.text_of(self.peek(0)).starts_with('&') => {
                self.advance();
                self.eat(TokenKind::Lifetime);
                self.eat_word("mut");
                self.nested(Self::skip_type)?;
            }
            _ if self.eat_word("fn").is_some() => self.nested(Self::skip_signature)?,
            _ => {
                let is_trait = self.at_foreign_word();
                if is_trait {
                    self.advance();
                }
                self.path_type()?;
                if !is_trait {
                    return Ok(());
                }
                loop {
                    if self.at(TokenKind::OpenParenthesis) {
                        self.nested(Self::skip_signature)?;
                    }
                    if !self.eat(TokenKind::Plus) {
                        break;
                    }
                    if !self.eat(TokenKind::Lifetime) {
                        self.path_type()?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Takes `(…)` and `-> T` of a function's type.
    fn skip_signature(&mut self) -> Parsed<()> {
        self.skip_brackets();
        if self.eat(TokenKind::Arrow) { self.skip_type() } else { Ok(()) }
    }

    fn path_type(&mut self) -> Parsed<TypeKind> {
        let mut segments = vec![self.name("a type")?.text];
        while self.eat(TokenKind::Dot) || self.eat(TokenKind::DoubleColon) {
            segments.push(self.name("a type")?.text);
        }
        let arguments =
            if self.eat(TokenKind::Less) { self.list(TokenKind::Greater, ">", Self::ty)? } else { Vec::new() };
        let c_suffix = self.c_suffix()?;
        Ok(TypeKind::Path { segments, arguments, c_suffix })
    }

    /// Parses `*` and `[n]`, which other targets have behind a type.
    fn c_suffix(&mut self) -> Parsed<Option<Name>> {
        let start = self.here();
        let mut found = false;
        while self.eat(TokenKind::Star) {
            found = true;
        }
        if self.eat(TokenKind::OpenBracket) {
            found = true;
            self.eat(TokenKind::Int);
            self.expect(TokenKind::CloseBracket, "`]`")?;
        }
        let span = start.to(self.before());
        let text = || self.slice(span).split_whitespace().collect();
        Ok(found.then(|| Name { text: text(), span }))
    }

    /// Parses `[ … ]` before the name of a port or of an instance's class; terms joined by `+`.
    pub(super) fn width(&mut self) -> Parsed<Option<Width>> {
        if !self.at(TokenKind::OpenBracket) {
            return Ok(None);
        }
        let start = self.here();
        self.advance();
        let mut terms = Vec::new();
        while !self.at(TokenKind::CloseBracket) {
            terms.push(self.width_term()?);
            if !self.eat(TokenKind::Plus) {
                break;
            }
        }
        self.expect(TokenKind::CloseBracket, "`+` or `]`")?;
        Ok(Some(Width { terms, span: start.to(self.before()) }))
    }

    fn width_term(&mut self) -> Parsed<WidthTerm> {
        if self.at_word("widthof") && self.peek(1).kind == TokenKind::OpenParenthesis {
            self.advance();
            self.advance();
            let port = self.reference("a port")?;
            self.expect(TokenKind::CloseParenthesis, "`)`")?;
            return Ok(WidthTerm::WidthOf(port));
        }
        match self.kind() {
            TokenKind::Int | TokenKind::Word | TokenKind::Code => Ok(WidthTerm::Value(self.expression()?)),
            _ => self.unexpected("a width"),
        }
    }
}
