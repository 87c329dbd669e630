// SPDX-License-Identifier: Apache-2.0
//! Blocks of code: their kinds, their ends, and their problems.

use core::ops::Range;

use crate::diagnostics::Code;

/// The end of a code block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BlockEnd {
    /// The position directly after `=}`.
    Found(usize),
    /// Every `=}` lies within a string or comment; parsing continues directly after the first one.
    Hidden {
        /// The position directly after the first one.
        end: usize,
        /// The beginning of the string or comment that hides it.
        by: usize,
    },
    /// There is no `=}` at all.
    Missing,
}

/// The kind of a code block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CodeKind {
    /// The body of a reaction, of a handler or of a method.
    Statements,
    /// A preamble.
    Items,
    /// A value.
    Expression,
    /// A type.
    Type,
    /// A type parameter with its bounds.
    TypeParameter,
}

/// A problem of a code block; places are bytes of its text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CodeProblem {
    /// The code of the diagnostic.
    pub(crate) code: Code,
    /// The place.
    pub(crate) range: Range<usize>,
    /// The sentence, without a full stop.
    pub(crate) message: String,
    /// A further place that explains it.
    pub(crate) also: Option<(Range<usize>, String)>,
    /// The advice.
    pub(crate) hint: Option<String>,
}
