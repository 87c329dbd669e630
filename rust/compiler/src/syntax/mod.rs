// SPDX-License-Identifier: Apache-2.0
//! The text of one file as a tree.
//!
//! [`parse`] never fails: what it cannot read becomes a diagnostic, and it goes on at the next declaration. The tree
//! holds the whole 0.14 grammar, also what later stages refuse. Nothing here looks at other files or at meanings.

pub mod ast;
mod comments;
mod expression;
mod parser;
#[cfg(test)]
mod tests;
mod time;
mod token;
mod type_text;
pub(crate) mod words;

pub(crate) use comments::comment_before;
pub(crate) use lf_model::units::{TimeError, nanoseconds};
pub(crate) use parser::parse;
pub(crate) use time::{is_zero, literal_ns};
