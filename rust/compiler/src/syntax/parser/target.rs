// SPDX-License-Identifier: Apache-2.0
//! The target declaration with its properties.

use super::super::ast::{ExpressionKind, Name, Property, PropertyKind, PropertyValue, TargetSyntax};
use super::super::token::TokenKind;
use super::{Failed, Parsed, Parser};
use crate::diagnostics::Span;

impl Parser<'_> {
    pub(super) fn target(&mut self) -> Parsed<TargetSyntax> {
        self.advance();
        let name = self.name("the name of a target")?;
        // Errors in the properties have been reported, and the target is known nevertheless.
        let start = self.position;
        let properties = if self.at(TokenKind::OpenBrace) { self.properties() } else { Ok(Vec::new()) };
        let properties = properties.unwrap_or_else(|Failed| {
            self.recover_in_file(start);
            Vec::new()
        });
        self.eat(TokenKind::Semicolon);
        Ok(TargetSyntax { name, properties })
    }

    fn properties(&mut self) -> Parsed<Vec<Property>> {
        self.expect(TokenKind::OpenBrace, "`{`")?;
        self.list(TokenKind::CloseBrace, "}", Self::property)
    }

    fn property(&mut self) -> Parsed<Property> {
        let key = self.property_key()?;
        self.expect(TokenKind::Colon, "`:` and the value of the property")?;
        let value = self.nested(Self::property_value)?;
        Ok(Property { key, value })
    }

    /// Parses words joined by `-` without spaces, or a string.
    fn property_key(&mut self) -> Parsed<Name> {
        if self.at(TokenKind::Text) {
            return self.string("the name of a property");
        }
        let start = self.expect(TokenKind::Word, "the name of a property")?;
        let mut span = start;
        while self.at(TokenKind::Minus)
            && self.peek(0).adjacent
            && self.peek(1).adjacent
            && self.peek(1).kind == TokenKind::Word
        {
            self.advance();
            let token = self.advance();
            span = span.to(self.span_of(token));
        }
        Ok(Name { text: self.text[span.start..span.end].to_owned(), span })
    }

    fn property_value(&mut self) -> Parsed<PropertyValue> {
        let start = self.here();
        let kind = match self.kind() {
            TokenKind::OpenBrace => PropertyKind::Map(self.properties()?),
            TokenKind::OpenBracket => {
                self.advance();
                PropertyKind::List(
                    self.list(TokenKind::CloseBracket, "]", |parser| parser.nested(Self::property_value))?,
                )
            }
            _ if self.at_path() => {
                let span = self.path();
                PropertyKind::Path(self.text[span.start..span.end].to_owned())
            }
            _ => match self.literal_or_time()? {
                Some(ExpressionKind::Literal(literal)) => PropertyKind::Literal(literal),
                Some(ExpressionKind::Time(time)) => PropertyKind::Time(time),
                _ => return self.unexpected("a value"),
            },
        };
        Ok(PropertyValue { kind, span: start.to(self.before()) })
    }

    fn at_path(&self) -> bool {
        match self.kind() {
            TokenKind::Word => {
                !matches!(self.word_ahead(0), Some("true" | "True" | "false" | "False" | "forever" | "never"))
            }
            TokenKind::Dot | TokenKind::Slash | TokenKind::Backslash => true,
            _ => false,
        }
    }

    fn path(&mut self) -> Span {
        let mut span = self.here();
        self.advance();
        loop {
            let token = self.peek(0);
            let part = matches!(
                token.kind,
                TokenKind::Word
                    | TokenKind::Int
                    | TokenKind::Float
                    | TokenKind::Dot
                    | TokenKind::Minus
                    | TokenKind::Slash
                    | TokenKind::Backslash
            );
            if !part || !token.adjacent {
                return span;
            }
            self.advance();
            span = span.to(self.span_of(token));
        }
    }
}
