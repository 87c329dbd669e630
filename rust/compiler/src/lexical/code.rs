// SPDX-License-Identifier: Apache-2.0
//! Blocks of code: what they are for, where they end, and what is wrong with them.

use core::ops::Range;

use crate::diagnostics::Code;

/// The end of a code block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BlockEnd {
    /// The position directly after `=}`.
    Found(usize),
    /// Every `=}` lies within a string or comment; the position directly after the first one, to go on from there.
    Hidden {
        /// Directly after the first one.
        end: usize,
        /// Where the string or comment begins that it lies in.
        by: usize,
    },
    /// There is no `=}` at all.
    Missing,
}

/// What a code block is for.
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

/// What is wrong with a code block; places are bytes of its text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CodeProblem {
    /// What is reported.
    pub(crate) code: Code,
    /// Where it is.
    pub(crate) range: Range<usize>,
    /// One sentence without a full stop.
    pub(crate) message: String,
    /// A further place that explains it.
    pub(crate) also: Option<(Range<usize>, String)>,
    /// What to do about it.
    pub(crate) hint: Option<String>,
}
