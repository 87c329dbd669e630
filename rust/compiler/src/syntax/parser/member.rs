// SPDX-License-Identifier: Apache-2.0
//! The declarations in the body of a reactor, except connections and reactions.

use super::super::ast::{
    ActionKind, ActionSyntax, Assignment, Attribute, Direction, Expression, Initialiser, Instantiation, MethodSyntax,
    Name, PortSyntax, ReactionKeyword, ReactionSyntax, ReactorBody, StateSyntax, Timer,
};
use super::super::token::TokenKind;
use super::super::words::MEMBER_STARTS;
use super::{Failed, Parsed, Parser};
use crate::diagnostics::{Code, Diagnostic, Span};

/// The maximum number of reactions in a reactor: each has a level of its own, and the highest number stands for none.
const REACTIONS_MAX: usize = u16::MAX as usize - 1;

impl Parser<'_> {
    /// Parses one declaration, from its first word on; `start` is the beginning of its attributes.
    pub(super) fn member(&mut self, body: &mut ReactorBody, attributes: Vec<Attribute>, start: usize) -> Parsed<()> {
        match self.word_ahead(0) {
            // These come first: a keyword instead of a name is reported by the parsers of names.
            _ if self.at_instance() => {
                let instance = self.instantiation(attributes)?;
                body.instances.push(instance);
            }
            _ if self.at_connected_name() => {
                let connection = self.connection(attributes, start)?;
                body.connections.push(connection);
            }
            Some("preamble" | "private" | "public") => {
                let preamble = self.preamble()?;
                body.preambles.push(preamble);
            }
            Some("state" | "reset") => {
                let state = self.state(attributes)?;
                body.states.push(state);
            }
            Some("const" | "method") => {
                let method = self.method()?;
                body.methods.push(method);
            }
            Some("mutable" | "input" | "output") => {
                let port = self.port(attributes)?;
                body.ports.push(port);
            }
            Some("timer") => {
                let timer = self.timer(attributes)?;
                body.timers.push(timer);
            }
            Some("logical" | "physical" | "action") => {
                let action = self.action(attributes)?;
                body.actions.push(action);
            }
            Some("watchdog") => {
                let (watchdog, handler) = self.watchdog(attributes)?;
                body.actions.push(watchdog);
                // Handlers run before reactions, wherever they stand.
                let handlers = body.reactions.iter().take_while(|it| it.kind == ReactionKeyword::Watchdog).count();
                body.reactions.insert(handlers, handler);
            }
            Some("reaction" | "mutation") => {
                let reaction = self.reaction(attributes)?;
                if body.reactions.len() >= REACTIONS_MAX {
                    return self.too_many(reaction.keyword);
                }
                body.reactions.push(reaction);
            }
            Some(_) if self.peek(1).kind == TokenKind::Equals => {
                let instance = self.instantiation(attributes)?;
                body.instances.push(instance);
            }
            _ if !self.at_code() && self.at_connection() => {
                let connection = self.connection(attributes, start)?;
                body.connections.push(connection);
            }
            _ => {
                let hint = self.place_of_code().or_else(|| self.meant(MEMBER_STARTS));
                return self.unexpected_but("a declaration, a connection or a reaction", hint);
            }
        }
        self.eat(TokenKind::Semicolon);
        Ok(())
    }

    /// Reports that there are too many reactions, and stops parsing.
    fn too_many(&mut self, keyword: Span) -> Parsed<()> {
        let message = format!("this reactor has more than {REACTIONS_MAX} reactions");
        let hint = "divide them among several reactors";
        self.report(Diagnostic::new(Code::TooLarge, keyword, message).hint(hint));
        self.position = self.tokens.len() - 1;
        Err(Failed)
    }

    fn state(&mut self, attributes: Vec<Attribute>) -> Parsed<StateSyntax> {
        let reset = self.eat_word("reset");
        if self.eat_word("state").is_none() {
            return self.unexpected("`state`");
        }
        let name = self.name("the name of a state variable")?;
        let ty = self.type_annotation()?;
        let init = self.initialiser("state variable", &name)?;
        Ok(StateSyntax { mode: self.mode, attributes, reset, name, ty, init })
    }

    fn method(&mut self) -> Parsed<MethodSyntax> {
        let constant = self.eat_word("const").is_some();
        if self.eat_word("method").is_none() {
            return self.unexpected("`method`");
        }
        let name = self.name("the name of a method")?;
        self.expect(TokenKind::OpenParenthesis, "`(`")?;
        let arguments = self.list(TokenKind::CloseParenthesis, ")", |parser| {
            Ok((parser.name("the name of an argument")?, parser.type_annotation()?))
        })?;
        let ty = self.type_annotation()?;
        let code = self.code()?;
        Ok(MethodSyntax { name, constant, arguments, ty, code })
    }

    fn port(&mut self, attributes: Vec<Attribute>) -> Parsed<PortSyntax> {
        let mutable = self.eat_word("mutable").is_some();
        let direction = if self.eat_word("input").is_some() {
            Direction::Input
        } else if !mutable && self.eat_word("output").is_some() {
            Direction::Output
        } else {
            return self.unexpected("`input`");
        };
        let width = self.width()?;
        let what = if direction == Direction::Input { "the name of an input" } else { "the name of an output" };
        let name = self.name(what)?;
        let ty = self.type_annotation()?;
        Ok(PortSyntax { attributes, direction, mutable, width, name, ty })
    }

    fn timer(&mut self, attributes: Vec<Attribute>) -> Parsed<Timer> {
        self.advance();
        let name = self.name("the name of a timer")?;
        let mut values = self.arguments("`,` or `)`", 2)?.into_iter();
        Ok(Timer { mode: self.mode, attributes, name, offset: values.next(), period: values.next() })
    }

    /// Parses `(e, …)` with at most `count` values, if it is here.
    fn arguments(&mut self, expected: &str, count: usize) -> Parsed<Vec<Expression>> {
        let mut values = Vec::new();
        if self.eat(TokenKind::OpenParenthesis) {
            while !self.at(TokenKind::CloseParenthesis) && values.len() < count {
                values.push(self.expression()?);
                if values.len() == count || !self.eat(TokenKind::Comma) {
                    break;
                }
            }
            let expected = if values.len() == count { "`)`" } else { expected };
            self.expect(TokenKind::CloseParenthesis, expected)?;
        }
        Ok(values)
    }

    fn action(&mut self, attributes: Vec<Attribute>) -> Parsed<ActionSyntax> {
        let kind = if self.eat_word("physical").is_some() { ActionKind::Physical } else { ActionKind::Logical };
        if kind == ActionKind::Logical {
            self.eat_word("logical");
        }
        if self.eat_word("action").is_none() {
            return self.unexpected("`action`");
        }
        let name = self.name("the name of an action")?;
        let (mut min_delay, mut min_spacing, mut policy) = (None, None, None);
        if self.eat(TokenKind::OpenParenthesis) && !self.eat(TokenKind::CloseParenthesis) {
            min_delay = Some(self.expression()?);
            if self.eat(TokenKind::Comma) {
                min_spacing = Some(self.expression()?);
                if self.eat(TokenKind::Comma) {
                    policy = Some(self.string("a policy in quotes: \"defer\", \"drop\" or \"replace\"")?);
                }
            }
            self.expect(TokenKind::CloseParenthesis, "`,` or `)`")?;
        }
        let ty = self.type_annotation()?;
        Ok(ActionSyntax { mode: self.mode, attributes, kind, name, min_delay, min_spacing, policy, ty })
    }

    /// Parses a watchdog and its handler.
    fn watchdog(&mut self, attributes: Vec<Attribute>) -> Parsed<(ActionSyntax, ReactionSyntax)> {
        let token = self.advance();
        let keyword = self.span_of(token);
        let name = self.name("the name of a watchdog")?;
        self.expect(TokenKind::OpenParenthesis, "`(` and the timeout")?;
        let timeout = self.expression()?;
        self.expect(TokenKind::CloseParenthesis, "`)`")?;
        let effects = if self.eat(TokenKind::Arrow) { self.effects()? } else { Vec::new() };
        let handler = ReactionSyntax {
            mode: self.mode,
            attributes: Vec::new(),
            keyword,
            kind: ReactionKeyword::Watchdog,
            triggers: vec![name.clone().into()],
            name: Some(name.clone()),
            uses: Vec::new(),
            effects,
            code: Some(self.code()?),
            tardy: None,
            deadline: None,
        };
        let watchdog = ActionSyntax {
            mode: self.mode,
            attributes,
            kind: ActionKind::Watchdog,
            name,
            min_delay: Some(timeout),
            min_spacing: None,
            policy: None,
            ty: None,
        };
        Ok((watchdog, handler))
    }

    /// Reports an argument without the name of its parameter.
    fn unnamed(&mut self, class: &Name, number: usize) -> Parsed<Assignment> {
        let value = self.expression()?;
        let (of, written) = (&class.text, self.slice(value.span));
        let name = self.parameter_of(of, number).unwrap_or("NAME").to_owned();
        let message = "nothing says which parameter has this value";
        let hint = format!("name it: `new {of}({name} = {written})`");
        self.report(Diagnostic::new(Code::Syntax, value.span, message).label("expected `NAME = …`").hint(hint));
        Ok(Assignment { name: Name { text: name, span: value.span }, init: Initialiser { value } })
    }

    /// Returns a parameter of a reactor by its number, if the reactor is declared in this file.
    fn parameter_of(&self, class: &str, number: usize) -> Option<&str> {
        let text = |at: usize| self.tokens.get(at).map(|token| self.text_of(*token)).unwrap_or_default();
        let head = (0..self.tokens.len()).find(|at| text(*at) == "reactor" && text(at + 1) == class)?;
        let open = (head + 2..self.tokens.len()).take_while(|at| text(*at) != "{").find(|at| text(*at) == "(")?;
        let names = (open + 1..self.tokens.len()).take_while(|at| !matches!(text(*at), "{" | "{}"));
        let names =
            names.filter(|at| matches!(text(at - 1), "(" | ",") && matches!(text(at + 1), ":" | "=" | "," | ")"));
        names.map(text).filter(|name| name.starts_with(|c: char| c.is_alphabetic() || c == '_')).nth(number)
    }

    fn instantiation(&mut self, attributes: Vec<Attribute>) -> Parsed<Instantiation> {
        let name = self.name("the name of an instance")?;
        self.expect(TokenKind::Equals, "`=`")?;
        if self.eat_word("new").is_none() {
            return self.unexpected("`new` and the name of a reactor");
        }
        let width = self.width()?;
        let class = self.name("the name of a reactor")?;
        let type_arguments =
            if self.eat(TokenKind::Less) { self.list(TokenKind::Greater, ">", Self::ty)? } else { Vec::new() };
        self.expect(TokenKind::OpenParenthesis, "`(` and the parameters")?;
        let mut number = 0..;
        let arguments = self.list(TokenKind::CloseParenthesis, ")", |parser| {
            parser.assignment(&class, number.next().unwrap_or_default())
        })?;
        let host = self.host()?;
        Ok(Instantiation { mode: self.mode, attributes, name, width, class, type_arguments, arguments, host })
    }

    fn assignment(&mut self, class: &Name, number: usize) -> Parsed<Assignment> {
        let is_named = self.at(TokenKind::Word) && self.peek(1).kind != TokenKind::Comma;
        if !is_named || self.peek(1).kind == TokenKind::CloseParenthesis {
            return self.unnamed(class, number);
        }
        let name = self.name("the name of a parameter")?;
        let init: Option<Initialiser> = self.initialiser("parameter", &name)?;
        match init {
            Some(init) => Ok(Assignment { name, init }),
            None => self.unexpected("`=` and a value"),
        }
    }
}
