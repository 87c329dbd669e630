// SPDX-License-Identifier: Apache-2.0
//! Reactions.

use super::super::ast::{
    Attribute, DeadlineSyntax, Name, ReactionKeyword, ReactionSyntax, Reference, TardySyntax, Transition,
};
use super::super::token::TokenKind;
use super::super::words::is_reserved;
use super::{Parsed, Parser};
use crate::diagnostics::{Code, Diagnostic};

impl Parser<'_> {
    pub(super) fn reaction(&mut self, attributes: Vec<Attribute>) -> Parsed<ReactionSyntax> {
        let token = self.advance();
        let keyword = self.span_of(token);
        let kind =
            if self.text_of(token) == "mutation" { ReactionKeyword::Mutation } else { ReactionKeyword::Reaction };
        let name = if self.at(TokenKind::Word) { Some(self.name("the name of a reaction")?) } else { None };
        self.expect(TokenKind::OpenParenthesis, "`(` and the triggers")?;
        let triggers = self.list(TokenKind::CloseParenthesis, ")", Self::trigger)?;
        let uses = if self.at_use() { self.references("a port or an action")? } else { Vec::new() };
        let effects = if self.eat(TokenKind::Arrow) { self.effects()? } else { Vec::new() };
        let has_body = matches!(self.kind(), TokenKind::Code | TokenKind::OpenBrace);
        let code = if has_body { Some(self.code()?) } else { None };
        let mut reaction = ReactionSyntax {
            mode: self.mode,
            attributes,
            keyword,
            kind,
            name,
            triggers,
            uses,
            effects,
            code,
            tardy: None,
            deadline: None,
        };
        self.handlers(&mut reaction)?;
        Ok(reaction)
    }

    /// Returns whether a use is here: a name after the triggers, unless it begins another element.
    fn at_use(&self) -> bool {
        let Some(word) = self.word_ahead(0) else { return false };
        let other =
            matches!(self.peek(1).kind, TokenKind::Equals | TokenKind::OpenParenthesis) && word != "interleaved";
        (!is_reserved(word) && !other) || (word == "interleaved" && self.peek(1).kind == TokenKind::OpenParenthesis)
    }

    fn trigger(&mut self) -> Parsed<Reference> {
        if matches!(self.word_ahead(0), Some("startup" | "shutdown" | "reset")) {
            let token = self.advance();
            let span = self.span_of(token);
            return Ok(Name { text: self.text_of(token).to_owned(), span }.into());
        }
        self.reference("a trigger")
    }

    pub(super) fn effects(&mut self) -> Parsed<Vec<Reference>> {
        let mut effects = vec![self.effect()?];
        while self.eat(TokenKind::Comma) {
            effects.push(self.effect()?);
        }
        Ok(effects)
    }

    /// Parses a port or action, or `reset(mode)` or `history(mode)`.
    fn effect(&mut self) -> Parsed<Reference> {
        let start = self.here();
        let transition = match self.word_ahead(0) {
            Some("reset") => Transition::Reset,
            _ => Transition::History,
        };
        if !matches!(self.word_ahead(0), Some("reset" | "history")) || self.peek(1).kind != TokenKind::OpenParenthesis {
            return self.reference("a port, an action or a mode");
        }
        self.advance();
        self.advance();
        let name = self.name("the name of a mode")?;
        self.expect(TokenKind::CloseParenthesis, "`)`")?;
        let span = start.to(self.before());
        Ok(Reference { container: None, name, interleaved: false, alias: None, transition: Some(transition), span })
    }

    /// Parses `STP(…)`, `STAA(…)`, `tardy` and `deadline(…)` behind the body.
    fn handlers(&mut self, reaction: &mut ReactionSyntax) -> Parsed<()> {
        loop {
            let token = self.peek(0);
            match self.word_ahead(0) {
                Some(word @ ("STP" | "STAA" | "tardy")) => {
                    self.advance();
                    let word = Name { text: word.to_owned(), span: self.span_of(token) };
                    let tardy = self.tardy(word)?;
                    if let Some(first) = reaction.tardy.replace(tardy) {
                        let message = "a reaction has one handler for messages that come too late";
                        let diagnostic = Diagnostic::new(Code::Syntax, self.span_of(token), message);
                        self.report(diagnostic.also(first.word.span, "the first one").hint("remove one of them"));
                    }
                }
                Some("deadline") => {
                    self.advance();
                    self.expect(TokenKind::OpenParenthesis, "`(`")?;
                    let value = self.expression()?;
                    self.expect(TokenKind::CloseParenthesis, "`)`")?;
                    let code = self.code()?;
                    reaction.deadline = Some(DeadlineSyntax { value, code });
                }
                Some(word)
                    if !is_reserved(word)
                        && matches!(self.peek(1).kind, TokenKind::OpenParenthesis | TokenKind::Code) =>
                {
                    let hint = self.meant(&["deadline", "STP", "STAA", "tardy", "reaction"]);
                    return self.unexpected_but("a declaration, or a handler of the reaction", hint);
                }
                _ => return Ok(()),
            }
        }
    }

    /// Parses the rest behind the keyword `tardy`, `STP` or `STAA`.
    fn tardy(&mut self, word: Name) -> Parsed<TardySyntax> {
        if word.text == "tardy" {
            let code = if self.at(TokenKind::Code) { Some(self.code()?) } else { None };
            return Ok(TardySyntax { word, absent_after: None, code });
        }
        self.expect(TokenKind::OpenParenthesis, "`(`")?;
        let absent_after = Some(self.expression()?);
        self.expect(TokenKind::CloseParenthesis, "`)`")?;
        let code = Some(self.code()?);
        Ok(TardySyntax { word, absent_after, code })
    }
}
