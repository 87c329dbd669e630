// SPDX-License-Identifier: Apache-2.0
//! Reactions.

use super::super::ast::{Attribute, Deadline, Name, Reaction, ReactionKind, Reference, Tardy, Transition};
use super::super::token::Kind;
use super::super::words::is_reserved;
use super::{Parsed, Parser};
use crate::diagnostics::{Code, Diagnostic};

impl Parser<'_> {
    pub(super) fn reaction(&mut self, attributes: Vec<Attribute>) -> Parsed<Reaction> {
        let token = self.advance();
        let keyword = self.span_of(token);
        let kind = if self.text_of(token) == "mutation" { ReactionKind::Mutation } else { ReactionKind::Reaction };
        let name = if self.at(Kind::Word) { Some(self.name("the name of a reaction")?) } else { None };
        self.expect(Kind::OpenParenthesis, "`(` and the triggers")?;
        let triggers = self.list(Kind::CloseParenthesis, ")", Self::trigger)?;
        let uses = if self.at_use() { self.references("a port or an action")? } else { Vec::new() };
        let effects = if self.eat(Kind::Arrow) { self.effects()? } else { Vec::new() };
        let code = if self.at(Kind::Code) { Some(self.code()?) } else { None };
        let mut reaction = Reaction {
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

    /// A name after the triggers belongs to the uses unless it begins something else.
    fn at_use(&self) -> bool {
        let Some(word) = self.word_ahead(0) else { return false };
        let other = matches!(self.peek(1).kind, Kind::Equals | Kind::OpenParenthesis) && word != "interleaved";
        (!is_reserved(word) && !other) || (word == "interleaved" && self.peek(1).kind == Kind::OpenParenthesis)
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
        while self.eat(Kind::Comma) {
            effects.push(self.effect()?);
        }
        Ok(effects)
    }

    /// A port or action, or `reset(mode)` or `history(mode)`.
    fn effect(&mut self) -> Parsed<Reference> {
        let start = self.here();
        let transition = match self.word_ahead(0) {
            Some("reset") => Transition::Reset,
            _ => Transition::History,
        };
        if !matches!(self.word_ahead(0), Some("reset" | "history")) || self.peek(1).kind != Kind::OpenParenthesis {
            return self.reference("a port, an action or a mode");
        }
        self.advance();
        self.advance();
        let name = self.name("the name of a mode")?;
        self.expect(Kind::CloseParenthesis, "`)`")?;
        let span = start.to(self.before());
        Ok(Reference { container: None, name, interleaved: false, alias: None, transition: Some(transition), span })
    }

    /// `STP(…)`, `STAA(…)`, `tardy` and `deadline(…)` behind the body.
    fn handlers(&mut self, reaction: &mut Reaction) -> Parsed<()> {
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
                    self.expect(Kind::OpenParenthesis, "`(`")?;
                    let value = self.expression()?;
                    self.expect(Kind::CloseParenthesis, "`)`")?;
                    let code = self.code()?;
                    reaction.deadline = Some(Deadline { value, code });
                }
                _ => return Ok(()),
            }
        }
    }

    /// What follows the word `tardy`, `STP` or `STAA`.
    fn tardy(&mut self, word: Name) -> Parsed<Tardy> {
        if word.text == "tardy" {
            let code = if self.at(Kind::Code) { Some(self.code()?) } else { None };
            return Ok(Tardy { word, absent_after: None, code });
        }
        self.expect(Kind::OpenParenthesis, "`(`")?;
        let absent_after = Some(self.expression()?);
        self.expect(Kind::CloseParenthesis, "`)`")?;
        let code = Some(self.code()?);
        Ok(Tardy { word, absent_after, code })
    }
}
