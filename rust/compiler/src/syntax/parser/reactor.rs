// SPDX-License-Identifier: Apache-2.0
//! A reactor: its head, and its body as a list of declarations.

use super::super::ast::{
    Attribute, ModeSyntax, Name, ParameterSyntax, Reactor, ReactorBody, ReactorKind, TypeParameter,
};
use super::super::comments::comment_ending;
use super::super::token::TokenKind;
use super::super::words::MEMBER_STARTS;
use super::{Parsed, Parser};
use crate::diagnostics::{Code, Diagnostic, Span};
use crate::lexical::CodeKind;

impl Parser<'_> {
    /// Parses a reactor, from its first word on; `start` is the beginning of its attributes.
    pub(super) fn reactor(&mut self, attributes: Vec<Attribute>, start: usize) -> Parsed<Reactor> {
        let docs = comment_ending(self.text, &self.comments, start);
        let mut kind = ReactorKind::Plain;
        let mut realtime = None;
        let keyword = loop {
            let token = self.peek(0);
            match self.word_ahead(0) {
                Some("main") if kind == ReactorKind::Plain => kind = ReactorKind::Main,
                Some("federated") if kind == ReactorKind::Plain => kind = ReactorKind::Federated,
                Some("realtime") if realtime.is_none() => realtime = Some(self.span_of(token)),
                Some("reactor") => {
                    self.advance();
                    break self.span_of(token);
                }
                _ => {
                    let hint = self.meant(&["reactor"]);
                    return self.unexpected_but("`reactor`", hint);
                }
            }
            self.advance();
        };
        let named = self.at(TokenKind::Word) && !matches!(self.word_ahead(0), Some("at" | "extends"));
        let name = if named { Some(self.name("the name of a reactor")?) } else { None };
        let type_parameters = if self.eat(TokenKind::Less) {
            self.list(TokenKind::Greater, ">", Self::type_parameter)?
        } else {
            Vec::new()
        };
        let parameters = if self.eat(TokenKind::OpenParenthesis) {
            self.list(TokenKind::CloseParenthesis, ")", Self::parameter)?
        } else {
            Vec::new()
        };
        let host = self.host()?;
        let extends = self.extends()?;
        let open = self.expect(TokenKind::OpenBrace, "`{`")?;
        let mut body = ReactorBody::default();
        self.declarations(open, &mut body);
        Ok(Reactor {
            attributes,
            kind,
            realtime,
            keyword,
            name,
            type_parameters,
            parameters,
            host,
            extends,
            body,
            docs,
        })
    }

    /// Parses one or more words, or a code block, of which the first word is the name.
    fn type_parameter(&mut self) -> Parsed<TypeParameter> {
        if self.at(TokenKind::Code) {
            let code = self.code_of(CodeKind::TypeParameter)?;
            let text = code.text.trim_start();
            let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
            let name = Name { text: text[..end].to_owned(), span: code.span };
            return Ok(TypeParameter { name });
        }
        let name = self.name("a type parameter")?;
        while self.eat(TokenKind::Word) {}
        Ok(TypeParameter { name })
    }

    fn parameter(&mut self) -> Parsed<ParameterSyntax> {
        let attributes = self.attributes()?;
        let name = self.name("the name of a parameter")?;
        let ty = self.type_annotation()?;
        let init = self.initialiser("parameter", &name)?;
        Ok(ParameterSyntax { attributes, name, ty, init })
    }

    fn extends(&mut self) -> Parsed<Vec<Name>> {
        let mut names = Vec::new();
        if self.eat_word("extends").is_some() {
            names.push(self.name("the name of a reactor")?);
            while self.eat(TokenKind::Comma) {
                names.push(self.name("the name of a reactor")?);
            }
        }
        Ok(names)
    }

    /// Parses the declarations up to `}`; `open` is the `{`.
    fn declarations(&mut self, open: Span, body: &mut ReactorBody) {
        loop {
            if self.eat(TokenKind::CloseBrace) {
                return;
            }
            if self.at_end() || self.at_file_start() {
                // A comment or a code block without an end takes the brace with it, and so does skipped text.
                let taken = |code| matches!(code, Code::UnterminatedCode | Code::UnterminatedComment | Code::TooLarge);
                if self.at_end() && self.diagnostics.iter().any(|entry| taken(entry.code)) {
                    return;
                }
                let what = if self.mode.is_some() { "mode" } else { "reactor" };
                let message = format!("the body of this {what} has no end");
                let hint = "close it with `}`";
                self.report(Diagnostic::new(Code::Syntax, open, message).label("opened here").hint(hint));
                return;
            }
            let start = self.position;
            if self.body_member(body).is_err() {
                self.recover_in_body(start);
            }
        }
    }

    fn body_member(&mut self, body: &mut ReactorBody) -> Parsed<()> {
        if self.eat(TokenKind::Semicolon) {
            return Ok(());
        }
        let start = self.peek(0).start;
        self.beginnings.push(start);
        let attributes = self.attributes()?;
        match self.word_ahead(0).filter(|_| !self.at_instance_name()) {
            Some("mode" | "initial") if self.mode.is_none() => self.mode(body)?,
            Some(
                "mode" | "initial" | "input" | "output" | "mutable" | "method" | "const" | "preamble" | "private"
                | "public",
            ) if self.mode.is_some() => return self.unexpected("a declaration that modes have"),
            _ => self.member(body, attributes, start)?,
        }
        Ok(())
    }

    fn mode(&mut self, body: &mut ReactorBody) -> Parsed<()> {
        let start = self.here();
        let initial = self.eat_word("initial").is_some();
        if self.eat_word("mode").is_none() {
            return self.unexpected("`mode`");
        }
        let name = if self.at(TokenKind::OpenBrace) { None } else { Some(self.name("the name of a mode")?) };
        let span = start.to(self.before());
        let open = self.expect(TokenKind::OpenBrace, "`{`")?;
        self.mode = Some(body.modes.len());
        body.modes.push(ModeSyntax { name, initial, span });
        self.declarations(open, body);
        self.mode = None;
        Ok(())
    }

    /// Skips to the next declaration, over nested braces, taking at least one token since `start`.
    fn recover_in_body(&mut self, start: usize) {
        let mut depth = 0_usize;
        if self.position == start && !self.at(TokenKind::CloseBrace) {
            self.advance();
        }
        while !self.at_end() && !self.at_file_start() {
            match self.kind() {
                TokenKind::OpenBrace => depth += 1,
                TokenKind::CloseBrace | TokenKind::Semicolon if depth == 0 => return,
                TokenKind::CloseBrace => depth -= 1,
                _ if depth == 0 && self.at_member_start() => return,
                // This includes a declaration with a misspelt keyword.
                _ if depth == 0 && self.peek(0).first_of_line && self.meant(MEMBER_STARTS).is_some() => return,
                _ => {}
            }
            self.advance();
        }
    }
}
