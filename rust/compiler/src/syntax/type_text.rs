// SPDX-License-Identifier: Apache-2.0
//! Types as they are written, and as Rust spells them.

use crate::diagnostics::Span;

/// Rust's type for LF's `time`.
pub(crate) const DURATION: &str = "core::time::Duration";

/// A type with its place.
#[derive(Clone, Debug)]
pub(crate) struct Type {
    pub(crate) kind: TypeKind,
    pub(crate) span: Span,
}

/// The kinds of types.
#[derive(Clone, Debug)]
pub(crate) enum TypeKind {
    /// `time`
    Time,
    /// A path with type arguments.
    Path {
        segments: Vec<String>,
        arguments: Vec<Type>,
        /// `*` and `[n]` behind it, which are C.
        c_suffix: Option<Span>,
    },
    /// `{= … =}`
    Code(String),
}

impl Type {
    /// The type in Rust's spelling.
    pub(crate) fn rust(&self) -> String {
        match &self.kind {
            TypeKind::Time => DURATION.to_owned(),
            TypeKind::Code(text) => text.split_whitespace().collect::<Vec<_>>().join(" "),
            TypeKind::Path { segments, arguments, .. } => {
                let mut text = segments.join("::");
                if !arguments.is_empty() {
                    let arguments: Vec<_> = arguments.iter().map(Type::rust).collect();
                    text = format!("{text}<{}>", arguments.join(", "));
                }
                text
            }
        }
    }

    /// Whether it is LF's `time`.
    pub(crate) fn is_time(&self) -> bool {
        matches!(self.kind, TypeKind::Time)
    }
}
