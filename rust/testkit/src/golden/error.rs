// SPDX-License-Identifier: Apache-2.0
//! The reason why a recording was not loaded.

use std::fmt;

/// The reason why a recording was not loaded, with its file.
#[derive(Debug)]
pub struct GoldenError {
    /// The file, if it is known.
    pub file: String,
    /// The defect.
    pub reason: String,
}

impl GoldenError {
    pub(crate) fn new(file: &str, reason: impl fmt::Display) -> Self {
        Self { file: file.to_owned(), reason: reason.to_string() }
    }
}

impl fmt::Display for GoldenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.file, self.reason)
    }
}

impl std::error::Error for GoldenError {}
