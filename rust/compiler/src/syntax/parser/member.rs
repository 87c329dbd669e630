// SPDX-License-Identifier: Apache-2.0
//! The declarations in the body of a reactor, except connections and reactions.

use super::super::ast::{
    Action, ActionKind, Assignment, Attribute, Body, Direction, Expression, Initialiser, Instantiation, Method, Port,
    Reaction, ReactionKind, State, Timer,
};
use super::super::token::Kind;
use super::{Parsed, Parser};

impl Parser<'_> {
    /// One declaration, from its first word on; `start` is where its attributes begin.
    pub(super) fn member(&mut self, body: &mut Body, attributes: Vec<Attribute>, start: usize) -> Parsed<()> {
        match self.word_ahead(0) {
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
                let handlers = body.reactions.iter().take_while(|it| it.kind == ReactionKind::Watchdog).count();
                body.reactions.insert(handlers, handler);
            }
            Some("reaction" | "mutation") => {
                let reaction = self.reaction(attributes)?;
                body.reactions.push(reaction);
            }
            Some(_) if self.peek(1).kind == Kind::Equals => {
                let instance = self.instantiation(attributes)?;
                body.instances.push(instance);
            }
            _ if self.at_connection() => {
                let connection = self.connection(attributes, start)?;
                body.connections.push(connection);
            }
            _ => return self.unexpected("a declaration, a connection or a reaction"),
        }
        self.eat(Kind::Semicolon);
        Ok(())
    }

    fn state(&mut self, attributes: Vec<Attribute>) -> Parsed<State> {
        let reset = self.eat_word("reset");
        if self.eat_word("state").is_none() {
            return self.unexpected("`state`");
        }
        let name = self.name("the name of a state variable")?;
        let ty = self.type_annotation()?;
        let init = self.initialiser("state variable", &name)?;
        Ok(State { mode: self.mode, attributes, reset, name, ty, init })
    }

    fn method(&mut self) -> Parsed<Method> {
        let constant = self.eat_word("const").is_some();
        if self.eat_word("method").is_none() {
            return self.unexpected("`method`");
        }
        let name = self.name("the name of a method")?;
        self.expect(Kind::OpenParenthesis, "`(`")?;
        let arguments = self.list(Kind::CloseParenthesis, ")", |parser| {
            Ok((parser.name("the name of an argument")?, parser.type_annotation()?))
        })?;
        let ty = self.type_annotation()?;
        let code = self.code()?;
        Ok(Method { name, constant, arguments, ty, code })
    }

    fn port(&mut self, attributes: Vec<Attribute>) -> Parsed<Port> {
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
        Ok(Port { attributes, direction, mutable, width, name, ty })
    }

    fn timer(&mut self, attributes: Vec<Attribute>) -> Parsed<Timer> {
        self.advance();
        let name = self.name("the name of a timer")?;
        let mut values = self.arguments("`,` or `)`", 2)?.into_iter();
        Ok(Timer { mode: self.mode, attributes, name, offset: values.next(), period: values.next() })
    }

    /// `(e, …)` with at most `count` values, if it is here.
    fn arguments(&mut self, expected: &str, count: usize) -> Parsed<Vec<Expression>> {
        let mut values = Vec::new();
        if self.eat(Kind::OpenParenthesis) {
            while !self.at(Kind::CloseParenthesis) && values.len() < count {
                values.push(self.expression()?);
                if values.len() == count || !self.eat(Kind::Comma) {
                    break;
                }
            }
            let expected = if values.len() == count { "`)`" } else { expected };
            self.expect(Kind::CloseParenthesis, expected)?;
        }
        Ok(values)
    }

    fn action(&mut self, attributes: Vec<Attribute>) -> Parsed<Action> {
        let kind = if self.eat_word("physical").is_some() { ActionKind::Physical } else { ActionKind::Logical };
        if kind == ActionKind::Logical {
            self.eat_word("logical");
        }
        if self.eat_word("action").is_none() {
            return self.unexpected("`action`");
        }
        let name = self.name("the name of an action")?;
        let (mut min_delay, mut min_spacing, mut policy) = (None, None, None);
        if self.eat(Kind::OpenParenthesis) && !self.eat(Kind::CloseParenthesis) {
            min_delay = Some(self.expression()?);
            if self.eat(Kind::Comma) {
                min_spacing = Some(self.expression()?);
                if self.eat(Kind::Comma) {
                    policy = Some(self.string("a policy in quotes: \"defer\", \"drop\" or \"replace\"")?);
                }
            }
            self.expect(Kind::CloseParenthesis, "`,` or `)`")?;
        }
        let ty = self.type_annotation()?;
        Ok(Action { mode: self.mode, attributes, kind, name, min_delay, min_spacing, policy, ty })
    }

    /// A watchdog and its handler.
    fn watchdog(&mut self, attributes: Vec<Attribute>) -> Parsed<(Action, Reaction)> {
        let token = self.advance();
        let keyword = self.span_of(token);
        let name = self.name("the name of a watchdog")?;
        self.expect(Kind::OpenParenthesis, "`(` and the timeout")?;
        let timeout = self.expression()?;
        self.expect(Kind::CloseParenthesis, "`)`")?;
        let effects = if self.eat(Kind::Arrow) { self.effects()? } else { Vec::new() };
        let handler = Reaction {
            mode: self.mode,
            attributes: Vec::new(),
            keyword,
            kind: ReactionKind::Watchdog,
            triggers: vec![name.clone().into()],
            name: Some(name.clone()),
            uses: Vec::new(),
            effects,
            code: Some(self.code()?),
            tardy: None,
            deadline: None,
        };
        let watchdog = Action {
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

    fn instantiation(&mut self, attributes: Vec<Attribute>) -> Parsed<Instantiation> {
        let name = self.name("the name of an instance")?;
        self.expect(Kind::Equals, "`=`")?;
        if self.eat_word("new").is_none() {
            return self.unexpected("`new` and the name of a reactor");
        }
        let width = self.width()?;
        let class = self.name("the name of a reactor")?;
        let type_arguments = if self.eat(Kind::Less) { self.list(Kind::Greater, ">", Self::ty)? } else { Vec::new() };
        self.expect(Kind::OpenParenthesis, "`(` and the parameters")?;
        let arguments = self.list(Kind::CloseParenthesis, ")", Self::assignment)?;
        let host = self.host()?;
        Ok(Instantiation { mode: self.mode, attributes, name, width, class, type_arguments, arguments, host })
    }

    fn assignment(&mut self) -> Parsed<Assignment> {
        let name = self.name("the name of a parameter")?;
        let init: Option<Initialiser> = self.initialiser("parameter", &name)?;
        match init {
            Some(init) => Ok(Assignment { name, init }),
            None => self.unexpected("`=` and a value"),
        }
    }
}
