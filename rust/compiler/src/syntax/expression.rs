// SPDX-License-Identifier: Apache-2.0
//! Values in source text.
#![allow(missing_docs, reason = "fields and variants are called as the grammar calls what they hold")]

use crate::diagnostics::Span;

/// A name with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    pub text: String,
    pub span: Span,
}

/// The text between `{=` and `=}`, and its place without these marks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CodeBlock {
    pub text: String,
    pub span: Span,
}

/// A value with its place.
#[derive(Clone, Debug)]
pub struct Expression {
    pub kind: ExpressionKind,
    pub span: Span,
}

/// The kinds of values.
#[derive(Clone, Debug)]
pub enum ExpressionKind {
    Literal(Literal),
    Time(TimeValue),
    /// A parameter.
    Name(String),
    Code(CodeBlock),
    /// A list in brackets, braces or parentheses.
    List(Vec<Expression>),
}

/// A literal; numbers and strings keep their spelling.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Literal {
    /// A string with its quotes.
    Text(String),
    /// A character with its quotes.
    Character(String),
    Int(String),
    Float(String),
    Bool(bool),
}

/// A number with a unit, or a word for an end of time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TimeValue {
    Interval { negative: bool, digits: String, unit: Name },
    Forever,
    Never,
}

/// The initial value in a declaration.
#[derive(Clone, Debug)]
pub struct Initialiser {
    pub value: Expression,
}
