// SPDX-License-Identifier: Apache-2.0
//! Types in source text.
#![allow(missing_docs, reason = "fields and variants are called as the grammar calls what they hold")]

use super::expression::Name;
use crate::diagnostics::Span;

/// A type with its place.
#[derive(Clone, Debug)]
pub struct TypeSyntax {
    pub kind: TypeKind,
    pub span: Span,
}

/// The kinds of types.
#[derive(Clone, Debug)]
pub enum TypeKind {
    /// `time`
    Time,
    /// A path with type arguments.
    Path {
        segments: Vec<String>,
        arguments: Vec<TypeSyntax>,
        /// `*` and `[n]` behind it, which belong to C.
        c_suffix: Option<Name>,
    },
    /// `{= … =}`
    Code(String),
}

impl TypeSyntax {
    /// Returns whether it is LF's `time`.
    pub fn is_time(&self) -> bool {
        matches!(self.kind, TypeKind::Time)
    }
}
