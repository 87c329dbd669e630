// SPDX-License-Identifier: Apache-2.0
//! Values.

use lf_model::units::unit_ns;

use super::super::ast::{Expression, ExpressionKind, Initialiser, Literal, Name, TimeValue};
use super::super::token::TokenKind;
use super::super::words::is_reserved;
use super::{Parsed, Parser};
use crate::diagnostics::{Code, Diagnostic, Span};
use crate::lexical::CodeKind;

impl Parser<'_> {
    /// Parses `= e`, or the older `(e)` and `{e}`, which get a warning; returns `None` without one of them. `kind` and
    /// `name` are those of the initialised element.
    pub(super) fn initialiser(&mut self, kind: &str, name: &Name) -> Parsed<Option<Initialiser>> {
        if self.eat(TokenKind::Equals) {
            return Ok(Some(Initialiser { value: self.expression()? }));
        }
        if !matches!(self.kind(), TokenKind::OpenParenthesis | TokenKind::OpenBrace) {
            return Ok(None);
        }
        let declared = self.slice(name.span.to(self.before())).to_owned();
        let mut value = self.expression()?;
        let written = self.slice(value.span);
        let written = written[1..written.len() - 1].trim();
        let is_list = matches!(&value.kind, ExpressionKind::List(items) if items.len() > 1);
        let hint = if is_list {
            format!("write `{declared} = {{{written}}}`")
        } else {
            format!("write `{declared} = {written}`")
        };
        let message = format!("the initial value of {kind} `{}` is written in the older form", name.text);
        self.report(Diagnostic::new(Code::OldInitialiser, value.span, message).hint(hint));
        if let ExpressionKind::List(items) = &mut value.kind
            && items.len() == 1
        {
            value = items.remove(0);
        }
        Ok(Some(Initialiser { value }))
    }

    pub(super) fn slice(&self, span: Span) -> &str {
        &self.text[span.start..span.end]
    }

    pub(super) fn expression(&mut self) -> Parsed<Expression> {
        self.nested(Self::expression_here)
    }

    fn expression_here(&mut self) -> Parsed<Expression> {
        let start = self.here();
        let kind = match self.kind() {
            TokenKind::Code => ExpressionKind::Code(self.code_of(CodeKind::Expression)?),
            TokenKind::OpenBrace => self.list_expression(TokenKind::CloseBrace, "}")?,
            TokenKind::OpenBracket => self.list_expression(TokenKind::CloseBracket, "]")?,
            TokenKind::OpenParenthesis => match self.list_expression(TokenKind::CloseParenthesis, ")")? {
                ExpressionKind::List(mut items) if items.len() == 1 => items.remove(0).kind,
                list => list,
            },
            _ => match self.literal_or_time()? {
                Some(kind) => kind,
                None => match self.word_ahead(0) {
                    Some(word) if !is_reserved(word) => {
                        self.advance();
                        ExpressionKind::Name(word.to_owned())
                    }
                    _ => return self.unexpected("a value"),
                },
            },
        };
        Ok(Expression { kind, span: start.to(self.before()) })
    }

    fn list_expression(&mut self, close: TokenKind, close_text: &str) -> Parsed<ExpressionKind> {
        self.advance();
        Ok(ExpressionKind::List(self.list(close, close_text, Self::expression)?))
    }

    /// Parses a literal or a time; takes nothing if neither is here.
    pub(super) fn literal_or_time(&mut self) -> Parsed<Option<ExpressionKind>> {
        let token = self.peek(0);
        let text = self.text_of(token);
        let literal = match token.kind {
            TokenKind::Text => Literal::Text(text.to_owned()),
            TokenKind::Character => Literal::Character(text.to_owned()),
            TokenKind::Int | TokenKind::Float | TokenKind::Minus => return self.number().map(Some),
            TokenKind::Word => match text {
                "true" | "True" => Literal::Bool(true),
                "false" | "False" => Literal::Bool(false),
                "forever" | "never" => {
                    self.advance();
                    let value = if text == "forever" { TimeValue::Forever } else { TimeValue::Never };
                    return Ok(Some(ExpressionKind::Time(value)));
                }
                _ => return Ok(None),
            },
            _ => return Ok(None),
        };
        self.advance();
        Ok(Some(ExpressionKind::Literal(literal)))
    }

    fn number(&mut self) -> Parsed<ExpressionKind> {
        let negative = self.eat(TokenKind::Minus);
        let sign = if negative { "-" } else { "" };
        let token = self.peek(0);
        match token.kind {
            TokenKind::Float => {
                self.advance();
                let text = self.text_of(token);
                // LF allows `.5`, Rust does not.
                let zero = if text.starts_with('.') { "0" } else { "" };
                Ok(ExpressionKind::Literal(Literal::Float(format!("{sign}{zero}{text}"))))
            }
            TokenKind::Int => {
                self.advance();
                let digits = self.text_of(token).to_owned();
                match self.unit() {
                    Some(unit) => Ok(ExpressionKind::Time(TimeValue::Interval { negative, digits, unit })),
                    None => Ok(ExpressionKind::Literal(Literal::Int(format!("{sign}{digits}")))),
                }
            }
            _ => self.unexpected("a number"),
        }
    }

    /// Parses the unit after a number: a word on the same line that does not begin another element.
    fn unit(&mut self) -> Option<Name> {
        let word = self.word_ahead(0)?;
        let token = self.peek(0);
        let begins_other = !token.adjacent
            && unit_ns(word).is_none()
            && matches!(
                self.peek(1).kind,
                TokenKind::Equals | TokenKind::Dot | TokenKind::Arrow | TokenKind::PhysicalArrow
            );
        if token.first_of_line || is_reserved(word) || begins_other {
            return None;
        }
        self.advance();
        Some(Name { text: word.to_owned(), span: self.span_of(token) })
    }
}
