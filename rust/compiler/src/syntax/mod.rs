// SPDX-License-Identifier: Apache-2.0
//! Parses the text of one file to a tree.
//!
//! [`parse`] never fails: unreadable code becomes a diagnostic, and parsing continues at the next declaration. The tree
//! holds the whole 0.14 grammar, including the parts that later stages refuse. This module looks neither at other files
//! nor at meanings.

pub mod ast;
mod comments;
mod expression;
mod lexemes;
mod parser;
#[cfg(test)]
mod tests;
mod time;
mod token;
mod type_text;
pub(crate) mod words;

pub(crate) use comments::comment_before;
pub use lexemes::{Lexeme, LexemeKind, lexemes};
pub(crate) use lf_model::units::{TimeError, nanoseconds};
pub(crate) use parser::parse;
pub(crate) use time::{is_zero, literal_ns};
pub(crate) use token::{Token, TokenKind, tokens};
