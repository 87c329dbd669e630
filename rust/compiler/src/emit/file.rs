// SPDX-License-Identifier: Apache-2.0
//! The results of emission: files, or errors.

use core::fmt;

use crate::plan::{Location, Plan};

/// A generated file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct File {
    /// The path below the output folder, with `/` between its parts.
    pub path: String,
    /// The text.
    pub text: String,
}

/// An element of the program that cannot be emitted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EmitError {
    /// The LF file.
    pub path: String,
    /// The line, from 1.
    pub line: usize,
    /// The column, from 1.
    pub column: usize,
    /// The problem.
    pub message: String,
}

impl EmitError {
    pub(crate) fn new(plan: &Plan, at: Location, message: String) -> Self {
        Self { path: plan.path(at).to_owned(), line: at.line, column: at.column, message }
    }
}

impl fmt::Display for EmitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}: error: {}", self.path, self.line, self.column, self.message)
    }
}

impl core::error::Error for EmitError {}
